#include "render/hand_skin.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <numeric>

#include "cuda/math/box.h"
#include "cuda/math/rotation.h"
#include "host/surface/surface.h"

namespace knead {
namespace {

constexpr float spacing = 0.0025f;       // lattice spacing of the isosurface [m]
constexpr float shared_within = 0.002f;  // blending distance between primitives [m]
// Finger thickness over the default at equal length: the two sizes at which lay_on() fits `rise`.
constexpr float thin_fingers = 0.8f, thick_fingers = 1.25f;
constexpr float highest_rise = 0.003f;  // [m]

// The rig plus the start of a forearm behind the wrist, two bones wide.
Rig with_forearm(Topology topology, Side side)
{
    Rig rig = hand_rig(topology, side);
    const int joint = int(side) * joint_count + wrist;
    const int first = int(rig.spheres.size());
    const struct {
        float x, y, z, r;
    } spheres[] = {{-0.011f, 0.001f, 0.004f, 0.0165f},
                   {0.011f, 0.001f, 0.004f, 0.0165f},
                   {-0.014f, 0.002f, 0.075f, 0.0190f},
                   {0.014f, 0.002f, 0.075f, 0.0190f}};
    for (const auto& s : spheres) {
        const Vec3<float> c{s.x, s.y, s.z};
        rig.spheres.push_back({{joint, joint, joint, joint}, {1, 0, 0, 0}, {c, c, c, c}, s.r});
    }
    rig.primitives.push_back({3, {first, first + 1, first + 2}, 0});
    rig.primitives.push_back({3, {first + 1, first + 2, first + 3}, 0});
    return rig;
}

// The primitives in the pose of the open hand.
struct Laid {
    std::vector<Sphere<float>> spheres;
    std::vector<Shape<float>> shapes;
};

Laid laid(const Rig& rig, const Hand& open, Side side, Stretch<float> size = {})
{
    Laid out;
    for (const Binding<float>& as_fitted : rig.spheres) {
        const Binding<float> b = stretched(as_fitted, size);
        const auto pose = [&](int j) {
            return open.joints[std::size_t(j - int(side) * joint_count)];
        };
        out.spheres.push_back({centre(b, pose), {}, {}, b.radius, 0});
    }
    for (const Primitive& p : rig.primitives) {
        const auto& s = out.spheres;
        out.shapes.push_back(shape(p.count, s[std::size_t(p.sphere[0])],
                                   s[std::size_t(p.sphere[1])], s[std::size_t(p.sphere[2])]));
    }
    return out;
}

ClosestPoint<float> nearest(const Laid& hand, Vec3<float> p)
{
    ClosestPoint<float> best{1e30f, {0, 1, 0}, 1, 0, 0};
    for (const Shape<float>& s : hand.shapes)
        if (const ClosestPoint<float> f = closest_point(s, p); f.phi < best.phi) best = f;
    return best;
}

// Occupancy of the union: 1/2 on the surface, from 1 inside to 0 outside over two spacings.
Field inside(const Laid& hand)
{
    Box3<float> box{{1, 1, 1}, {-1, -1, -1}};
    for (const Shape<float>& s : hand.shapes) grow(box, Box3<float>{s.low, s.high});
    const auto& [low, high] = box;
    const auto node = [](float x) { return int(std::floor(x / spacing)); };
    Field field;
    field.dx = spacing;
    field.low = {node(low.x) - 3, node(low.y) - 3, node(low.z) - 3};
    field.size = Int3{node(high.x) + 5, node(high.y) + 5, node(high.z) + 5} - field.low;
    const Int3 n = field.size;
    field.value.assign(std::size_t(n.x) * std::size_t(n.y) * std::size_t(n.z), 0);
    for (const Shape<float>& s : hand.shapes) {
        const auto first = [&](float x, int l) { return node(x) - 1 - l; };
        const auto last = [&](float x, int l) { return node(x) + 2 - l; };
        for (int z = first(s.low.z, field.low.z); z <= last(s.high.z, field.low.z); ++z)
            for (int y = first(s.low.y, field.low.y); y <= last(s.high.y, field.low.y); ++y)
                for (int x = first(s.low.x, field.low.x); x <= last(s.high.x, field.low.x); ++x) {
                    const Int3 at = Int3{x, y, z} + field.low;
                    const Vec3<float> p =
                        spacing * Vec3<float>{float(at.x), float(at.y), float(at.z)};
                    const float phi = closest_point(s, p).phi;
                    const float share = clamp(0.5f - phi / (2 * spacing), 0.0f, 1.0f);
                    float& v = field.value[(std::size_t(z) * std::size_t(n.y) + std::size_t(y)) *
                                               std::size_t(n.x) +
                                           std::size_t(x)];
                    v = max(v, share);
                }
    }
    return field;
}

// Indices of the `count` largest shares.
std::vector<int> largest(const std::vector<float>& shares, int count)
{
    std::vector<int> order(shares.size());
    std::iota(order.begin(), order.end(), 0);
    std::partial_sort(order.begin(), order.begin() + count, order.end(), [&](int a, int b) {
        return shares[std::size_t(a)] > shares[std::size_t(b)];
    });
    order.resize(std::size_t(count));
    return order;
}

// Weights of the spheres for a vertex, from the closest points on nearby primitives.
std::vector<float> sphere_shares(const Rig& rig, const Laid& hand, Vec3<float> v)
{
    std::vector<ClosestPoint<float>> near;
    float least = 1e30f;
    for (const Shape<float>& s : hand.shapes) {
        near.push_back(closest_point(s, v));
        least = min(least, near.back().phi);
    }
    std::vector<float> shares(rig.spheres.size(), 0);
    for (std::size_t i = 0; i < near.size(); ++i) {
        const float part = std::exp((least - near[i].phi) / shared_within);
        const float l[3] = {near[i].l0, near[i].l1, near[i].l2};
        for (int k = 0; k < 3; ++k) shares[std::size_t(rig.primitives[i].sphere[k])] += part * l[k];
    }
    return shares;
}

}  // namespace

HandSkin::HandSkin(Topology topology, Side side) : rig_(with_forearm(topology, side))
{
    const Hand open = open_hand(side);
    const Laid hand = laid(rig_, open, side);
    Mesh mesh = isosurface(inside(hand), 0.5f);
    smooth(mesh, Smoothing::taubin, 12);
    triangles_ = mesh.triangles;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        const std::vector<float> shares = sphere_shares(rig_, hand, mesh.vertices[v]);
        const std::vector<int> spheres = largest(shares, most);
        Skinned s{};
        Vec3<float> middle{};
        float all = 0;
        for (const int i : spheres) all += shares[std::size_t(i)];
        std::vector<float> by_joint(joint_count, 0);
        for (int k = 0; k < most; ++k) {
            const std::size_t i = std::size_t(spheres[std::size_t(k)]);
            s.sphere[k] = int(i);
            s.share[k] = shares[i] / all;
            middle = middle + s.share[k] * hand.spheres[i].c;
            const Binding<float>& b = rig_.spheres[i];
            for (int j = 0; j < 4; ++j)
                by_joint[std::size_t(b.joint[j] - int(side) * joint_count)] +=
                    s.share[k] * b.weight[j];
        }
        const std::vector<int> joints = largest(by_joint, 4);
        float sum = 0;
        for (const int j : joints) sum += by_joint[std::size_t(j)];
        for (int k = 0; k < 4; ++k) {
            const int j = joints[std::size_t(k)];
            const Quat<float> back = conjugate(open.joints[std::size_t(j)].q);
            s.joint[k] = int(side) * joint_count + j;
            s.weight[k] = by_joint[std::size_t(j)] / sum;
            s.offset[k] = rotate(back, mesh.vertices[v] - middle);
            s.normal[k] = rotate(back, mesh.normals[v]);
        }
        skinned_.push_back(s);
    }
    lay_on(open, side);
}

