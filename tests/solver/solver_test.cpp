// The whole substep, on every backend that is there: what must hold of any frame.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>

#include "cuda/mpm/g2p.h"
#include "host/hands/hands.h"
#include "host/solver/editable_simulator.h"
#include "host/solver/reference.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test
constexpr double frame = 1.0 / 60;

struct Backend {
    const char* name;
    std::unique_ptr<Simulator> (*make)(const Given&);
    double precision;  // of a sum over a substep, relative
};
std::unique_ptr<Simulator> on_cpu(const Given& s) { return cpu_solver(s); }
std::unique_ptr<Simulator> on_device(const Given& s) { return gpu_solver(s, 0); }
std::unique_ptr<Simulator> reference(const Given& s) { return std::make_unique<Reference>(s); }
const Backend backends[] = {
    {"float", on_cpu, 1e-6}, {"reference", reference, 1e-13}, {"cuda", on_device, 1e-6}};

class EveryBackend : public testing::TestWithParam<Backend> {
  protected:
    void SetUp() override
    {
        if (GetParam().make == on_device && !gpu_present()) GTEST_SKIP() << "no CUDA device";
    }
    std::unique_ptr<Simulator> make(const Given& s) { return GetParam().make(s); }
};
INSTANTIATE_TEST_SUITE_P(Solver, EveryBackend, testing::ValuesIn(backends),
                         [](const auto& at) { return std::string(at.param.name); });

Material<double> clay(double young, double yield)
{
    Material<double> m{};
    m.elasticity = Elasticity::neo_hookean;
    m.plasticity = yield > 0 ? Plasticity::von_mises : Plasticity::none;
    m.density = 1000, m.mu = young / 2.6, m.lambda = young * 0.3 / (1.3 * 0.4), m.yield = yield;
    return m;
}

Given ball(int nodes, double diameter, Vec3<double> centre, const Material<double>& material)
{
    Given s;
    s.lattice = {{nodes, nodes, nodes}, 1.0 / nodes};
    s.walls = walls_inside(s.lattice, 3, ContactMode::separate, 0.4);
    Material<double> m = material;
    const double dx = s.lattice.dx;
    m.volume = dx * dx * dx / 8, m.mass = m.volume * m.density;
    s.materials = {m};
    for (int z = 0; z < 2 * nodes; ++z)
        for (int y = 0; y < 2 * nodes; ++y)
            for (int x = 0; x < 2 * nodes; ++x) {
                Particle<double> q{};
                q.x = dx * Vec3<double>{(x + 0.5) / 2, (y + 0.5) / 2, (z + 0.5) / 2};
                if (length(q.x - centre) < diameter / 2) s.particles.push_back(q);
            }
    return s;
}

Motion still(Vec3<double> at = {0, 0, 0})
{
    Motion m;
    m.from.assign(2 * joint_count, {{1, 0, 0, 0}, at});
    m.to = m.from;
    return m;
}

Vec3<double> momentum(const std::vector<Particle<double>>& q)
{
    Vec3<double> sum{};
    for (const auto& p : q) sum = sum + p.v;
    return sum;
}

// Angular momentum about the origin per particle mass: that of the points and of their affine part.
Vec3<double> spin(const std::vector<Particle<double>>& q, double dx)
{
    Vec3<double> sum{};
    for (const auto& p : q) {
        const auto S = skew(p.C);
        sum = sum + cross(p.x, p.v) + (dx * dx / 2) * Vec3<double>{S.b.z, S.c.x, S.a.y};
    }
    return sum;
}

TEST_P(EveryBackend, ABallInFreeFallFallsAsABodyDoes)
{
    Given s = ball(32, 0.3, {0.5, 0.6, 0.5}, clay(1e5, 1e4));
    s.gravity = {0, -9.81, 0};
    const auto solver = make(s);
    for (int f = 0; f < 6; ++f) solver->advance(still(), frame);
    const auto q = solver->particles();
    for (std::size_t i = 0; i < q.size(); i += 97) {
        EXPECT_NEAR(q[i].v.y, -9.81 * 6 * frame, 1e-4);
        EXPECT_NEAR(q[i].v.x, 0, 1e-4);
        EXPECT_NEAR(std::sqrt(1 + determinant_excess(q[i].e)), 1, 1e-5);
    }
}

