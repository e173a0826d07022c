// One OpenXR session and its objects: space, swapchains, hand trackers, actions, frames.
#pragma once
#include <memory>
#include <optional>

#include "xr/actions.h"
#include "xr/hands.h"
#include "xr/session_state.h"
#include "xr/swapchain.h"

namespace knead::xr {

class Session {
  public:
    // Throws XrFailure for a failed call, HeadsetError if no usable swapchain format is offered.
    Session(Instance& instance, Platform& platform, const HeadsetOptions& options);
    // Waits for all GL commands (glFinish) before it destroys the swapchains they may use.
    ~Session() { free_all(); }
    Session(const Session&) = delete;

    // Executes `begin` or `end` and reports the action to `state`; all other actions are the
    // caller's.
    void fulfil(SessionAction duty);
    void request_exit() { instance.api.request_exit.raw(session); }
    XrFrameState wait();
    HeadsetViews locate(const XrFrameState& frame);
    void end(const XrFrameState& frame, const FrameSubmission& drawn);
    HiddenArea hidden_area(int eye);
    double refresh_rate();
    void move_origin();  // to options.floor; only between frames
    void make_current() { platform.make_current(); }
    void describe(HeadsetInfo& facts) const;

    SessionState state;
    int gl_errors = 0;

  private:
    void free_all();
    void finish_gl();
    void create();
    void make_spaces();
    void make_chains();
    void ask_for_rate();
    bool locate_eyes(const XrFrameState& frame, HeadsetViews& frame_views);
    TrackedHand hand(Side side, XrTime time);
    bool open_targets(HeadsetViews& frame_views);  // false: waiting for an image timed out
    void close_targets();
    // Brackets for calls that use GL: some runtimes fail on a pending GL error, leave one, or leave
    // another context current.
    void before_gl();
    void after_gl();

    Instance& instance;
    Platform& platform;
    const HeadsetOptions& options;
    unsigned (*gl_error)() = nullptr;
    void (*gl_finish)() = nullptr;
    XrSession session = XR_NULL_HANDLE;
    XrSpace origin = XR_NULL_HANDLE;
    Floor floor = Floor::seated;  // of the origin
    std::int64_t colour_format = 0, depth_format = 0;
    XrEnvironmentBlendMode blend = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
    std::unique_ptr<Swapchain> colour[2], depth[2];
    std::unique_ptr<Actions> actions;
    std::unique_ptr<HandTrackers> hands;
    XrView views[2];  // last located
};

}  // namespace knead::xr
