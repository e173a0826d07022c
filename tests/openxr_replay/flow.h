// The strict side of the runtime, as state machines that know no handle: what may be called when.
#pragma once
#include <deque>
#include <string>

#include "xr/session_state.h"

namespace knead::replay {

// What a call is refused with: the name of an XrResult.
using Refused = std::string;

// A session as its runtime sees it: the states it tells, and when it may begin and end.
class SessionFlow {
  public:
    SessionFlow() { enter(xr::XrState::idle), enter(xr::XrState::ready); }
    Refused begin();
    Refused end();
    Refused request_exit();
    void frame_ended();  // the first makes it visible
    // The headset is taken off; after it has ended it is put on after `polls` empty polls.
    void take_off(int polls);
    void loss_pending() { enter(xr::XrState::loss_pending); }
    void polled_empty();  // an event was asked for, and there was none

    bool running() const { return begun; }
    bool focused() const { return state == xr::XrState::focused; }
    bool visible() const { return focused() || state == xr::XrState::visible; }
    // The states to be told, in order.
    std::deque<xr::XrState> news;

  private:
    void enter(xr::XrState next)
    {
        state = next;
        news.push_back(next);
    }
    void stop();
    xr::XrState state = xr::XrState::unknown;
    bool begun = false, shown = false, exiting = false;
    int asleep = 0;  // polls until it is put on; 0: it is on
};

// xrWaitFrame, xrBeginFrame, xrEndFrame: in this order.
class FrameOrder {
  public:
    bool may_wait() const { return waited == begun; }  // else it blocks
    void wait() { ++waited; }
    Refused begin(bool& discarded);
    Refused may_end() const;
    Refused end();

  private:
    long waited = 0, begun = 0, ended = 0;  // frames
};

// Acquire, wait, release: of the images of one swapchain, oldest first.
class ImageOrder {
  public:
    explicit ImageOrder(int images) : count(images) {}
    Refused acquire(int& index);
    Refused wait();
    Refused release();
    bool ever_acquired() const { return acquired > 0; }
    bool ever_released() const { return released > 0; }
    int last_released() const { return (released - 1) % count; }
    int last_waited() const { return (waited - 1) % count; }
    bool held() const { return acquired > released; }

  private:
    int count;
    int acquired = 0, waited = 0, released = 0;
};

// Whether a name is one of OpenXR's: a-z, 0-9, '-', '_', '.'.
bool is_name(const std::string& name);
// Whether a path is one: "/" and names, none of them only dots.
bool is_path(const std::string& path);

}  // namespace knead::replay