TEST_P(EveryBackend, ASpinningBallKeepsItsAngularMomentum)
{
    Given s = ball(32, 0.3, {0.5, 0.5, 0.5}, clay(1e5, 0));
    for (auto& p : s.particles) {
        const Vec3<double> w = {3, 5, -2};
        p.v = cross(w, p.x - Vec3<double>{0.5, 0.5, 0.5});
        p.C = {{0, w.z, -w.y}, {-w.z, 0, w.x}, {w.y, -w.x, 0}};
    }
    const auto solver = make(s);
    const Vec3<double> before = spin(s.particles, s.lattice.dx);
    int substeps = 0;
    for (int f = 0; f < 6; ++f) substeps += solver->advance(still(), frame).substeps;
    const Vec3<double> change = spin(solver->particles(), s.lattice.dx) - before;
    EXPECT_LT(length(change) / length(before), substeps * GetParam().precision);
}

TEST_P(EveryBackend, MomentumIsKeptToRoundingWhileABallRings)
{
    Given s = ball(32, 0.3, {0.5, 0.5, 0.5}, clay(1e5, 5e3));
    for (auto& p : s.particles) {
        p.v = {p.x.x - 0.4, 0.2, 2 * (p.x.y - 0.5)};
        p.C = {};
    }
    const auto solver = make(s);
    const Vec3<double> before = momentum(s.particles);
    int substeps = 0;
    for (int f = 0; f < 4; ++f) substeps += solver->advance(still(), frame).substeps;
    const Vec3<double> change = momentum(solver->particles()) - before;
    EXPECT_LT(length(change) / length(before), substeps * GetParam().precision);
}

// A rod along y, between the particles of no plane, swept through the ball along x.
class ThinTool : public testing::TestWithParam<std::tuple<Backend, double, double>> {};
INSTANTIATE_TEST_SUITE_P(Solver, ThinTool,
                         testing::Combine(testing::ValuesIn(backends),
                                          testing::Values(0.25, 0.5, 1.0, 2.0),
                                          testing::Values(0.1, 1.0, 4.0)));

// None is ever deeper inside than projection leaves to the velocities.
TEST_P(ThinTool, LeavesNoParticleDeepInsideAndLosesNone)
{
    const auto [backend, radius, speed] = GetParam();  // in cells, and cells a frame
    if (backend.make == on_device && !gpu_present()) GTEST_SKIP() << "no CUDA device";
    Given s = ball(32, 0.3, {0.5, 0.5, 0.5}, clay(2e4, 1e3));
    const double dx = s.lattice.dx, shortly = 5e-4;
    Binding<float> low{}, high{};
    low.weight[0] = high.weight[0] = 1;
    low.offset[0] = {0, -0.3f, 0}, high.offset[0] = {0, 0.3f, 0};
    low.radius = high.radius = float(radius * dx);
    s.rig.spheres = {low, high};
    s.rig.primitives = {{2, {0, 1, 1}, 0}};
    s.tools = {{ContactMode::separate, 0.3, false, true}};
    const auto solver = backend.make(s);
    double x = 0.5 - 0.15 - radius * dx - 0.01;
    const double until = x + 0.25;
    long projected = 0;
    while (x < until) {
        Motion m = still({x, 0.5, 0.5 + 0.2 * dx});
        x += speed * dx;
        m.to[0].p.x = x;
        const FrameStats stats = solver->advance(m, shortly);
        projected += stats[Count::projected];
        for (double d : solver->penetration()) ASSERT_LT(d, 0.375 * dx + 1e-6);
    }
    EXPECT_GT(projected, 100) << "the rod met nothing";
    const auto q = solver->particles();
    EXPECT_EQ(q.size(), s.particles.size());
    for (const auto& p : q) {
        EXPECT_TRUE(std::isfinite(p.x.x + p.x.y + p.x.z + p.v.x + p.v.y + p.v.z));
        EXPECT_GE(p.x.x, 3 * dx - 1e-6);
        EXPECT_LE(p.x.x, 1 - 4 * dx + 1e-6);
    }
}

TEST(Solver, NumbersThatAreNoneAndMoreToolsThanThereIsRoomForAreRefused)
{
    const Given good = ball(16, 0.3, {0.5, 0.5, 0.5}, clay(1e5, 1e4));
    Given stiff = good, crowded = good, loose = good;
    stiff.materials[0].lambda = std::numeric_limits<double>::infinity();
    EXPECT_THROW(cpu_solver(stiff), std::invalid_argument);
    crowded.rig.spheres = {{{}, {1}, {}, 0.01f}};
    crowded.rig.primitives.assign(max_primitives + 1, {1, {0, 0, 0}, 0});
    crowded.tools = {{ContactMode::separate, 0.3, false, true}};
    EXPECT_THROW(cpu_solver(crowded), std::invalid_argument);
    loose.rig.primitives = {{1, {0, 0, 0}, 0}};  // of no sphere and of no tool
    EXPECT_THROW(cpu_solver(loose), std::invalid_argument);
    EXPECT_NO_THROW(cpu_solver(good));
}

