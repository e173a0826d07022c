// One OpenXR session and all that hangs on it: spaces, swapchains, hands, actions, frames.
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
    // Throws XrFailure where the runtime refuses, HeadsetError where it offers no usable format.
    Session(Instance& instance, Platform& platform, const HeadsetOptions& options);
    // All GL commands have finished when it begins to free what they may use.
    ~Session() { free_all(); }
    Session(const Session&) = delete;

    // Does what the state asks for where that is to begin or to end; all else is for others.
    void fulfil(SessionAction duty);
    void request_exit() { instance.api.request_exit.raw(session); }
    XrFrameState wait();
    HeadsetViews locate(const XrFrameState& frame);
    void end(const XrFrameState& frame, const FrameSubmission& drawn);
    HiddenArea hidden_area(int eye);
    double refresh_rate();
    void move_origin();  // to where the rule says now; not in a frame
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
    bool locate_eyes(const XrFrameState& frame, HeadsetViews& sight);
    TrackedHand hand(Side side, XrTime time);
    bool open_targets(HeadsetViews& sight);  // false: an image did not come free in time
    void close_targets();
    // Around calls that touch the GL: some runtimes fail where an error was left, or leave one, or
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
    XrView views[2];  // as last located
};

}  // namespace knead::xr