// Fits `rise`: for thin or thick fingers the skin would leave a gap to the primitives or cut into
// them.
void HandSkin::lay_on(const Hand& open, Side side)
{
    std::vector<Joint<double>> joints(std::size_t(int(side_count) * joint_count),
                                      {{1, 0, 0, 0}, {0, 0, 0}});
    for (std::size_t j = 0; j < joint_count; ++j)
        joints[std::size_t(int(side) * joint_count) + j] = cast<double>(open.joints[j]);
    const Laid hand = laid(rig_, open, side);
    std::vector<float> off;  // of the default hand's skin [m]
    for (const Vec3<float>& x : posed(joints, 1).vertices) off.push_back(nearest(hand, x).phi);
    for (const int thick : {0, 1}) {
        const Stretch<float> size{thick ? thick_fingers : thin_fingers, 1};
        const Laid other = laid(rig_, open, side, size);
        for (int again = 0; again < 2; ++again) {
            const Mesh mesh = posed(joints, 1, size);
            for (std::size_t v = 0; v < skinned_.size(); ++v) {
                const ClosestPoint<float> f = nearest(other, mesh.vertices[v]);
                float& rise = skinned_[v].rise[thick];
                rise += (size.across * off[v] - f.phi) / max(dot(f.n, mesh.normals[v]), 0.5f);
                rise = clamp(rise, -highest_rise, highest_rise);
            }
        }
    }
}

