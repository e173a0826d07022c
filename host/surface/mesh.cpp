// Properties of a mesh.
#include "host/surface/mesh.h"

#include <cmath>
#include <numeric>

namespace knead {

Lattice<float> surface_lattice(const Lattice<double>& clay, int nodes)
{
    const int longest = max(clay.size.x, max(clay.size.y, clay.size.z));
    const auto along = [&](int n) {
        const double share = double(n) / longest * nodes;
        return block_edge * int(std::ceil(share / block_edge - 1e-9));
    };
    return {{along(clay.size.x), along(clay.size.y), along(clay.size.z)},
            float(clay.dx * longest / nodes)};
}

double volume(const Mesh& mesh)
{
    if (mesh.vertices.empty()) return 0;
    const Vec3<double> origin = cast<double>(mesh.vertices[0]);
    const auto at = [&](int v) { return cast<double>(mesh.vertices[v]) - origin; };
    double six = 0;
    for (const Int3 t : mesh.triangles) six += dot(at(t.x), cross(at(t.y), at(t.z)));
    return six / 6;
}

int components(const Mesh& mesh)
{
    std::vector<int> parent(mesh.vertices.size());
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](int v) {
        while (parent[v] != v) v = parent[v] = parent[parent[v]];
        return v;
    };
    int count = int(parent.size());
    const auto join = [&](int a, int b) {
        a = root(a), b = root(b);
        if (a != b) parent[max(a, b)] = min(a, b), --count;
    };
    for (const Int3 t : mesh.triangles) join(t.x, t.y), join(t.y, t.z);
    return count;
}

namespace {

// sRGB, by a sculptor's names: terracotta, teal, ochre, plum, sage, brick, sky, sand, moss, rose,
// slate, ivory.
unsigned palette_colour(int category)
{
    constexpr unsigned palette[] = {0xc8643c, 0x2a9d8f, 0xe2a72e, 0x7b3f8c, 0x9cbf88, 0x8f2d24,
                                    0x5aa9e6, 0xd9c08c, 0x4f6b2a, 0xe58fb1, 0x44566c, 0xf4efe2};
    constexpr int colours = int(std::size(palette));
    return palette[(category % colours + colours) % colours];
}

}  // namespace

Vec3<double> category_srgb(int category)
{
    const unsigned rgb = palette_colour(category);
    return {(rgb >> 16) / 255.0, (rgb >> 8 & 255) / 255.0, (rgb & 255) / 255.0};
}

Vec3<float> category_colour(int category)
{
    const unsigned rgb = palette_colour(category);
    const auto linear = [](unsigned channel) {  // IEC 61966-2-1
        const float s = float(channel & 255) / 255;
        return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
    };
    return {linear(rgb >> 16), linear(rgb >> 8), linear(rgb)};
}

}  // namespace knead
