// A skinned hand whose shape is known, as a binary glTF: the outside of the shipped medial hand,
// each of its vertices hung on the joints as the spheres that it lies on.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <nlohmann/json.hpp>

#include "host/assets/refine.h"
#include "host/base/json_reader.h"
#include "host/hands/rig.h"
#include "host/hands/rig_table.h"

namespace knead {

inline Spheres known_spheres()
{
    Spheres all;
    for (const FittedSphere& s : h25_spheres) all.push_back({cast<double>(s.c), {}, {}, s.r, 0});
    return all;
}
inline std::vector<Shape<double>> known_shapes()
{
    return shapes(known_spheres(), layout(Topology::h25).primitives);
}

using Corners = std::array<Vec3<double>, 3>;

// The triangle in parts with no side above `longest` [m].
template <class Take>
void parts_of(const Corners& t, double longest, Take&& take)
{
    const auto side = [&](int k) { return length(t[(k + 1) % 3] - t[k]); };
    const int k = side(0) > side(1) ? (side(0) > side(2) ? 0 : 2) : (side(1) > side(2) ? 1 : 2);
    if (side(k) <= longest) return take(t);
    const Vec3<double> middle = 0.5 * (t[k] + t[(k + 1) % 3]), other = t[(k + 2) % 3];
    parts_of({t[k], middle, other}, longest, take);
    parts_of({middle, t[(k + 1) % 3], other}, longest, take);
}

// The outside of a primitive: where it reaches farthest in directions all around.
template <class Take>
void outside_of(const Spheres& spheres, const Primitive& primitive, Take&& take)
{
    constexpr int rows = 16, columns = 32;
    const auto farthest = [&](int row, int column) {
        const double down = M_PI * row / rows, turn = 2 * M_PI * (column + 0.3) / columns;
        const Vec3<double> n{std::sin(down) * std::cos(turn), std::sin(down) * std::sin(turn),
                             std::cos(down)};
        const auto reach = [&](int s) { return dot(spheres[s].c, n) + spheres[s].r; };
        int best = primitive.sphere[0];
        for (const int s : primitive.sphere)
            if (reach(s) > reach(best)) best = s;
        return spheres[best].c + spheres[best].r * n;
    };
    for (int r = 0; r < rows; ++r)
        for (int c = 0; c < columns; ++c) {
            const auto a = farthest(r, c), b = farthest(r + 1, c), d = farthest(r + 1, c + 1),
                       e = farthest(r, c + 1);
            parts_of({a, b, d}, 4e-3, take);
            parts_of({a, d, e}, 4e-3, take);
        }
}

inline std::string webxr_name(int joint)
{
    const std::string name = joint_names[joint];
    if (joint == wrist) return name;
    const std::string finger = name.substr(0, name.find('_')),
                      bone = name.substr(name.find('_') + 1);
    const bool plain = bone == "metacarpal" || bone == "tip";
    return (finger == "little" ? "pinky" : finger) + (finger == "thumb" ? "-" : "-finger-") +
           (plain ? "" : "phalanx-") + bone;
}

// What the file holds; a test may spoil any of it.
struct HandGlb {
    static constexpr int sleeve = 0;  // the file's first joint is none of the hand's
    static int index(int joint) { return joint_count - joint; }  // of ours in the file

    std::vector<Vec3<float>> vertices;  // three a triangle
    std::vector<std::array<std::uint8_t, 4>> joints;
    std::vector<std::array<float, 4>> weights;  // in shares of any sum
    std::vector<std::string> names;
    std::vector<std::array<float, 16>> inverse_bind;

    // The hand stands turned and away from the origin.
    explicit HandGlb(Side side) : names{"sleeve"}, inverse_bind{{}}
    {
        const Quat<double> turn = turn_about(Vec3<double>{0.6, 0, 0.8}, 0.7);
        const Vec3<double> shift{0.2, 1.1, -0.3};
        const Hand open = open_hand(side);
        for (int j = joint_count - 1; j >= wrist; --j) {
            const auto q = conjugate(turn * unit(cast<double>(open.joints[j].q)));
            const auto p = shift + rotate(turn, cast<double>(open.joints[j].p));
            std::array<float, 16> m{};
            for (int k = 0; k < 4; ++k) {
                const Vec3<double> axis{double(k == 0), double(k == 1), double(k == 2)};
                const Vec3<double> column = rotate(q, k < 3 ? axis : -1.0 * p);
                const double each[] = {column.x, column.y, column.z, double(k == 3)};
                std::copy(std::begin(each), std::end(each), m.begin() + 4 * k);
            }
            names.push_back(webxr_name(j));
            inverse_bind.push_back(m);
        }
        add_mesh([&](Vec3<double> p) {
            if (side == left) p.x = -p.x;
            return cast<float>(shift + rotate(turn, p));
        });
    }

