#include "host/hands/motion.h"

#include <algorithm>

namespace knead {

std::vector<Side> tool_sides(const HandsOptions& hands)
{
    std::vector<Side> sides;
    for (Side side : {left, right})
        if (hands.present[side]) sides.push_back(side);
    return sides;
}

Motion no_motion()
{
    Motion motion;
    motion.from.resize(std::size_t(int(side_count) * joint_count), {{1, 0, 0, 0}, {0, 0, 0}});
    motion.to = motion.from;
    return motion;
}

Motion far_away(Motion motion)
{
    constexpr Vec3<double> up{0, 1000, 0};  // [m]
    for (std::vector<Joint<double>>* joints : {&motion.from, &motion.to})
        for (Joint<double>& j : *joints) j.p = j.p + up;
    return motion;
}

namespace {

// `hands`: pointer to a HandSource or HandStream.
template <class Hands>
MotionSource motion_of(Hands hands, const HandsOptions& options)
{
    return [hands = std::move(hands), options, sides = tool_sides(options)](double from,
                                                                            double to) {
        Motion motion = no_motion();
        float before[side_count], size[side_count];
        hands->sample(from, motion.from.data(), before);
        hands->sample(to, motion.to.data(), size);
        for (Side side : sides)
            motion.active.push_back(size[side] > 0), motion.size.push_back(size[side]);
        motion.stretch = stretches(options, [&](Side side) { return hands->stretch(to, side); });
        return motion;
    };
}

}  // namespace

MotionSource recorded_motion(const HandSource* hands, const HandsOptions& options)
{
    if (!hands) return [](double, double) { return no_motion(); };
    return motion_of(hands, options);
}

MotionSource stream_motion(std::shared_ptr<const HandStream> hands, const HandsOptions& options)
{
    return motion_of(std::move(hands), options);
}

bool move_alike(const HandsOptions& a, const HandsOptions& b)
{
    return a.zoom == b.zoom && length(a.at - b.at) == 0 && a.filter == b.filter &&
           a.present[left] == b.present[left] && a.present[right] == b.present[right];
}

bool any_active(const Motion& motion)
{
    return std::any_of(motion.active.begin(), motion.active.end(), [](char a) { return a != 0; });
}

}  // namespace knead
