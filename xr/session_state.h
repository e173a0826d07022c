// Lifecycle of an OpenXR session as a state machine without calls: inputs are state changes, losses
// and completed actions, output is the next action.
//
//     idle ── ready ── begun: synchronized, visible, focused ── stopping ── idle ── exiting
//
// The session or the instance can be lost in any state.
#pragma once

namespace knead::xr {

// XrSessionState, with the same values.
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
    renew_session,   // destroy the session, create another in the same instance
    renew_instance,  // destroy session and instance, create both anew
    leave            // destroy both; ended by the runtime or the user
};

class SessionState {
  public:
    void entered(XrState state);
    void session_lost() { lost = lost == Lost::instance ? lost : Lost::session; }
    void instance_lost() { lost = Lost::instance; }
    // The user requested the end: from now on the end or loss of the session yields `leave`, not a
    // renewal.
    void wants_to_leave() { leaving = true; }

    SessionAction duty() const;
    // Call when the action has completed. After a renewal the state is that of a new session.
    void did(SessionAction what);

    // True between xrBeginSession and xrEndSession, unless lost: frames must be waited for, begun
    // and ended.
    bool running() const { return begun && lost == Lost::nothing; }
    bool visible() const
    {
        return running() && (state == XrState::visible || state == XrState::focused);
    }
    bool focused() const { return running() && state == XrState::focused; }
    bool is_leaving() const { return leaving; }
    XrState last() const { return state; }
    int strange() const { return odd; }  // state changes that violated the order above

  private:
    enum class Lost { nothing, session, instance };
    bool follows(XrState next) const;

    XrState state = XrState::unknown;
    Lost lost = Lost::nothing;
    bool begun = false, leaving = false;
    int odd = 0;
};

}  // namespace knead::xr
