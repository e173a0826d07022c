// Interface to a headset in five verbs: poll, begin, locate, end, close. No type of OpenXR appears
// in it.
//
//     for (;;) {
//         const HeadsetEvents events = headset->poll();
//         if (events.phase == Phase::over) break;
//         if (events.phase != Phase::running) continue;  // poll() has slept for `nap`
//         const FrameTiming timing = headset->begin();   // blocks until the next frame
//         const HeadsetViews views = headset->locate();  // eyes and hands at timing.time
//         ... if views.draw, draw views.targets ...
//         headset->end({...});
//     }
//     headset->close();
//
// Not thread-safe: one thread makes all calls, with the headset's GL context current
// (make_current()).
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/base/errors.h"
#include "host/hands/hands.h"

namespace knead {

// Loader, runtime or headset missing, or a required feature unsupported; the message names which.
struct HeadsetError : ResourceError {
    using ResourceError::ResourceError;
};

enum class GlBinding { automatic, egl, glx, wgl };
// Origin of the space: the initial eye position (XR LOCAL) or the floor (STAGE).
enum class Floor { seated, standing };

struct HeadsetOptions {
    GlBinding binding = GlBinding::automatic;
    Floor floor = Floor::seated;
    double rate = 0;           // requested display refresh rate [1/s]; 0: the runtime's default
    bool see_through = false;  // passthrough by alpha blending, if the runtime supports it
    double patience = 20;      // time limit for recovering a lost session or runtime [s]
    double nap = 0.02;         // sleep of poll() while no frame is to be drawn [s]
};

enum class Phase { waiting, running, over };

// State and events since the last poll().
struct HeadsetEvents {
    Phase phase = Phase::waiting;
    bool visible = false, focused = false;
    bool worn = true;                   // false: the headset was taken off
    bool lost = false;                  // no session; a new one is being created
    bool renewed = false;               // a new session began: discard the history of all hands
    bool recentred = false;             // the origin of the space has moved
    double rate = 0;                    // display refresh rate [1/s]; 0: unknown
    std::vector<std::string> messages;  // to show: from the runtime, or on lost sessions
    std::string reason;                 // of Phase::over; "": ended by user or runtime
};

struct FrameTiming {
    // Predicted display time [s], 0 for the first frame; increases monotonically, also across lost
    // sessions.
    double time = 0;
    double period = 0;  // predicted display period [s]
    bool draw = false;  // XrFrameState::shouldRender; false: end() submits no layer
};

// Angles from the view axis to the sides of the frustum [rad]; left and down usually negative
// (XrFovf).
struct FieldOfView {
    float left, right, up, down;
};
struct EyePlace {
    Joint<float> pose;  // [m]; view axis -z, y up
    FieldOfView field;
};
// Render target of one eye: GL textures of the swapchain, valid until end(). Row 0 is the lowest.
struct EyeTexture {
    unsigned colour = 0, depth = 0;  // depth 0: no depth layer
    int width = 0, height = 0;
    bool srgb = false;  // colour format is sRGB: write linear values, with GL_FRAMEBUFFER_SRGB
};

// Source of a hand's joints.
enum class HandFrom {
    nothing,
    cameras,
    controller,
    posed
};  // posed: computed from a controller's grip pose
struct TrackedHand {
    Hand hand;  // at the frame's display time, in the origin's space
    HandFrom from = HandFrom::nothing;
    float pinch = 0, grasp = 0;  // 0 open to 1 closed, from a controller or hand interaction
    bool holds = false;          // the grip pose is active
    // Buttons of a controller, the lower one (A, X, menu) and the upper one (B, Y, trackpad).
    bool lower = false, upper = false;
    std::optional<Joint<float>> aim;  // of the runtime: it points along -z
};

struct HeadsetViews {
    bool located = false;  // eyes are valid, even if the frame is not shown
    bool draw = false;     // eyes and targets are valid
    std::array<EyePlace, 2> eyes{};
    std::array<EyeTexture, 2> targets{};
    std::array<TrackedHand, side_count> hands{};
};

// Side length of a picture drawn at a scale in (0, 1] [pixels]; at least 1.
inline int scaled(int side, float scale)
{
    return std::clamp(int(std::lround(scale * float(side))), 1, side);
}

// Frame submitted by end(). Depth 0 corresponds to distance near_z along the view axis, 1 to far_z;
// between them 1 / distance is linear. One of the two may be infinite.
struct FrameSubmission {
    bool eyes = false;  // false: no layer is submitted
    float scale = 1;    // fraction of a target's sides that was drawn, from the lower left corner
    float near_z = 0, far_z = 0;         // [m]; 0: no depth was written
    float vibrate[side_count] = {0, 0};  // amplitude 0 to 1 of a 20 ms vibration of the controller
};

// Hidden area of an eye (XR_KHR_visibility_mask): triangles, three corners each, in tangents of the
// angles from the view axis.
struct HiddenArea {
    std::vector<std::array<float, 2>> corners;
};

// Properties of the runtime, the headset and the session.
struct HeadsetInfo {
    std::string runtime, system, binding, renderer;
    std::vector<std::string> extensions;  // in use
    std::vector<std::string> missing;     // supported by this program but not offered
    bool hands = false, depth = false, see_through = false, srgb = false;
    Floor floor = Floor::seated;  // origin in use; seated if the runtime offers no STAGE space
    int width = 0, height = 0;    // recommended size of an eye's picture [pixels]
    std::array<HiddenArea, 2> hidden;
};

class Headset {
  public:
    // Loads the OpenXR loader, connects to the runtime and creates a session. On return its GL
    // context is current. Throws HeadsetError.
    static std::unique_ptr<Headset> open(const HeadsetOptions& options);
    virtual ~Headset() = default;

