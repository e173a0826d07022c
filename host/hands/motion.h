// What moves the tools, frame by frame: recorded hands, a script, a tracker, or nothing.
#pragma once
#include <functional>
#include <memory>

#include "host/hands/filter.h"
#include "host/hands/hands_options.h"
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
MotionSource recorded_motion(const HandSource* hands, const HandsOptions& options);
// The same of a stream that goes on; it may be shared.
MotionSource stream_motion(std::shared_ptr<const HandStream> hands, const HandsOptions& options);

// The side of each tool, in the order of the tools.
std::vector<Side> tool_sides(const HandsOptions& hands);

// The size of each tool: a bare hand as its user's, `of(side)`; what is held has its
// own size.
template <class Of>
std::vector<Stretch<float>> stretches(const HandsOptions& options, Of&& of)
{
    std::vector<Stretch<float>> all;
    for (const Side side : tool_sides(options))
        all.push_back(options.held[side].empty() ? of(side) : Stretch<float>{});
    return all;
}

// Whether hands move alike by both rules: at most what they hold is another.
bool move_alike(const HandsOptions& a, const HandsOptions& b);
bool any_active(const Motion& motion);

}  // namespace knead
