#include "host/assets/light.h"

#include <array>
#include <numbers>

#include "host/base/parallel.h"

namespace knead {
namespace {

// The sweep of one direction through the grid: slices along its longest axis, rows within a slice.
struct Sweep {
    Vec3<float> towards;           // unit, towards the light
    int slices, rows, columns;     // along the axes m, v and u
    std::size_t by_m, by_v, by_u;  // memory strides along each axis
    bool rising;                   // light enters at the last slice
    float along;                   // |component along m|
    int step_u, step_v;            // offset to the lower of the nodes around the incoming ray
    float share_u, share_v;        // interpolation weights of the higher nodes
};

Sweep sweep_of(const Grid& grid, Vec3<double> d)
{
    const std::array<double, 3> t{d.x, d.y, d.z};
    const std::array<int, 3> n{grid.size.x, grid.size.y, grid.size.z};
    const std::array<std::size_t, 3> stride{1, std::size_t(n[0]), std::size_t(n[0]) * n[1]};
    std::size_t m = 0;
    for (std::size_t k = 1; k < 3; ++k)
        if (std::abs(t[k]) > std::abs(t[m])) m = k;
    const std::size_t u = m == 0 ? 1 : 0, v = m == 2 ? 1 : 2;
    const double along = std::abs(t[m]), a = t[u] / along, b = t[v] / along;
    return {cast<float>(d),
            n[m],
            n[v],
            n[u],
            stride[m],
            stride[v],
            stride[u],
            t[m] > 0,
            float(along),
            int(std::floor(a)),
            int(std::floor(b)),
            float(a - std::floor(a)),
            float(b - std::floor(b))};
}

// Light that leaves a slice, with a rim of open sky, two nodes wide.
struct Slice {
    int stride;
    std::vector<float> light;
    explicit Slice(const Sweep& s)
        : stride(s.columns + 4), light(std::size_t(s.columns + 4) * (s.rows + 4), 1.0f)
    {
    }
    float* row(int v) { return &light[std::size_t(v + 2) * stride + 2]; }
};

// Propagates light through one row of a slice; `weight` is the direction's fraction of the sky.
void light_row(const Sweep& s, const float* below, const float* above, float* leaving,
               std::size_t first, const std::vector<float>& extinction, float h, float weight,
               Light& light)
{
    const float w00 = (1 - s.share_u) * (1 - s.share_v), w10 = s.share_u * (1 - s.share_v),
                w01 = (1 - s.share_u) * s.share_v, w11 = s.share_u * s.share_v;
    // The pressure of a full sky on an open surface is 2 pi / 3 of 4 pi.
    const float per_spacing = 6 * weight * s.along / h, path = h / s.along;
    for (int u = 0; u < s.columns; ++u) {
        const int from = u + s.step_u;
        const float in =
            w00 * below[from] + w10 * below[from + 1] + w01 * above[from] + w11 * above[from + 1];
        const std::size_t i = first + std::size_t(u) * s.by_u;
        float passes = 1;
        if (extinction[i] > 0) {
            const float half = std::exp(-path / 2 * extinction[i]);
            light.seen[i] += weight * in * half;
            passes = half * half;
            light.pressure[i] = light.pressure[i] - (per_spacing * in * (1 - passes)) * s.towards;
        } else {
            light.seen[i] += weight * in;
        }
        leaving[u] = in * passes;
    }
}

}  // namespace

std::vector<Vec3<double>> fibonacci_sphere(int count)
{
    std::vector<Vec3<double>> all;
    for (int k = 0; k < count; ++k) {
        const double z = 1 - (2 * k + 1.0) / count, r = std::sqrt(1 - z * z);
        const double turn = 2 * std::numbers::pi * k / std::numbers::phi;
        all.push_back({r * std::cos(turn), r * std::sin(turn), z});
    }
    return all;
}

Light lit_from_all_sides(const Grid& grid, const std::vector<float>& extinction, int directions)
{
    Light light{std::vector<float>(grid.count()), std::vector<Vec3<float>>(grid.count())};
    for (Vec3<double> d : fibonacci_sphere(directions)) {
        const Sweep s = sweep_of(grid, d);
        Slice entering(s), leaving(s);
        for (int k = 0; k < s.slices; ++k) {
            const std::size_t slice = std::size_t(s.rising ? s.slices - 1 - k : k) * s.by_m;
            parallel_for(s.rows, [&](int v) {
                light_row(s, entering.row(v + s.step_v), entering.row(v + s.step_v + 1),
                          leaving.row(v), slice + std::size_t(v) * s.by_v, extinction,
                          float(grid.h), 1 / float(directions), light);
            });
            std::swap(entering, leaving);
        }
    }
    return light;
}

}  // namespace knead
