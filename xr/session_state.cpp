#include "xr/session_state.h"

namespace knead::xr {

// Whether the specification lets `next` follow the last state.
bool SessionState::follows(Told next) const
{
    switch (next) {
        case Told::unknown:
            return false;
        case Told::idle:
            return state == Told::unknown || state == Told::stopping;
        case Told::ready:
            return state == Told::idle;
        case Told::synchronized:
            return state == Told::ready || state == Told::visible;
        case Told::visible:
            return state == Told::synchronized || state == Told::focused;
        case Told::focused:
            return state == Told::visible;
        case Told::stopping:
            return state == Told::synchronized || state == Told::ready;
        case Told::loss_pending:
            return true;
        case Told::exiting:
            return state == Told::idle;
    }
    return false;
}

void SessionState::told(Told next)
{
    if (!follows(next)) ++odd;
    state = next;
    if (next == Told::loss_pending) session_lost();
}

Duty SessionState::duty() const
{
    if (lost == Lost::instance) return leaving ? Duty::leave : Duty::renew_instance;
    if (lost == Lost::session) return leaving ? Duty::leave : Duty::renew_session;
    switch (state) {
        case Told::ready:
            return begun ? Duty::nothing : Duty::begin;
        case Told::stopping:
            return begun ? Duty::end : Duty::nothing;
        case Told::exiting:
            return Duty::leave;
        case Told::unknown:
        case Told::idle:
            return leaving ? Duty::leave : Duty::nothing;
        default:
            return Duty::nothing;
    }
}

void SessionState::did(Duty what)
{
    if (what == Duty::begin) begun = true;
    if (what == Duty::end) begun = false;
    if (what == Duty::renew_session || what == Duty::renew_instance) {
        const bool was = leaving;
        const int before = odd;
        *this = SessionState();
        leaving = was, odd = before;
    }
}

}  // namespace knead::xr
