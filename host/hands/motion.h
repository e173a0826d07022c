// What moves the tools, frame by frame: recorded hands, a script, a tracker, or nothing.
#pragma once
#include <functional>
#include <memory>

#include "host/hands/filter.h"
#include "host/scene/seed.h"
#include "host/solver/solver.h"

namespace knead {

// The tools' motion in the frame from `from` to `to` [s of the hands' clock]. Asked once a frame,
// in order; each frame begins where the one before ended. Live hands answer with their last sample.
using MotionSource = std::function<Motion(double from, double to)>;

// Hands at rest at the origin, none of them active.
Motion no_motion();
// The same hands, far above all clay.
Motion far_away(Motion motion);
// `hands` must outlive the source; null: no_motion() always.
MotionSource recorded_motion(const HandSource* hands, const HandsRule& rule);
// The same of a stream that goes on; it may be shared.
MotionSource stream_motion(std::shared_ptr<const HandStream> hands, const HandsRule& rule);

// Per tool of a rule, how large it is: a bare hand as its user's, `of(side)`; what is held has its
// own size.
template <class Of>
std::vector<Stretch<float>> stretches(const HandsRule& rule, Of&& of)
{
    std::vector<Stretch<float>> all;
    for (const Side side : tool_sides(rule))
        all.push_back(rule.held[side].empty() ? of(side) : Stretch<float>{});
    return all;
}

// Whether hands move alike by both rules: at most what they hold is another.
bool move_alike(const HandsRule& a, const HandsRule& b);
bool any_active(const Motion& motion);

}  // namespace knead
