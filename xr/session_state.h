// The life of an OpenXR session, as a state machine that makes no calls: it is told what the
// runtime says and what was done, and answers what is to be done next.
//
//     idle ── ready ── begun: synchronized, visible, focused ── stopping ── idle ── exiting
//
// From anywhere the session, or the whole instance, may be lost.
#pragma once

namespace knead::xr {

// XrSessionState, in its order and by its numbers.
enum class XrState {
    unknown,
    idle,
    ready,
    synchronized,
    visible,
    focused,
    stopping,
    loss_pending,
    exiting
};

enum class SessionAction {
    nothing,
    begin,           // xrBeginSession
    end,             // xrEndSession
    renew_session,   // destroy it, and make another of the same instance
    renew_instance,  // destroy all, and start again
    leave            // destroy all; the runtime, or the user, has ended it
};

class SessionState {
  public:
    void told(XrState state);
    void session_lost() { lost = lost == Lost::instance ? lost : Lost::session; }
    void instance_lost() { lost = Lost::instance; }
    // The user wants to leave: an end that the runtime says afterwards is no fault.
    void wants_to_leave() { leaving = true; }

    SessionAction duty() const;
    // The duty was done. A new session, or a new instance with one, begins anew.
    void did(SessionAction what);

    // Whether frames are to be waited for, begun and ended.
    bool running() const { return begun && lost == Lost::nothing; }
    bool visible() const
    {
        return running() && (state == XrState::visible || state == XrState::focused);
    }
    bool focused() const { return running() && state == XrState::focused; }
    bool is_leaving() const { return leaving; }
    XrState last() const { return state; }
    int strange() const { return odd; }  // times that the runtime broke the order above

  private:
    enum class Lost { nothing, session, instance };
    bool follows(XrState next) const;

    XrState state = XrState::unknown;
    Lost lost = Lost::nothing;
    bool begun = false, leaving = false;
    int odd = 0;
};

}  // namespace knead::xr