    std::string bytes() const
    {
        std::string binary;
        Json views = Json::array(), accessors = Json::array();
        const auto add = [&](const auto& all, int component, const char* type) {
            const std::size_t size = all.size() * sizeof all[0];
            views.push_back({{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", size}});
            accessors.push_back({{"bufferView", accessors.size()},
                                 {"componentType", component},
                                 {"count", all.size()},
                                 {"type", type}});
            binary.append(reinterpret_cast<const char*>(all.data()), size);
        };
        add(vertices, 5126, "VEC3");
        add(joints, 5121, "VEC4");
        add(weights, 5126, "VEC4");
        add(inverse_bind, 5126, "MAT4");
        Json nodes = Json::array(), numbers = Json::array();
        for (const std::string& name : names) {
            numbers.push_back(nodes.size());
            nodes.push_back({{"name", name}});
        }
        const Json attributes{{"POSITION", 0}, {"JOINTS_0", 1}, {"WEIGHTS_0", 2}};
        const Json part{{"attributes", attributes}};
        const Json json{{"asset", {{"version", "2.0"}}},
                        {"buffers", {{{"byteLength", binary.size()}}}},
                        {"bufferViews", views},
                        {"accessors", accessors},
                        {"meshes", {{{"primitives", {part}}}}},
                        {"nodes", nodes},
                        {"skins", {{{"joints", numbers}, {"inverseBindMatrices", 3}}}}};
        std::string text = json.dump();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        const std::string chunks = word(text.size()) + "JSON" + text + word(binary.size()) +
                                   std::string("BIN\0", 4) + binary;
        return "glTF" + word(2) + word(12 + chunks.size()) + chunks;
    }

  private:
    static std::string word(std::size_t n)
    {
        const auto value = std::uint32_t(n);
        std::string bytes(sizeof value, '\0');
        std::memcpy(bytes.data(), &value, sizeof value);
        return bytes;
    }

    template <class Place>
    void add_mesh(Place&& place)
    {
        const Spheres spheres = known_spheres();
        const auto all = known_shapes();
        for (const Primitive& primitive : layout(Topology::h25).primitives)
            outside_of(spheres, primitive, [&](Corners t) {
                std::array<Hold, 3> on;
                for (std::size_t k = 0; k < 3; ++k) {
                    on[k] = nearest(all, t[k]);
                    if (on[k].closest_point.phi < -2e-4) return;  // inside of another one
                    // Where two meet, a step onto one may lead into the other.
                    for (int i = 0; i < 30 && std::abs(on[k].closest_point.phi) > 2e-7; ++i) {
                        t[k] = t[k] - on[k].closest_point.phi * on[k].closest_point.n;
                        on[k] = nearest(all, t[k]);
                    }
                    if (std::abs(on[k].closest_point.phi) > 1e-6) return;
                }
                for (std::size_t k = 0; k < 3; ++k) {
                    vertices.push_back(place(t[k]));
                    hang_on(on[k]);
                }
            });
    }

    void hang_on(const Hold& h)
    {
        std::array<double, joint_count> share{};
        const auto primitives = layout(Topology::h25).primitives;
        for_each_share(primitives[std::size_t(h.primitive)], h.closest_point,
                       [&](int sphere, double part) {
                           const FittedSphere& s = h25_spheres[sphere];
                           for (int k = 0; k < 4; ++k) share[s.joint[k]] += part * s.weight[k];
                       });
        joints.push_back({});
        weights.push_back({});
        for (std::size_t k = 0; k < 4; ++k) {
            const auto most = std::max_element(share.begin(), share.end());
            joints.back()[k] = std::uint8_t(index(std::max(1, int(most - share.begin()))));
            weights.back()[k] = float(3 * *most);
            *most = 0;
        }
    }
};

}  // namespace knead
