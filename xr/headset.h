// A headset behind five verbs: poll, begin, locate, end, close. No word of OpenXR leaves the room.
//
//     for (;;) {
//         const News news = headset->poll();
//         if (news.phase == Phase::over) break;
//         if (news.phase != Phase::running) continue;  // poll() has slept a little
//         const Tick tick = headset->begin();          // waits for the display
//         const Sight sight = headset->locate();       // eyes and hands at tick.time
//         ... draw sight.targets where sight.draw ...
//         headset->end({...});
//     }
//     headset->close();
//
// One thread calls all of them, and its GL context is the headset's (make_current()).
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/base/errors.h"
#include "host/hands/hands.h"

namespace knead {

// No loader, no runtime, no headset, or one that lacks what is needed; the message says which.
struct HeadsetError : ResourceError {
    using ResourceError::ResourceError;
};

enum class GlBinding { automatic, egl, glx, wgl };
enum class Floor { seated, standing };  // where the origin is: the eyes at the start; the floor

struct HeadsetOptions {
    GlBinding binding = GlBinding::automatic;
    Floor floor = Floor::seated;
    double rate = 0;           // of the display, asked for [1/s]; 0: the runtime's own
    bool see_through = false;  // the world behind the clay, where the runtime can
    double patience = 20;      // how long a lost runtime is waited for [s]
    double nap = 0.02;         // poll() sleeps so long where no frame is to be drawn [s]
};

enum class Phase { waiting, running, over };

// What is new since the last poll().
struct HeadsetEvents {
    Phase phase = Phase::waiting;
    bool visible = false, focused = false;
    bool worn = true;                   // false: the headset was taken off
    bool lost = false;                  // there is no session; a new one is waited for
    bool renewed = false;               // a new session began: all hands are to be taken for new
    bool recentred = false;             // the origin has moved
    double rate = 0;                    // of the display [1/s]; 0: not known
    std::vector<std::string> messages;  // for people, of the runtime or on its losses
    std::string reason;                 // of Phase::over; "": the user has left
};

struct FrameTiming {
    // When the frame will be seen [s]; rises from frame to frame, also over lost sessions. 0: the
    // first frame.
    double time = 0;
    double period = 0;  // from frame to frame [s]
    bool draw = false;  // false: nothing would be seen; end() submits nothing
};

// Angles from the gaze to the frustum's sides [rad]: left and down are negative as a rule.
struct FieldOfView {
    float left, right, up, down;
};
struct EyePlace {
    Joint<float> pose;  // looks along -z, y up [m]
    FieldOfView field;
};
// Where an eye is drawn: GL textures of the headset, valid until end(). Row 0 is the lowest.
struct EyeTexture {
    unsigned colour = 0, depth = 0;  // depth 0: the runtime takes none
    int width = 0, height = 0;
    bool srgb = false;  // colour is stored as sRGB: write linear, with GL_FRAMEBUFFER_SRGB
};

// What a hand's joints come from.
enum class HandFrom { nothing, cameras, controller, posed };  // posed: by us, from a grip
struct TrackedHand {
    Hand hand;  // at the frame's time, in the origin's frame; not tracked: lost
    HandFrom from = HandFrom::nothing;
    float pinch = 0, grasp = 0;  // 0 open to 1 closed, of a controller or the runtime's own gesture
    bool holds = false;          // a controller that can vibrate
};

struct HeadsetViews {
    bool located = false;  // eyes are valid, though nobody may see them
    bool draw = false;     // eyes and targets are valid
    std::array<EyePlace, 2> eyes{};
    std::array<EyeTexture, 2> targets{};
    std::array<TrackedHand, side_count> hands{};
};

// A side of a picture drawn at a scale, from 0 to 1 [pixels].
inline int scaled(int side, float scale)
{
    return std::clamp(int(std::lround(scale * float(side))), 1, side);
}

// What was drawn. In the depth textures 0 means the distance near_z along the gaze and 1 far_z, and
// 1 / distance is linear between them; one of the two may be infinite.
struct FrameSubmission {
    bool eyes = false;                   // false: nothing is submitted
    float scale = 1;                     // share of a target's sides, from the lower left corner
    float near_z = 0, far_z = 0;         // [m]; 0: no depth was written
    float vibrate[side_count] = {0, 0};  // 0 to 1, for 20 ms, where a controller is held
};

// The part of an eye's picture that no lens shows: triangles, three corners each, in tangents of
// the angles from the gaze.
struct HiddenArea {
    std::vector<std::array<float, 2>> corners;
};

// What the headset and its runtime are.
struct HeadsetInfo {
    std::string runtime, system, binding, renderer;
    std::vector<std::string> extensions;  // in use
    std::vector<std::string> missing;     // that would be used
    bool hands = false, depth = false, see_through = false, srgb = false;
    Floor floor = Floor::seated;  // where the origin is; seated where the runtime has no floor
    int width = 0, height = 0;    // of an eye [pixels]
    std::array<HiddenArea, 2> hidden;
};

class Headset {
  public:
    // Finds the loader and the runtime, and makes a session. Throws HeadsetError. Its GL context
    // is current when it returns.
    static std::unique_ptr<Headset> open(const HeadsetOptions& options);
    virtual ~Headset() = default;

    virtual HeadsetEvents poll() = 0;
    virtual FrameTiming begin() = 0;
    virtual HeadsetViews locate() = 0;
    virtual void end(const FrameSubmission& drawn) = 0;
    virtual void close() = 0;

    // Asks the runtime to end the session; Phase::over follows.
    virtual void leave() = 0;
    // From the next poll() on the origin is there, if the runtime can.
    virtual void set_floor(Floor floor) = 0;
    // How long before the frame's display time it is [s]; negative: too late, or not known.
    virtual double time_left() = 0;

    virtual const HeadsetInfo& facts() const = 0;
    virtual void make_current() = 0;
    using GlFunction = void (*)();
    using GlAddress = GlFunction (*)(const char*);
    virtual GlAddress gl_address() const = 0;
    virtual int stray_gl_errors() const = 0;  // that calls into the runtime left behind
};

// What is there before a session begins, for people who look for what is missing.
struct RuntimeInfo {
    bool built = false;                      // this program knows OpenXR
    bool loader = false, runtime = false;    // were found; `runtime` answers
    std::string manifest;                    // the file that names the runtime; "": none does
    std::vector<std::string> used, missing;  // extensions: offered, and not
    std::string headset;                     // its name
    std::string reason;  // why there is no headset, and what to do; "": there is one
};
// Makes an instance and asks it for a headset; some runtimes start their programs then. Where no
// file names a runtime, none is started. A runtime that does not answer within `patience` [s] is
// abandoned (host/base/abandonable.h). Throws nothing.
RuntimeInfo runtime_facts(double patience = 10);

}  // namespace knead
