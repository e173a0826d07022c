#include "xr/session_state.h"

namespace knead::xr {

// True if the OpenXR specification allows the transition to `next`.
bool SessionState::follows(XrState next) const
{
    switch (next) {
        case XrState::unknown:
            return false;
        case XrState::idle:
            return state == XrState::unknown || state == XrState::stopping;
        case XrState::ready:
            return state == XrState::idle;
        case XrState::synchronized:
            return state == XrState::ready || state == XrState::visible;
        case XrState::visible:
            return state == XrState::synchronized || state == XrState::focused;
        case XrState::focused:
            return state == XrState::visible;
        case XrState::stopping:
            return state == XrState::synchronized || state == XrState::ready;
        case XrState::loss_pending:
            return true;
        case XrState::exiting:
            return state == XrState::idle;
    }
    return false;
}

void SessionState::entered(XrState next)
{
    if (!follows(next)) ++odd;
    state = next;
    if (next == XrState::loss_pending) session_lost();
}

SessionAction SessionState::duty() const
{
    if (lost == Lost::instance)
        return leaving ? SessionAction::leave : SessionAction::renew_instance;
    if (lost == Lost::session) return leaving ? SessionAction::leave : SessionAction::renew_session;
    switch (state) {
        case XrState::ready:
            return begun ? SessionAction::nothing : SessionAction::begin;
        case XrState::stopping:
            return begun ? SessionAction::end : SessionAction::nothing;
        case XrState::exiting:
            return SessionAction::leave;
        case XrState::unknown:
        case XrState::idle:
            return leaving ? SessionAction::leave : SessionAction::nothing;
        default:
            return SessionAction::nothing;
    }
}

void SessionState::did(SessionAction what)
{
    if (what == SessionAction::begin) begun = true;
    if (what == SessionAction::end) begun = false;
    if (what == SessionAction::renew_session || what == SessionAction::renew_instance) {
        const bool was = leaving;
        const int before = odd;
        *this = SessionState();
        leaving = was, odd = before;
    }
}

}  // namespace knead::xr
