#include "host/session/motion.h"

#include <algorithm>

#include "host/scene/seed.h"

namespace knead {

Motion no_motion()
{
    Motion motion;
    motion.from.resize(std::size_t(int(side_count) * joint_count), {{1, 0, 0, 0}, {0, 0, 0}});
    motion.to = motion.from;
    return motion;
}

MotionSource recorded_motion(const HandSource* hands, const HandsRule& rule)
{
    if (!hands) return [](double, double) { return no_motion(); };
    return [hands, sides = tool_sides(rule)](double from, double to) {
        Motion motion = no_motion();
        float before[side_count], size[side_count];
        hands->sample(from, motion.from.data(), before);
        hands->sample(to, motion.to.data(), size);
        for (Side side : sides)
            motion.active.push_back(size[side] > 0), motion.size.push_back(size[side]);
        return motion;
    };
}

bool any_active(const Motion& motion)
{
    return std::any_of(motion.active.begin(), motion.active.end(), [](char a) { return a != 0; });
}

}  // namespace knead