Mesh HandSkin::posed(const std::vector<Joint<double>>& joints, double zoom,
                     Stretch<float> stretch) const
{
    Mesh mesh;
    mesh.triangles = triangles_;
    mesh.vertices.resize(skinned_.size());
    mesh.normals.resize(skinned_.size());
    const Stretch<float> size{float(zoom) * stretch.across, float(zoom) * stretch.along};
    const float ratio = stretch.across / stretch.along;
    const int thick = ratio > 1;
    const float share = (ratio - 1) / ((thick ? thick_fingers : thin_fingers) - 1);
    const float risen = size.along * clamp(share, 0.0f, 1.0f);
    std::vector<Joint<float>> at;
    std::vector<Mat3<float>> turned;  // half the operations of quaternions
    for (const Joint<double>& j : joints)
        at.push_back(cast<float>(j)), turned.push_back(rotation(at.back().q));
    std::vector<Vec3<float>> centres;
    for (const Binding<float>& b : rig_.spheres)
        centres.push_back(centre(stretched(b, size), [&](int j) { return at[std::size_t(j)]; }));
    for (std::size_t v = 0; v < skinned_.size(); ++v) {
        const Skinned& s = skinned_[v];
        Vec3<float> p{}, n{};
        for (int k = 0; k < most; ++k) p = p + s.share[k] * centres[std::size_t(s.sphere[k])];
        for (int k = 0; k < 4; ++k) {
            const Mat3<float>& Q = turned[std::size_t(s.joint[k])];
            p = p + (s.weight[k] * size.across) * (Q * s.offset[k]);  // scaled as radii
            n = n + s.weight[k] * (Q * s.normal[k]);
        }
        mesh.vertices[v] = p + (risen * s.rise[thick]) * n;
        mesh.normals[v] = n;
    }
    return mesh;
}

const HandSkin& hand_skin(Topology topology, Side side)
{
    static std::mutex mutex;
    static std::map<std::pair<Topology, Side>, std::unique_ptr<HandSkin>> made;
    const std::lock_guard lock(mutex);
    std::unique_ptr<HandSkin>& skin = made[{topology, side}];
    if (!skin) skin = std::make_unique<HandSkin>(topology, side);
    return *skin;
}

}  // namespace knead
