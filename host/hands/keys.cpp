#include "host/hands/keys.h"

#include <algorithm>
#include <cmath>

#include "cuda/math/rotation.h"

namespace knead {
namespace {

using Vec = Vec3<double>;

Vec unit(Vec v) { return (1 / length(v)) * v; }

// Rotation that maps the grasp's pressing direction to `press` and its second direction as closely
// as possible to `along`.
Quat<double> facing(const Grasp& grasp, Vec press, Vec along)
{
    const auto frame = [](Vec a, Vec b) {
        const Vec u = unit(a), w = unit(cross(u, b));
        return Mat3<double>{u, cross(w, u), w};
    };
    return quaternion(frame(press, along) * transpose(frame(grasp.press, grasp.along)));
}

// Centres of the spheres of a held tool, in the wrist's frame.
std::vector<Vec> centres(const Rig& rig, Side side, const Fingers& fingers)
{
    const Pose pose = posed(side, {{1, 0, 0, 0}, {}}, fingers);
    std::vector<Vec> points;
    for (const Binding<float>& b : rig.spheres) {
        Vec c{};
        for (int k = 0; k < 4; ++k) {
            if (b.weight[k] == 0) continue;
            const Joint<double>& j = pose[b.joint[k] - int(side) * joint_count];
            c = c + double(b.weight[k]) * (j.p + rotate(j.q, cast<double>(b.offset[k])));
        }
        points.push_back(c);
    }
    return points;
}

Vec mean(const std::vector<Vec>& points)
{
    Vec sum{};
    for (const Vec& p : points) sum = sum + p;
    return (1 / double(points.size())) * sum;
}

// The two ends of the tool that are furthest apart; first the end on the thumb's side.
std::pair<Vec, Vec> ends(const std::vector<Vec>& points, Side side)
{
    std::pair<Vec, Vec> best{points[0], points[0]};
    for (const Vec& a : points)
        for (const Vec& b : points)
            if (length(a - b) > length(best.first - best.second)) best = {a, b};
    const Hand open = open_hand(side);
    const Vec to_thumb = cast<double>(open.joints[thumb_proximal].p - open.joints[palm].p);
    if (dot(best.first - best.second, to_thumb) < 0) std::swap(best.first, best.second);
    return best;
}

// Normal of the plane of a flat tool.
Vec normal(const Rig& rig, const std::vector<Vec>& c)
{
    const auto& i = rig.primitives[0].sphere;
    return unit(cross(c[i[1]] - c[i[0]], c[i[2]] - c[i[0]]));
}
Vec palmward(Vec v) { return v.y > 0 ? -v : v; }

}  // namespace

Grasp bare(Topology topology, Side side, double ahead)
{
    const Vec middle = cast<double>(open_hand(side).joints[palm].p);
    return {hand_rig(topology, side), {middle.x, middle.y, -ahead}, {0, -1, 0}, {0, 0, -1}};
}

Grasp tips(Topology topology, Side side, const Fingers& fingers)
{
    const Pose pose = posed(side, {{1, 0, 0, 0}, {}}, fingers);
    const Vec between_tips = 0.5 * (pose[thumb_tip].p + pose[index_tip].p);
    return {hand_rig(topology, side), between_tips, unit(between_tips - pose[palm].p), {0, 1, 0}};
}

Grasp stick(Side side, const Fingers& grip)
{
    const Rig rig = tool_rig("rod", side);
    const auto [tip, end] = ends(centres(rig, side, grip), side);
    return {rig, tip, unit(tip - end), {0, 1, 0}};
}

Grasp face(const std::string& tool, Side side, const Fingers& grip)
{
    const Rig rig = tool_rig(tool, side);
    const std::vector<Vec> c = centres(rig, side, grip);
    return {rig, mean(c), palmward(normal(rig, c)), {0, 0, -1}};
}

Grasp edge(const std::string& tool, Side side, const Fingers& grip)
{
    const Rig rig = tool_rig(tool, side);
    const std::vector<Vec> c = centres(rig, side, grip);
    const Vec blade = normal(rig, c), ahead{0, 0, -1};
    const Vec along = unit(ahead - dot(ahead, blade) * blade);
    return {rig, mean(c), palmward(unit(cross(blade, along))), along};
}

void Part::take(const Grasp& grasp, Vec press, Vec along)
{
    grasp_ = grasp;
    q_ = facing(grasp, press, along);
}

void Part::reach(double time, const Fingers& fingers, double gap, Vec slide)
{
    put(time, fingers, distance(fingers, gap, slide), slide);
}

double Part::distance(const Fingers& fingers, double gap, Vec slide) const
{
    double far = 3 + 2 * radius_, near = 0;  // distance of the point from the ball's centre [m]
    for (int i = 0; i < 40; ++i) {
        const double middle = (far + near) / 2;
        (gap_at(fingers, middle, slide) > gap ? far : near) = middle;
    }
    return far;
}

void Part::put(double time, const Fingers& fingers, double distance, Vec slide)
{
    keys_.push_back({time, q_, place(distance, slide), fingers});
}

void Part::stay(double time, const Fingers& fingers, double back)
{
    const Key key = keys_.back();
    keys_.push_back({time, key.q, key.place - back * grasp_.press, fingers});
}

Vec Part::place(double distance, Vec slide) const
{
    return slide - grasp_.point - distance * grasp_.press;
}

double Part::gap_at(const Fingers& fingers, double distance, Vec slide) const
{
    Joint<double> joints[2 * joint_count]{};
    const Pose pose = posed(side_, {{1, 0, 0, 0}, place(distance, slide)}, fingers);
    std::copy(pose.begin(), pose.end(), joints + int(side_) * joint_count);
    return knead::gap(grasp_.rig, joints, {0, 0, 0}, radius_);
}

}  // namespace knead
