// The life of an OpenXR session, told to a state machine that makes no calls.
#include "xr/session_state.h"

#include <gtest/gtest.h>

namespace knead::xr {
namespace {

// What a runtime says of a headset that is put on, up to `last`.
SessionState running(XrState last = XrState::focused)
{
    SessionState state;
    state.entered(XrState::idle), state.entered(XrState::ready);
    state.did(SessionAction::begin);
    for (const XrState next : {XrState::synchronized, XrState::visible, XrState::focused}) {
        state.entered(next);
        if (next == last) break;
    }
    return state;
}

TEST(SessionState, begins_once_when_it_is_ready_and_then_runs)
{
    SessionState state;
    EXPECT_EQ(state.duty(), SessionAction::nothing);
    state.entered(XrState::idle);
    EXPECT_EQ(state.duty(), SessionAction::nothing);
    state.entered(XrState::ready);
    EXPECT_EQ(state.duty(), SessionAction::begin);
    EXPECT_FALSE(state.running());
    state.did(SessionAction::begin);
    EXPECT_EQ(state.duty(), SessionAction::nothing);
    EXPECT_TRUE(state.running());
    EXPECT_FALSE(state.visible());
    state.entered(XrState::synchronized);
    EXPECT_FALSE(state.visible());
    state.entered(XrState::visible);
    EXPECT_TRUE(state.visible());
    EXPECT_FALSE(state.focused());
    state.entered(XrState::focused);
    EXPECT_TRUE(state.visible());
    EXPECT_TRUE(state.focused());
    EXPECT_EQ(state.strange(), 0);
}

TEST(SessionState, a_headset_taken_off_ends_the_session_and_waits_for_the_next)
{
    SessionState state = running();
    state.entered(XrState::visible), state.entered(XrState::synchronized),
        state.entered(XrState::stopping);
    EXPECT_EQ(state.duty(), SessionAction::end);
    EXPECT_TRUE(state.running()) << "frames go on until it is ended";
    state.did(SessionAction::end);
    EXPECT_FALSE(state.running());
    EXPECT_EQ(state.duty(), SessionAction::nothing);
    state.entered(XrState::idle);
    EXPECT_EQ(state.duty(), SessionAction::nothing);
    state.entered(XrState::ready);
    EXPECT_EQ(state.duty(), SessionAction::begin);
    EXPECT_EQ(state.strange(), 0);
}

TEST(SessionState, leaves_when_the_runtime_or_the_user_wants_to)
{
    SessionState by_runtime = running(XrState::synchronized);
    by_runtime.entered(XrState::stopping);
    by_runtime.did(SessionAction::end);
    by_runtime.entered(XrState::idle);
    by_runtime.entered(XrState::exiting);
    EXPECT_EQ(by_runtime.duty(), SessionAction::leave);

    SessionState by_user = running();
    by_user.wants_to_leave();
    EXPECT_EQ(by_user.duty(), SessionAction::nothing) << "the runtime first stops it";
    by_user.entered(XrState::visible), by_user.entered(XrState::synchronized),
        by_user.entered(XrState::stopping);
    EXPECT_EQ(by_user.duty(), SessionAction::end);
    by_user.did(SessionAction::end);
    by_user.entered(XrState::idle);
    EXPECT_EQ(by_user.duty(), SessionAction::leave);

    SessionState never_begun;
    never_begun.wants_to_leave();
    EXPECT_EQ(never_begun.duty(), SessionAction::leave);
}

TEST(SessionState, a_loss_stops_frames_at_once_and_is_made_good_by_beginning_anew)
{
    for (const SessionAction made_good :
         {SessionAction::renew_session, SessionAction::renew_instance}) {
        SessionState state = running();
        if (made_good == SessionAction::renew_session)
            state.session_lost();
        else
            state.instance_lost();
        EXPECT_FALSE(state.running());
        EXPECT_FALSE(state.visible());
        EXPECT_EQ(state.duty(), made_good);
        state.did(made_good);
        EXPECT_EQ(state.duty(), SessionAction::nothing);
        state.entered(XrState::idle), state.entered(XrState::ready);
        EXPECT_EQ(state.duty(), SessionAction::begin);
        EXPECT_EQ(state.strange(), 0);
    }
}

TEST(SessionState, a_pending_loss_is_a_loss_and_a_lost_instance_outweighs_it)
{
    SessionState state = running();
    state.entered(XrState::loss_pending);
    EXPECT_EQ(state.duty(), SessionAction::renew_session);
    state.instance_lost();
    EXPECT_EQ(state.duty(), SessionAction::renew_instance);
    state.session_lost();
    EXPECT_EQ(state.duty(), SessionAction::renew_instance);
    state.wants_to_leave();
    EXPECT_EQ(state.duty(), SessionAction::leave)
        << "nobody waits for a runtime that is not wanted";
}

TEST(SessionState, wanting_to_leave_outlives_a_new_session)
{
    SessionState state = running();
    state.session_lost();
    state.wants_to_leave();
    state.did(SessionAction::renew_session);
    EXPECT_TRUE(state.is_leaving());
    EXPECT_EQ(state.duty(), SessionAction::leave);
}

TEST(SessionState, what_breaks_the_order_is_counted_and_survived)
{
    SessionState state;
    state.entered(XrState::focused);
    EXPECT_EQ(state.strange(), 1);
    EXPECT_FALSE(state.running()) << "it was never begun";
    state.entered(XrState::idle), state.entered(XrState::ready), state.entered(XrState::ready);
    EXPECT_EQ(state.strange(), 3);
    EXPECT_EQ(state.duty(), SessionAction::begin);
    state.did(SessionAction::begin);
    state.entered(XrState::ready);
    EXPECT_EQ(state.duty(), SessionAction::nothing) << "a session is not begun twice";
    SessionState not_begun;
    not_begun.entered(XrState::stopping);
    EXPECT_EQ(not_begun.duty(), SessionAction::nothing) << "nor ended before it was begun";
}

}  // namespace
}  // namespace knead::xr
