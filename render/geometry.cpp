#include "render/geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

namespace knead {
namespace {

constexpr Vec3<float> wood{0.42f, 0.27f, 0.14f}, steel{0.40f, 0.42f, 0.45f};  // linear RGB

bool finite(Vec3<float> v)
{
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

struct UnitSphere {
    std::vector<Vec3<float>> directions;
    std::vector<Int3> triangles;
};

UnitSphere icosahedron()
{
    const float g = (1 + std::sqrt(5.0f)) / 2, s = 1 / std::sqrt(1 + g * g);
    UnitSphere ball;
    for (const float a : {-1.0f, 1.0f}) {
        for (const float b : {-g, g}) {
            ball.directions.push_back({0, s * a, s * b});
            ball.directions.push_back({s * a, s * b, 0});
            ball.directions.push_back({s * b, 0, s * a});
        }
    }
    // Its faces are the triples of nearest neighbours: edge 2 s, next distance 2 s g.
    const auto& d = ball.directions;
    const auto near = [&](int i, int j) { return length(d[i] - d[j]) < 2.5f * s; };
    for (int i = 0; i < 12; ++i) {
        for (int j = i + 1; j < 12; ++j) {
            for (int k = j + 1; k < 12; ++k) {
                if (!near(i, j) || !near(j, k) || !near(k, i)) continue;
                const bool out = dot(cross(d[j] - d[i], d[k] - d[i]), d[i]) > 0;
                ball.triangles.push_back(out ? Int3{i, j, k} : Int3{i, k, j});
            }
        }
    }
    return ball;
}

UnitSphere split(const UnitSphere& from)
{
    UnitSphere ball{from.directions, {}};
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int i, int j) {
        const auto [at, added] =
            middles.try_emplace({std::min(i, j), std::max(i, j)}, int(ball.directions.size()));
        if (added) {
            const Vec3<float> m = from.directions[i] + from.directions[j];
            ball.directions.push_back((1 / length(m)) * m);
        }
        return at->second;
    };
    for (const Int3 t : from.triangles) {
        const int a = middle(t.x, t.y), b = middle(t.y, t.z), c = middle(t.z, t.x);
        for (const Int3 part : {Int3{t.x, a, c}, Int3{a, t.y, b}, Int3{c, b, t.z}, Int3{a, b, c}}) {
            ball.triangles.push_back(part);
        }
    }
    return ball;
}

const UnitSphere& unit_sphere(int level)
{
    static const std::array<UnitSphere, 5> balls = [] {
        std::array<UnitSphere, 5> b;
        b[0] = icosahedron();
        for (int i = 1; i < 5; ++i) b[i] = split(b[i - 1]);
        return b;
    }();
    return balls.at(std::size_t(level));
}

Vec3<float> within(Vec3<float> p, Vec3<float> target, float reach)
{
    return {clamp(p.x, target.x - reach, target.x + reach),
            clamp(p.y, target.y - reach, target.y + reach),
            clamp(p.z, target.z - reach, target.z + reach)};
}

}  // namespace

void add_mesh(Geometry& geometry, const Mesh& mesh, Vec3<float> colour, float skin,
              const std::string& name)
{
    if (mesh.normals.size() != mesh.vertices.size()) {
        throw std::invalid_argument(name + ": " + std::to_string(mesh.vertices.size()) +
                                    " vertices, but " + std::to_string(mesh.normals.size()) +
                                    " normals");
    }
    const int first = int(geometry.vertices.size()), count = int(mesh.vertices.size());
    geometry.vertices.resize(std::size_t(first + count));
    const bool advances = mesh.advance.size() == mesh.vertices.size();
    bool sound = true;  // all values are finite: hands, which change every frame, need no second
                        // pass
    for (int i = 0; i < count; ++i) {
        const Vec3<float>&x = mesh.vertices[i], &n = mesh.normals[i];
        const float advance = advances ? mesh.advance[std::size_t(i)] : 0;
        geometry.vertices[std::size_t(first + i)] = {x, n, colour, skin, advance};
        sound = sound && finite(x) && finite(n) && std::isfinite(advance);
    }
    const auto usable = [&](int i) {
        if (i < 0 || i >= count) {
            throw std::invalid_argument(name + ": a triangle names vertex " + std::to_string(i) +
                                        " of " + std::to_string(count));
        }
        return sound || (finite(mesh.vertices[i]) && finite(mesh.normals[i]) &&
                         (!advances || std::isfinite(mesh.advance[i])));
    };
    geometry.triangles.reserve(geometry.triangles.size() + mesh.triangles.size());
    for (const Int3 t : mesh.triangles) {
        if (usable(t.x) && usable(t.y) && usable(t.z)) {
            geometry.triangles.push_back({first + t.x, first + t.y, first + t.z});
        }
    }
}

void add_hull(Geometry& geometry, const DrawPrimitive& primitive, int level, Vec3<float> colour,
              float skin)
{
    if (primitive.count < 1 || primitive.count > 3) {
        throw std::invalid_argument("a medial primitive of " + std::to_string(primitive.count) +
                                    " spheres; expected 1, 2 or 3");
    }
    for (int i = 0; i < primitive.count; ++i) {
        const Sphere<float>& s = primitive.sphere[i];
        if (!finite(s.c) || !std::isfinite(s.r) || s.r < 0) return;
    }
    const UnitSphere& ball = unit_sphere(level);
    const int first = int(geometry.vertices.size());
    for (const Vec3<float> n : ball.directions) {
        const Sphere<float>* far = &primitive.sphere[0];
        for (int i = 1; i < primitive.count; ++i) {
            const Sphere<float>& s = primitive.sphere[i];
            if (dot(s.c - far->c, n) + s.r - far->r > 0) far = &s;
        }
        geometry.vertices.push_back({far->c + far->r * n, n, colour, skin});
    }
    for (const Int3 t : ball.triangles) {
        geometry.triangles.push_back({first + t.x, first + t.y, first + t.z});
    }
}

void add_clay(Geometry& geometry, const Mesh& mesh)
{
    const std::size_t first = geometry.vertices.size();
    const std::string name = "clay mesh of category " + std::to_string(mesh.category);
    if (!mesh.colours.empty() && mesh.colours.size() != mesh.vertices.size())
        throw std::invalid_argument(name + ": as many colours as vertices are needed");
    add_mesh(geometry, mesh, category_colour(mesh.category), 0, name);
    for (std::size_t i = 0; i < mesh.colours.size(); ++i)
        geometry.vertices[first + i].colour = mesh.colours[i];
}

HandRanges add_hand(Geometry& geometry, const HandLook& hand)
{
    const Vec3<float> usual = hand.skin ? skin_colour : hand.metal ? steel : wood;
    const Vec3<float> colour = hand.mark ? hand.glow : usual;
    const float kind = hand.skin ? 1.0f : 0.0f;
    const auto so_far = [&] { return int(geometry.triangles.size()); };
    const int first = so_far();
    for (const DrawPrimitive& p : hand.primitives) add_hull(geometry, p, fine_hull, colour, kind);
    const int skins = so_far();
    for (const Mesh& mesh : hand.skins)
        add_mesh(geometry, mesh, colour, kind, "the skin of a hand");
    const int end = so_far();
    if (hand.mark) return {{first, end - first}, {end, 0}};
    for (const DrawPrimitive& p : hand.primitives) add_hull(geometry, p, coarse_hull, colour, kind);
    return {{first, end - first}, {skins, so_far() - skins}};
}

Geometry gather(const std::vector<Mesh>& meshes, const std::vector<HandLook>& hands,
                const std::vector<Mesh>& unseen)
{
    Geometry g{};
    for (const Mesh& mesh : meshes) add_clay(g, mesh);
    g.clay = {0, int(g.triangles.size())};
    g.casting.push_back(g.clay);
    for (const HandLook& hand : hands) {
        const HandRanges ranges = add_hand(g, hand);
        g.seen.push_back(ranges.seen), g.casting.push_back(ranges.casting);
    }
    const int first = int(g.triangles.size());
    for (const Mesh& mesh : unseen) add_clay(g, mesh);
    g.casting.push_back({first, int(g.triangles.size()) - first});
    return g;
}

Ball around(const Box3<float>& box, Vec3<float> target, float reach)
{
    const Box3<float> near{within(box.low, target, reach), within(box.high, target, reach)};
    const float radius = length(edges(near)) / 2;
    return {centre(near), max(radius, 1e-3f * reach)};
}

Ball around(const Geometry& geometry, Vec3<float> target, float reach)
{
    Box3<float> box = empty_box<float>();
    for (const Int3 t : geometry.triangles)
        for (const int i : {t.x, t.y, t.z})
            grow(box, within(geometry.vertices[i].place, target, reach));
    if (empty(box)) return {target, reach};
    return around(box, target, reach);
}

}  // namespace knead