    // After a failed OpenXR call in any of these the next poll() renews the session.
    // Processes events; begins, ends or renews the session. Sleeps `nap` while waiting.
    virtual HeadsetEvents poll() = 0;
    // Waits for the next frame and begins it (xrWaitFrame, xrBeginFrame).
    virtual FrameTiming begin() = 0;
    // Locates eyes and hands at the frame's display time and acquires the targets.
    virtual HeadsetViews locate() = 0;
    // Releases the targets and submits the frame (xrEndFrame).
    virtual void end(const FrameSubmission& drawn) = 0;
    // Destroys session and instance.
    virtual void close() = 0;

    // Requests the end of the session; Phase::over follows.
    virtual void leave() = 0;
    // Moves the origin at the next poll(), if the runtime offers that space.
    virtual void set_floor(Floor floor) = 0;
    // Time left until the frame's display time [s]; negative: too late, or unknown.
    virtual double time_left() = 0;

    virtual const HeadsetInfo& facts() const = 0;
    virtual void make_current() = 0;
    using GlFunction = void (*)();
    using GlAddress = GlFunction (*)(const char*);
    virtual GlAddress gl_address() const = 0;
    virtual int stray_gl_errors() const = 0;  // GL errors raised by calls into the runtime
};

// OpenXR installation, as shown by `knead doctor`.
struct RuntimeInfo {
    bool built = false;                      // this program was built with OpenXR
    bool loader = false, runtime = false;    // loader found; runtime responds
    std::string manifest;                    // manifest of the active runtime; "": none
    std::vector<std::string> used, missing;  // extensions offered and not offered
    std::string headset;                     // name of the headset
    std::string reason;  // why there is no headset, with advice; "": there is one
};
// Creates an instance and queries its system, which makes some runtimes start their service.
// Without a manifest no instance is created. A runtime that does not respond within `patience` [s]
// is abandoned (host/base/abandonable.h). Does not throw.
RuntimeInfo runtime_facts(double patience = 10);

}  // namespace knead
