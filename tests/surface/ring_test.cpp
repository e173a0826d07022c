// The ring of a vertex by its edge against the triangles of the whole mesh.
#include "cuda/surface/ring.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "cuda/surface/march.h"
#include "host/surface/surface.h"
#include "tests/solver/samples.h"
#include "tests/surface/mesh_keys.h"

namespace knead {
namespace {

using Pairs = std::vector<std::pair<EdgeKey, EdgeKey>>;

TEST(Ring, AroundEveryVertexAreTheTrianglesThatUseIt)
{
    Draw draw(21);
    for (int round = 0; round < 20; ++round) {
        const Int3 size{9, 8, 7};
        Field f{{0, 0, 0}, size, 1, std::vector<float>(9 * 8 * 7, 0.0f)};
        const auto at = [&](Int3 n) -> float& {
            return f.value[std::size_t((n.z * size.y + n.y) * size.x + n.x)];
        };
        for (int z = 1; z < size.z - 1; ++z)
            for (int y = 1; y < size.y - 1; ++y)
                for (int x = 1; x < size.x - 1; ++x) at({x, y, z}) = float(draw.in(0, 1));
        const Mesh mesh = isosurface(f, 0.5f);
        const std::vector<EdgeKey> keys = edge_keys(mesh, f.dx);
        std::vector<Pairs> expected(keys.size());
        for (const Int3 t : mesh.triangles) {
            const int v[3] = {t.x, t.y, t.z};
            for (int k = 0; k < 3; ++k)
                expected[std::size_t(v[k])].emplace_back(keys[std::size_t(v[(k + 1) % 3])],
                                                         keys[std::size_t(v[(k + 2) % 3])]);
        }
        for (std::size_t v = 0; v < keys.size(); ++v) {
            const auto [x, y, z, axis] = keys[v];
            const Int3 node{x, y, z};
            const auto cell = [&node](int corner) {
                return node - Int3{corner & 1, corner >> 1 & 1, corner >> 2};
            };
            Pairs found;
            for (int k = 0; k < 4; ++k) {
                const Int3 low = cell(corner_of_cell(axis, k));
                const int inside = cell_case(0.5f, [&](int c) {
                    return at(low + Int3{c & 1, c >> 1 & 1, c >> 2});
                });
                for_each_at(
                    edge_of_cell(axis, k), inside, march_table,
                    [&](int e) {
                        const int c = low_corner(e);
                        const Int3 n = low + Int3{c & 1, c >> 1 & 1, c >> 2};
                        return EdgeKey{n.x, n.y, n.z, e / 4};
                    },
                    [&](EdgeKey next, EdgeKey last) { found.emplace_back(next, last); });
            }
            EXPECT_LE(int(found.size()), max_ring);
            std::sort(found.begin(), found.end());
            std::sort(expected[v].begin(), expected[v].end());
            EXPECT_EQ(found, expected[v]);
        }
        EXPECT_GT(keys.size(), 100u);
    }
}

}  // namespace
}  // namespace knead
