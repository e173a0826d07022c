// What is seen of bodies of splats that were drawn out or cut in two: whether the clay's surface is
// covered, with splats split and added and without. docs/method/splats.md has the numbers.
#include <gtest/gtest.h>

#include "tests/sanitized.h"
#include "tests/splats/kneaded.h"

namespace knead::kneaded {
namespace {

constexpr int frames = 18;

struct Shares {
    double kept, total, elastic, rigid;  // of the clay's pixels that are open
};

// Open is a pixel in which one sees more than one and a half particles' spacings into the clay.
double open_share(const Body& b, const Simulator& solver, const Eye<float>& eye, Follow follow)
{
    const Picture seen = picture_of(b.splats, solver, eye, follow);
    const Coverage c = coverage(seen, clay_seen(b, solver, eye), 3, 0.9, 1.5 * b.spacing);
    EXPECT_GT(c.pixels, 20000u);
    return c.open_share();
}

Shares shares(const Body& body, const Eye<float>& eye)
{
    Shares s{};
    Body kept = body;
    const auto by_upkeep = cpu_solver(kept.setup), by_itself = cpu_solver(body.setup);
    const Upkeep options;
    const auto [split_up, added] = play(kept, *by_upkeep, frames, &options);
    testing::Test::RecordProperty("split", int(split_up));
    testing::Test::RecordProperty("added", int(added));
    Body plain = body;
    play(plain, *by_itself, frames);
    s.kept = open_share(kept, *by_upkeep, eye, Follow::total);
    s.total = open_share(plain, *by_itself, eye, Follow::total);
    s.elastic = open_share(plain, *by_itself, eye, Follow::elastic);
    s.rigid = open_share(plain, *by_itself, eye, Follow::rigid);
    std::printf("open: kept dense %.5f, total F %.5f, elastic F %.5f, no F %.5f\n", s.kept, s.total,
                s.elastic, s.rigid);
    return s;
}

// Twice as long; its middle is drawn out further.
Body drawn_out(bool hollow)
{
    Body b = body_of();
    if (hollow) make_hollow(b);
    draw_out(b, 3.75, frames * frame);
    return b;
}
Eye<float> beside() { return eye_looking({0.75, 0.75, 1.15}, middle, 0.45, 480, 360, {0, 1, 0}); }

TEST(Appearance, ABodyDrawnOutIsCoveredWhereItsSplatsAreSplit)
{
    const Shares s = shares(drawn_out(false), beside());
    EXPECT_LT(s.kept, 0.002);
    EXPECT_GT(s.total, 0.05) << "long splats from inside reach out of the skin";
    EXPECT_GT(s.elastic, 0.002);
    EXPECT_GT(s.rigid, 0.002);
}

TEST(Appearance, ASkinDrawnOutHasHolesUnlessTheTotalDeformationStretchesItsSplats)
{
    if (sanitized) GTEST_SKIP() << "under sanitizers the body drawn out runs the same code";
    const Shares s = shares(drawn_out(true), beside());
    EXPECT_LT(s.kept, 0.001);
    EXPECT_LT(s.total, 0.001);
    EXPECT_GT(s.elastic, 0.03);
    EXPECT_GT(s.rigid, 0.03);
}

// Of a skin alone: what is seen in the cut can only be what was added.
TEST(Appearance, TheFacesOfACutAreCovered)
{
    Body b = body_of();
    make_hollow(b);
    part(b, 0.35);
    const Shares s = shares(b, eye_looking({0.5, 0.8, 1.0}, middle, 0.45, 480, 360, {0, 1, 0}));
    EXPECT_LT(s.kept, 0.001);
    EXPECT_GT(s.total, 0.02);
}

// Where an inside was put, it is seen.
TEST(Appearance, TheFacesOfACutThroughAFilledBodyNeedNothingNew)
{
    if (sanitized) GTEST_SKIP() << "under sanitizers the cut skin runs the same code";
    Body b = body_of();
    part(b, 0.35);
    const Shares s = shares(b, eye_looking({0.5, 0.8, 1.0}, middle, 0.45, 480, 360, {0, 1, 0}));
    EXPECT_LT(s.kept, 0.001);
    EXPECT_LT(s.total, 0.001);
}

// --- what is measured ----------------------------------------------------------------------------

TEST(MeshDepths, AreThoseOfItsNearestTriangles)
{
    const Eye<float> eye = eye_looking({0, 0, -1}, {0, 0, 0}, 0.5, 100, 100);
    // Two squares, one behind the other, the nearer one smaller and tilted.
    const std::vector<Vec3<float>> x{{-0.4f, -0.4f, 0.5f}, {0.4f, -0.4f, 0.5f}, {0.4f, 0.4f, 0.5f},
                                     {-0.4f, 0.4f, 0.5f},  {-0.2f, -0.2f, 0},   {0.2f, -0.2f, 0},
                                     {0.2f, 0.2f, 0.2f},   {-0.2f, 0.2f, 0.2f}};
    const std::vector<float> z = mesh_depths(eye, x, {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}});
    std::size_t covered = 0;
    for (const float depth : z) covered += depth < no_depth;
    EXPECT_NEAR(double(covered), 10000 * 0.8 * 0.8 / (1.5 * 1.5), 110);
    EXPECT_EQ(z[0], float(no_depth));
    EXPECT_FLOAT_EQ(z[50 * 100 + 28], 1.5f);
    // On the tilted square y = 2 z' - 0.2 for z' = z - 1; the ray has y = slope z.
    const double slope = (60 + 0.5) / 100 - 0.5;
    EXPECT_NEAR(double(z[60 * 100 + 50]), 2.2 / (2 - slope), 1e-5);
}

TEST(CoverageOf, APictureCountsItsHoles)
{
    Picture p;
    p.width = p.height = 10;
    p.colour.resize(100), p.alpha.assign(100, 1), p.depth.assign(100, 1);
    std::vector<float> mesh(100, 1.0f);
    for (std::size_t i = 0; i < 10; ++i) mesh[i] = float(no_depth);
    EXPECT_EQ(coverage(p, mesh, 0).pixels, 90u);
    EXPECT_EQ(coverage(p, mesh, 1).pixels, 56u);
    EXPECT_EQ(coverage(p, mesh, 0).open, 0u);
    for (std::size_t i : {33u, 34u, 44u, 66u}) p.alpha[i] = 0.5f;
    p.alpha[3] = 0;  // beside the mesh
    p.depth[67] = 1.2f;
    EXPECT_EQ(coverage(p, mesh, 0).open, 4u);
    EXPECT_EQ(coverage(p, mesh, 0).largest, 3u);
    EXPECT_EQ(coverage(p, mesh, 0, 0.9, 0.1).open, 5u);
    EXPECT_EQ(coverage(p, mesh, 0, 0.4).open, 0u);
    EXPECT_FLOAT_EQ(float(coverage(p, mesh, 0).least_alpha), 0.5f);
    EXPECT_THROW(coverage(p, {1}, 0), std::invalid_argument);
}

}  // namespace
}  // namespace knead::kneaded
