// Clay looks like clay: its surface shows no single particles, at rest and when it was pressed. All
// roughness is in cells of the solver.
#include <gtest/gtest.h>

#include "cuda/math/box.h"
#include "host/scene/seed.h"
#include "host/surface/surface.h"
#include "tests/sanitized.h"
#include "tests/scene/pressed_clay.h"
#include "tests/surface/closed_mesh.h"
#include "tests/surface/roughness.h"

namespace knead {
namespace {

Mesh mesh_of(const Scene& scene, const std::vector<Particle<double>>& particles)
{
    const auto meshes = surface(particles, scene.setup.materials, scene.surface);
    EXPECT_EQ(meshes.size(), 1u);
    EXPECT_EQ(fault(meshes.at(0)), "");
    EXPECT_EQ(components(meshes[0]), 1);
    return meshes[0];
}

TEST(Skin, ABallAtRestIsSmooth)
{
    for (const int cells : {24, 32, 48, 64})
        for (const double per_cell : {8.0, 4.0}) {
            const Scene scene = clay_scene(cells, ShapeKind::sphere, {0.503, 0.497, 0.511},
                                           {0.5, 0.5, 0.5}, per_cell);
            const double dx = scene.setup.lattice.dx;
            const Roughness r = roughness_of(from_sphere(mesh_of(scene, scene.setup.particles)));
            EXPECT_LT(r.rms, 0.010 * dx) << cells << " cells, " << per_cell;
            EXPECT_LT(r.max, 0.05 * dx) << cells << " cells, " << per_cell;
        }
}

// Its faces, away from their rims: how far each vertex is from their mean.
TEST(Skin, FacesOfBoxesAndCylindersAreFlatWhereverTheyLie)
{
    const int cells = 32;
    for (const ShapeKind shape : {ShapeKind::box, ShapeKind::cylinder})
        for (const double off : {0.0, 0.3, 0.5, 0.77}) {
            const double dx = 1.0 / cells;
            const Vec3<double> centre{0.5, 0.5 + off * dx / 2, 0.5}, size{0.5, 0.3, 0.5};
            const Scene scene = clay_scene(cells, shape, centre, size);
            const Mesh mesh = mesh_of(scene, scene.setup.particles);
            std::vector<double> heights;
            double mean = 0;
            for (const Vec3<float> v : mesh.vertices) {
                const Vec3<double> d = cast<double>(v) - centre;
                if (d.y < 0 || std::hypot(d.x, d.z) > size.x / 2 - 4 * dx) continue;
                heights.push_back(d.y), mean += d.y;
            }
            ASSERT_GT(heights.size(), 150u);
            mean /= double(heights.size());
            for (double& h : heights) h -= mean;
            EXPECT_LT(roughness_of(heights).rms, 0.005 * dx) << int(shape) << ", " << off;
            EXPECT_NEAR(mean, size.y / 2, 0.01 * dx) << int(shape) << ", " << off;
        }
}

TEST(Skin, ABallIsSmoothAfterASqueeze)
{
    const Pressing p = squeeze(sanitized ? 24 : 40, 0.5);
    const Mesh mesh = mesh_of(p.scene, after(p));
    const double dx = p.scene.setup.lattice.dx;
    Box3<float> box{mesh.vertices[0], mesh.vertices[0]};
    for (const Vec3<float> v : mesh.vertices) grow(box, v);
    EXPECT_LT(edges(box).x, 0.46);  // of 0.5 m: it was squeezed
    const double rough = roughness_of(from_quadric(mesh, 3 * dx)).rms;
    EXPECT_TRUE(sanitized || rough < 0.015 * dx) << rough / dx;
}

TEST(Skin, ObjectsThatOverlapFillTheirUnion)
{
    Scene scene = clay_scene(32, ShapeKind::sphere, {0.42, 0.5, 0.5}, {0.4, 0.4, 0.4});
    Object other = scene.objects[0];
    other.centre = {0.58, 0.5, 0.5};
    scene.objects.push_back(other);
    build(scene, std::size_t(1) << 32);
    const double r = 0.2, height = r - 0.08;  // of the two caps that are counted twice
    const double ball = shape_volume(other),
                 lens = 2 * std::numbers::pi * height * height * (3 * r - height) / 3;
    EXPECT_NEAR(double(scene.setup.particles.size()) * scene.setup.materials[0].volume,
                2 * ball - lens, 2e-3 * ball);
    const double dx = scene.setup.lattice.dx;
    const Mesh mesh = mesh_of(scene, scene.setup.particles);
    std::vector<double> off;
    for (const Vec3<float> v : mesh.vertices) {
        const Vec3<double> x = cast<double>(v);
        if (std::abs(x.x - 0.5) < 4 * dx) continue;  // the crease
        off.push_back(length(x - scene.objects[x.x < 0.5 ? 0 : 1].centre));
    }
    double mean = 0;
    for (const double d : off) mean += d / double(off.size());
    for (double& d : off) d -= mean;
    EXPECT_LT(roughness_of(off).rms, 0.010 * dx);
}

}  // namespace
}  // namespace knead
