#include "host/assets/poisson.h"

#include <stdexcept>

#include "host/base/parallel.h"

namespace knead {
namespace {

struct Level {
    Grid grid;
    std::vector<float> u, f;
};

// One Gauss-Seidel sweep over the nodes of one colour.
void relax(Level& l, int colour)
{
    const Int3 n = l.grid.size;
    const std::size_t up = std::size_t(n.x), out = up * n.y;
    const float h2 = float(l.grid.h * l.grid.h);
    parallel_for(n.z - 2, [&](int layer) {
        const int z = layer + 1;
        for (int y = 1; y < n.y - 1; ++y) {
            const std::size_t row = l.grid.at({0, y, z});
            float* u = &l.u[row];
            const float* f = &l.f[row];
            for (int x = 1 + ((y + z + colour) & 1); x < n.x - 1; x += 2)
                u[x] = (u[x - 1] + u[x + 1] + (u + x)[-std::ptrdiff_t(up)] + (u + x)[up] +
                        (u + x)[-std::ptrdiff_t(out)] + (u + x)[out] - h2 * f[x]) /
                       6;
        }
    });
}

float residual(const Level& l, Int3 n)
{
    if (!l.grid.within(n, 1)) return 0;
    const std::size_t i = l.grid.at(n), up = std::size_t(l.grid.size.x), out = up * l.grid.size.y;
    const float sum =
        l.u[i - 1] + l.u[i + 1] + l.u[i - up] + l.u[i + up] + l.u[i - out] + l.u[i + out];
    return l.f[i] - (sum - 6 * l.u[i]) / float(l.grid.h * l.grid.h);
}

// Full weighting: 1 2 1 along each axis.
void restrict_residual(const Level& fine, Level& coarse)
{
    std::vector<float> r(fine.u.size());
    parallel_for(fine.grid.size.z, [&](int z) {
        for (int y = 0; y < fine.grid.size.y; ++y)
            for (int x = 0; x < fine.grid.size.x; ++x)
                r[fine.grid.at({x, y, z})] = residual(fine, {x, y, z});
    });
    const Int3 n = coarse.grid.size;
    parallel_for(n.z - 2, [&](int layer) {
        const int z = layer + 1;
        for (int y = 1; y < n.y - 1; ++y)
            for (int x = 1; x < n.x - 1; ++x) {
                float sum = 0;
                for (int k = 0; k < 27; ++k) {
                    const Int3 d{k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
                    const int zeros = (d.x == 0) + (d.y == 0) + (d.z == 0);
                    sum += float(1 << zeros) * r[fine.grid.at(2 * Int3{x, y, z} + d)];
                }
                coarse.f[coarse.grid.at({x, y, z})] = sum / 64;
            }
    });
}

// Adds the coarse correction, interpolated linearly along each axis.
void prolong(const Level& coarse, Level& fine)
{
    const Int3 n = fine.grid.size;
    parallel_for(n.z - 2, [&](int layer) {
        const int z = layer + 1;
        for (int y = 1; y < n.y - 1; ++y)
            for (int x = 1; x < n.x - 1; ++x) {
                float sum = 0;
                for (int k = 0; k < 8; ++k) {
                    const Int3 at{(x + (k & 1)) / 2, (y + (k >> 1 & 1)) / 2, (z + (k >> 2)) / 2};
                    sum += coarse.u[coarse.grid.at(at)];
                }
                fine.u[fine.grid.at({x, y, z})] += sum / 8;
            }
    });
}

void cycle(std::vector<Level>& levels, std::size_t k)
{
    Level& l = levels[k];
    const bool last = k + 1 == levels.size();
    for (int sweep = 0; sweep < (last ? 60 : 2); ++sweep) relax(l, 0), relax(l, 1);
    if (last) return;
    std::fill(levels[k + 1].u.begin(), levels[k + 1].u.end(), 0.0f);
    restrict_residual(l, levels[k + 1]);
    cycle(levels, k + 1);
    prolong(levels[k + 1], l);
    for (int sweep = 0; sweep < 2; ++sweep) relax(l, 1), relax(l, 0);
}

}  // namespace

std::vector<float> solve_poisson(const Grid& grid, const std::vector<float>& f)
{
    const Int3 n = grid.size;
    for (int edge : {n.x - 1, n.y - 1, n.z - 1})
        if (edge < poisson_edge || edge % poisson_edge != 0)
            throw std::invalid_argument("solve_poisson: edges are multiples of 16 spacings");
    std::vector<Level> levels;
    for (int k = 0; k <= poisson_levels; ++k) {
        Grid g = grid;
        g.h = grid.h * (1 << k);
        g.size = {((n.x - 1) >> k) + 1, ((n.y - 1) >> k) + 1, ((n.z - 1) >> k) + 1};
        levels.push_back({g, std::vector<float>(g.count()), std::vector<float>(g.count())});
    }
    levels[0].f = f;
    for (int k = 0; k < 10; ++k) cycle(levels, 0);
    return std::move(levels[0].u);
}

}  // namespace knead