TEST(Solver, TheBitsAreTheSameForAnyNumberOfThreads)
{
    Given s = ball(32, 0.3, {0.5, 0.3, 0.5}, clay(1e5, 1e4));
    s.gravity = {0, -9.81, 0};
    std::vector<Particle<double>> first;
    for (int threads : {1, 2, 3}) {
        s.threads = threads;
        const auto solver = cpu_solver(s);
        for (int f = 0; f < 8; ++f) solver->advance(still(), frame);
        const auto q = solver->particles();
        if (first.empty()) first = q;
        for (std::size_t i = 0; i < q.size(); ++i)
            ASSERT_EQ(0, std::memcmp(&q[i], &first[i], offsetof(Particle<double>, object))) << i;
    }
}

// A plane at a known height stops the clay there, whatever its place between two nodes.
TEST(Solver, AToolStopsClayWhereItIsAndNotHalfACellAside)
{
    for (double shift : {0.0, 0.25, 0.5, 0.75}) {
        Given s = ball(32, 0.25, {0.5, 0.5, 0.5}, clay(1e5, 1e4));
        const double dx = s.lattice.dx, height = 0.25 + shift * dx;
        s.gravity = {0, -9.81, 0};
        const Vec3<float> corner[3] = {{-2, -0.5f, -2}, {4, -0.5f, -2}, {-2, -0.5f, 4}};
        for (const Vec3<float>& c : corner) {
            Binding<float> b{};
            b.weight[0] = 1, b.offset[0] = c, b.radius = 0.5f;
            s.rig.spheres.push_back(b);
        }
        s.rig.primitives = {{3, {0, 1, 2}, 0}};
        s.tools = {{ContactMode::separate, 0.5, false, true}};
        const auto solver = cpu_solver(s);
        for (int f = 0; f < 40; ++f) solver->advance(still({0.5, height, 0.5}), frame);
        double lowest = 1;
        for (const auto& p : solver->particles()) lowest = std::fmin(lowest, p.x.y);
        // The lowest particle stands for dx / 4 of clay below it.
        EXPECT_NEAR(lowest - dx / 4, height, 0.3 * dx)
            << "plane " << shift << " cells above a node";
    }
}

// A sphere of 2.5 cells that is suddenly in the middle of a ball of clay.
Given intruded()
{
    Given s = ball(32, 0.4, {0.5, 0.5, 0.5}, clay(1e5, 3e3));
    Binding<float> b{};
    b.weight[0] = 1, b.radius = 0.08f;
    s.rig.spheres = {b};
    s.rig.primitives = {{1, {0, 0, 0}, 0}};
    s.tools = {{ContactMode::separate, 0.5, false, true}};
    return s;
}

// The farthest that clay is moved in a frame [m].
double farthest(Simulator& solver, const std::function<float(int)>& size)
{
    double way = 0;
    for (int f = 0; f < 20; ++f) {
        const auto before = solver.particles();
        Motion m = still({0.5, 0.5, 0.5});
        m.size = {size(f)};
        solver.advance(m, frame);
        const auto after = solver.particles();
        for (std::size_t i = 0; i < after.size(); ++i)
            way = std::fmax(way, length(after[i].x - before[i].x));
    }
    return way;
}

TEST_P(EveryBackend, AToolThatGrowsInsideOfClayMovesItAsideAndOneThatIsSuddenlyThereThrowsIt)
{
    const auto sudden = make(intruded()), growing = make(intruded());
    const double dx = 1.0 / 32;
    EXPECT_GT(farthest(*sudden, [](int) { return 1.0f; }), 2 * dx);
    // It grows by 0.17 dx a frame; the farthest is one particle that was near its middle.
    EXPECT_LT(farthest(*growing, [](int f) { return std::min(1.0f, float(f + 1) / 15); }), dx);
    // It has made its room: what is left inside is what contact leaves anywhere.
    for (const double depth : growing->penetration()) EXPECT_LT(depth, 0.1 * dx);
}

TEST(Solver, AParticleThatIsNotANumberIsPutBackAndCounted)
{
    Given s = ball(32, 0.2, {0.5, 0.5, 0.5}, clay(1e5, 1e4));
    s.particles[100].C.a.x = NAN;
    const auto solver = cpu_solver(s);
    const FrameStats stats = solver->advance(still(), frame);
    EXPECT_GT(stats[Count::repaired], 0);
    for (const auto& p : solver->particles())
        EXPECT_TRUE(std::isfinite(p.x.x + p.v.x + p.e.xx + p.C.a.x));
}

}  // namespace
}  // namespace knead
