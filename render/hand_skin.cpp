#include "render/hand_skin.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>

#include "host/surface/surface.h"

namespace knead {
namespace {

constexpr float spacing = 0.0025f;  // of the lattice on which the surface is found [m]
constexpr float reach = 0.004f;     // over which primitives share a vertex [m]

// The rig with a forearm on the wrist: two bones' worth of breadth, 12 cm long.
Rig with_forearm(Topology topology, Side side)
{
    Rig rig = hand_rig(topology, side);
    const int joint = int(side) * joint_count + wrist;
    const int first = int(rig.spheres.size());
    const struct {
        float x, y, z, r;
    } spheres[] = {{-0.011f, 0.001f, 0.004f, 0.0165f},
                   {0.011f, 0.001f, 0.004f, 0.0165f},
                   {-0.017f, 0.003f, 0.12f, 0.0235f},
                   {0.017f, 0.003f, 0.12f, 0.0235f}};
    for (const auto& s : spheres) {
        const Vec3<float> c{s.x, s.y, s.z};
        rig.spheres.push_back({{joint, joint, joint, joint}, {1, 0, 0, 0}, {c, c, c, c}, s.r});
    }
    rig.primitives.push_back({3, {first, first + 1, first + 2}, 0});
    rig.primitives.push_back({3, {first + 1, first + 2, first + 3}, 0});
    return rig;
}

// The primitives where they lie in the open hand.
struct Laid {
    std::vector<Sphere<float>> spheres;
    std::vector<Shape<float>> shapes;
};

Laid laid(const Rig& rig, const Hand& open, Side side)
{
    Laid out;
    for (const Binding<float>& b : rig.spheres) {
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

// 1/2 on the surface, 1 inside, 0 outside, over two spacings.
Field inside(const Laid& hand)
{
    Vec3<float> low{1, 1, 1}, high{-1, -1, -1};
    for (const Shape<float>& s : hand.shapes) {
        low = {min(low.x, s.low.x), min(low.y, s.low.y), min(low.z, s.low.z)};
        high = {max(high.x, s.high.x), max(high.y, s.high.y), max(high.z, s.high.z)};
    }
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

}  // namespace

HandSkin::HandSkin(Topology topology, Side side)
{
    const Rig rig = with_forearm(topology, side);
    const Hand open = open_hand(side);
    const Laid hand = laid(rig, open, side);
    Mesh mesh = isosurface(inside(hand), 0.5f);
    smooth(mesh, Smoothing::taubin, 12);
    triangles_ = mesh.triangles;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        std::array<float, joint_count> share{};
        std::vector<ClosestPoint<float>> near;
        float least = 1e30f;
        for (const Shape<float>& s : hand.shapes) {
            near.push_back(closest_point(s, mesh.vertices[v]));
            least = min(least, near.back().phi);
        }
        for (std::size_t i = 0; i < near.size(); ++i) {
            const float part = std::exp((least - near[i].phi) / reach);
            const float l[3] = {near[i].l0, near[i].l1, near[i].l2};
            for (int k = 0; k < 3; ++k) {
                const Binding<float>& b = rig.spheres[std::size_t(rig.primitives[i].sphere[k])];
                for (int j = 0; j < 4; ++j)
                    share[std::size_t(b.joint[j] - int(side) * joint_count)] +=
                        part * l[k] * b.weight[j];
            }
        }
        std::array<int, joint_count> order{};
        for (int j = 0; j < joint_count; ++j) order[std::size_t(j)] = j;
        std::partial_sort(order.begin(), order.begin() + 4, order.end(), [&](int a, int b) {
            return share[std::size_t(a)] > share[std::size_t(b)];
        });
        Skinned s{};
        float all = 0;
        for (int k = 0; k < 4; ++k) all += share[std::size_t(order[std::size_t(k)])];
        for (int k = 0; k < 4; ++k) {
            const int j = order[std::size_t(k)];
            const Joint<float>& at = open.joints[std::size_t(j)];
            s.joint[k] = int(side) * joint_count + j;
            s.weight[k] = share[std::size_t(j)] / all;
            s.place[k] = rotate(conjugate(at.q), mesh.vertices[v] - at.p);
            s.normal[k] = rotate(conjugate(at.q), mesh.normals[v]);
        }
        skinned_.push_back(s);
    }
}

Mesh HandSkin::posed(const std::vector<Joint<double>>& joints, double zoom) const
{
    Mesh mesh;
    mesh.triangles = triangles_;
    mesh.vertices.resize(skinned_.size());
    mesh.normals.resize(skinned_.size());
    std::vector<Joint<float>> at;
    for (const Joint<double>& j : joints) at.push_back(cast<float>(j));
    for (std::size_t v = 0; v < skinned_.size(); ++v) {
        const Skinned& s = skinned_[v];
        Vec3<float> p{}, n{};
        for (int k = 0; k < 4; ++k) {
            const Joint<float>& j = at[std::size_t(s.joint[k])];
            p = p + s.weight[k] * (j.p + float(zoom) * rotate(j.q, s.place[k]));
            n = n + s.weight[k] * rotate(j.q, s.normal[k]);
        }
        mesh.vertices[v] = p;
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
