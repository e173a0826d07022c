#include "host/ui/arrange.h"

#include <algorithm>

namespace knead {
namespace {

Box3<double> displaced(const Box3<double>& box, Vec3<double> by)
{
    return {box.low + by, box.high + by};
}

bool meet(const Box3<double>& a, const Box3<double>& b, double gap)
{
    return a.low.x < b.high.x + gap && b.low.x < a.high.x + gap && a.low.y < b.high.y + gap &&
           b.low.y < a.high.y + gap && a.low.z < b.high.z + gap && b.low.z < a.high.z + gap;
}

bool between(const Box3<double>& box, const Box3<double>& room)
{
    return box.low.x >= room.low.x && box.low.y >= room.low.y && box.low.z >= room.low.z &&
           box.high.x <= room.high.x && box.high.y <= room.high.y && box.high.z <= room.high.z;
}

}  // namespace

Vec3<double> beside(const Surroundings& around, const std::vector<ObjectId>& chosen)
{
    constexpr int farthest = 8;  // widths
    const CommonPlace common = common_place(around.places, chosen);
    if (!common.any()) return {};
    // A box may meet that of its own copy by a rounding.
    const Vec3<double> step =
        common.box.high - common.box.low + 1.001 * Vec3<double>{around.gap, around.gap, around.gap};
    const auto free = [&](Vec3<double> by) {
        for (const ObjectId id : chosen) {
            const ObjectPlace* const one = around.places.find(id);
            if (!one) continue;
            const Box3<double> box = displaced(one->box, by);
            if (!between(box, around.room)) return false;
            for (const ObjectPlace& other : around.places.all)
                if (meet(box, other.box, around.gap)) return false;
        }
        return true;
    };
    for (int n = 1; n <= farthest; ++n)
        for (const Vec3<double> by :
             {Vec3<double>{n * step.x, 0, 0}, Vec3<double>{-n * step.x, 0, 0},
              Vec3<double>{0, 0, n * step.z}, Vec3<double>{0, 0, -n * step.z},
              Vec3<double>{0, n * step.y, 0}})
            if (free(by)) return by;
    return {step.x, 0, 0};
}

Vec3<double> to_middle(const Surroundings& around, const std::vector<ObjectId>& chosen)
{
    const CommonPlace common = common_place(around.places, chosen);
    if (!common.any()) return {};
    const Vec3<double> to =
        0.5 * (around.room.low + around.room.high - (common.box.low + common.box.high));
    Vec3<double> by{to.x, 0, to.z};
    const double clearance = 1.001 * around.gap;
    for (std::size_t tries = 0; tries <= around.places.all.size(); ++tries) {
        double rise = 0;
        for (const ObjectId id : chosen) {
            const ObjectPlace* const one = around.places.find(id);
            for (const ObjectPlace& other : around.places.all)
                if (one && !std::ranges::count(chosen, other.object) &&
                    meet(displaced(one->box, by), other.box, around.gap))
                    rise = std::max(rise, other.box.high.y + clearance - one->box.low.y - by.y);
        }
        by.y += rise;
        if (rise <= 0) break;
    }
    return common.box.high.y + by.y <= around.room.high.y ? by : Vec3<double>{to.x, 0, to.z};
}

}  // namespace knead
