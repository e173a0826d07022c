// Meshes that stay on the device are those that are fetched, and the box about them is theirs.
#include <gtest/gtest.h>

#include "host/solver/editable_simulator.h"
#include "host/surface/gpu_surface.h"
#include "tests/surface/closed_mesh.h"
#include "tests/surface/surface_clay.h"

namespace knead {
namespace {

TEST(GpuKeptMeshes, AreTheSurface)
{
    if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    const double h = 1.0 / 48;
    std::vector<Particle<double>> two = filled(h, 3, 0, ball({0.3, 0.5, 0.5}, 0.15));
    for (Particle<double> q : filled(h, 4, 1, ball({0.7, 0.55, 0.4}, 0.2))) two.push_back(q);
    const std::vector<Material<double>> materials{clay(h, 5), clay(h, 2), clay(h, 9)};
    SurfaceOptions options;
    options.lattice = {{48, 48, 48}, float(h)};
    GpuSurface surface(two, materials, options);
    const std::vector<Mesh> wanted = surface.surface(two);
    const auto kept = surface.kept(two);
    const std::vector<Mesh> found = kept->meshes();
    ASSERT_EQ(found.size(), wanted.size());
    ASSERT_EQ(found.size(), 2u);
    Box3<float> box = empty_box<float>();
    std::size_t vertices = 0, triangles = 0;
    for (std::size_t m = 0; m < found.size(); ++m) {
        EXPECT_EQ(found[m].category, wanted[m].category);
        ASSERT_EQ(found[m].vertices.size(), wanted[m].vertices.size());
        ASSERT_EQ(found[m].triangles.size(), wanted[m].triangles.size());
        vertices += found[m].vertices.size(), triangles += found[m].triangles.size();
        for (std::size_t i = 0; i < found[m].vertices.size(); ++i) {
            const Vec3<float> v = wanted[m].vertices[i];
            ASSERT_EQ(length(found[m].vertices[i] - v), 0) << i;
            ASSERT_EQ(length(found[m].normals[i] - wanted[m].normals[i]), 0) << i;
            grow(box, v);
        }
        for (std::size_t i = 0; i < found[m].triangles.size(); ++i) {
            const Int3 a = found[m].triangles[i], b = wanted[m].triangles[i];
            ASSERT_TRUE(a.x == b.x && a.y == b.y && a.z == b.z) << i;
        }
    }
    EXPECT_EQ(kept->vertices(), vertices);
    EXPECT_EQ(kept->triangles(), triangles);
    EXPECT_EQ(length(kept->box().low - box.low), 0);
    EXPECT_EQ(length(kept->box().high - box.high), 0);
    EXPECT_TRUE(surface.kept(std::vector<Particle<double>>{})->empty());
    EXPECT_EQ(kept->meshes().size(), 2u) << "it stays while it is held";
}

}  // namespace
}  // namespace knead
