// Sources of tool motion: recorded or generated hands, a tracker, or none.
#pragma once
#include <functional>
#include <memory>

#include "host/hands/filter.h"
#include "host/hands/hands_options.h"
#include "host/solver/simulator.h"

namespace knead {

// Returns the tools' motion in the frame from `from` to `to` [s of the hands' clock]. Called once
// per frame, in order; each frame begins at the end of the previous one. Live hands return their
// last sample.
using MotionSource = std::function<Motion(double from, double to)>;

// Hands at rest at the origin, all inactive.
Motion no_motion();
// The same motion, translated to far above the clay.
Motion far_away(Motion motion);
// Motion of a recording. `hands` must outlive the source; null: always no_motion().
MotionSource recorded_motion(const HandSource* hands, const HandsOptions& options);
// Motion of a live stream, which may be shared.
MotionSource stream_motion(std::shared_ptr<const HandStream> hands, const HandsOptions& options);

// Side of each tool, in tool order.
std::vector<Side> tool_sides(const HandsOptions& hands);

// Size of each tool: `of(side)`, the user's hand size, for a bare hand; 1 for a held tool.
template <class Of>
std::vector<Stretch<float>> stretches(const HandsOptions& options, Of&& of)
{
    std::vector<Stretch<float>> all;
    for (const Side side : tool_sides(options))
        all.push_back(options.held[side].empty() ? of(side) : Stretch<float>{});
    return all;
}

// True if both options move the hands in the same way; held tools may differ.
bool move_alike(const HandsOptions& a, const HandsOptions& b);
bool any_active(const Motion& motion);

}  // namespace knead
