// Clay that comes to the end of the nodes that are stored: frames go on as if all had been.
#include <gtest/gtest.h>

#include <cmath>

#include "host/bench/ball.h"
#include "host/hands/hands.h"
#include "host/solver/gpu/region_padding.h"
#include "tests/solver/stepwise.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test
constexpr double frame = 1.0 / 90;

// Of the ball on so many nodes along an axis, what is `near` its middle [m].
Given lump(int nodes, double near)
{
    Given s = ball(nodes);
    std::erase_if(s.particles, [near](const Particle<double>& q) {
        return length(q.x - Vec3<double>{0.5, 0.5, 0.5}) > near;
    });
    s.deterministic = true;
    return s;
}

// Liquid that spreads along x and y.
Given spreading()
{
    Given s = lump(64, 0.12);
    Material<double>& m = s.materials[0];
    m.plasticity = Plasticity::fluid, m.bulk = 1e5, m.exponent = 7, m.viscosity = 1;
    for (Particle<double>& q : s.particles) q.v = {24 * (q.x.x - 0.5), 24 * (q.x.y - 0.5), 0.2};
    return s;
}

// Clay that meets, in its first substep, tools of which it is deep inside: some is thrown across
// several blocks at once.
Given overrun()
{
    Given s = lump(64, 0.12);
    for (int side = 0; side < side_count; ++side) {
        Binding<float> b{};
        for (int& j : b.joint) j = side * joint_count + wrist;
        b.weight[0] = 1, b.radius = 0.2f;
        s.rig.spheres.push_back(b);
        s.rig.primitives.push_back({1, {side, side, side}, side});
        s.tools.push_back({ContactMode::separate, 0.3, false, true});
    }
    return s;
}
const Motion inside{wrists(0.22, 0), wrists(0.21, 0), {1, 1}};

// A slab that sleeps, a lump that falls on it, and one that flies away from it.
Given sleeping()
{
    Given s = lump(64, 0.1);
    const double dx = s.lattice.dx;
    const std::size_t count = s.particles.size();
    for (std::size_t i = 0; i < count; ++i) {
        Particle<double> q = s.particles[i];
        s.particles[i].v = {0, 0, -4};
        q.x = q.x + Vec3<double>{0, 0, 0.22}, q.v = {0, 0, 4};
        s.particles.push_back(q);
    }
    for (int z = 0; z < 8; ++z)
        for (int y = 0; y < 80; ++y)
            for (int x = 0; x < 80; ++x) {
                Particle<double> q{};
                q.x = dx * Vec3<double>{3 + (x + 0.5) / 2, 3 + (y + 0.5) / 2, 3 + (z + 0.5) / 2};
                s.particles.push_back(q);
            }
    s.gravity = {0, 0, 0};
    s.walls.mode = ContactMode::sticky;
    s.rest = {RestMode::sleep, 0.05, 2, 4.9, 4 * dx};
    return s;
}

// A block with a knife in it, 2 mm thin: three velocities a node.
Given cut()
{
    Given s = lump(32, 0.15);
    const Vec3<float> corner[3] = {{0, 0, -0.6f}, {0, 0, 0.6f}, {0, 0.9f, 0}};
    for (const Vec3<float>& c : corner) {
        Binding<float> b{};
        for (int& j : b.joint) j = wrist;
        b.weight[0] = 1, b.offset[0] = c, b.radius = 1e-3f;
        s.rig.spheres.push_back(b);
    }
    s.rig.primitives = {{3, {0, 1, 2}, 0}};
    s.tools = {{ContactMode::separate, 0.1, true, true}};
    for (Particle<double>& q : s.particles) q.v = {q.x.x < 0.5 ? -3.0 : 3.0, 0, 0};
    return s;
}
Motion stroke(int f)
{
    const auto at = [](double y) {
        auto joints = wrists(0, 0);
        joints[wrist].p.y = y;
        return joints;
    };
    return {at(0.8 - 0.04 * f), at(0.76 - 0.04 * f), {1}};
}
Motion still(int) { return {wrists(0.3, 0), wrists(0.3, 0), {1, 1}}; }

struct Result {
    std::vector<Particle<double>> particles;
    std::vector<long> counts;
    std::size_t before = 0, after = 0;  // bytes held
};

void count(Result& r, const FrameStats& t)
{
    r.counts.insert(r.counts.end(),
                    {long(t.substeps), t[Count::yielded], t[Count::projected], t[Count::confined],
                     t[Count::repaired], t[Count::moved], t[Count::woken]});
}

Result played(const Given& s, RegionPadding room, int frames, Motion (*motion)(int))
{
    const auto solver = gpu_solver(s, 0, room);
    Result r;
    r.before = solver->memory();
    for (int f = 0; f < frames; ++f) count(r, solver->advance(motion(f), frame));
    r.after = solver->memory();
    r.particles = solver->particles();
    return r;
}

// The same, two frames under way wherever that may be.
Result queued(const Given& s, RegionPadding room, int frames, Motion (*motion)(int))
{
    const auto solver = gpu_solver(s, 0, room);
    Result r;
    r.before = solver->memory();
    solver->submit(motion(0), frame);
    for (int f = 1; f <= frames; ++f) {
        if (f < frames) solver->submit(motion(f), frame);
        count(r, solver->collect());
    }
    r.after = solver->memory();
    r.particles = solver->particles();
    return r;
}

void expect_close(const Result& a, const Result& b, double apart, const char* where)
{
    EXPECT_EQ(a.counts[0], b.counts[0]) << where;
    ASSERT_EQ(a.particles.size(), b.particles.size());
    double max = 0;
    for (std::size_t i = 0; i < a.particles.size(); ++i)
        max = std::fmax(max, length(a.particles[i].x - b.particles[i].x));
    EXPECT_LE(max, apart) << where;
}

// What a frame goes on with may be sorted anew, and is summed in other groups: roundings remain.
void expect_same(const Result& a, const Result& b, const char* where)
{
    EXPECT_EQ(a.counts, b.counts) << where;
    expect_close(a, b, 1e-5, where);  // [m]
}

class GpuBox : public ::testing::Test {
  protected:
    void SetUp() override
    {
        if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    }
};

TEST_F(GpuBox, LiquidThatSpreadsBeyondItMovesAsOnAWholeLattice)
{
    const Given s = spreading();
    const Result whole = played(s, whole_lattice, 12, still);
    EXPECT_EQ(whole.before, whole.after);
    for (int spare : {0, 3}) {
        const Result small = played(s, {spare, 0}, 12, still);
        expect_same(small, whole, "a graph a frame");
        EXPECT_LT(small.before, small.after);
        EXPECT_LE(small.after, whole.after);
        expect_same(queued(s, {spare, 0}, 12, still), whole, "two frames under way");
        const Stepwise stepwise;
        expect_same(played(s, {spare, 0}, 12, still), whole, "without graphs");
    }
    expect_same(queued(s, {}, 12, still), whole, "as large as it is by itself");
}

// Of float there are two grids of nodes.
TEST_F(GpuBox, SumsInFloatGoOnAlike)
{
    Given s = spreading();
    s.deterministic = false;
    const Result whole = played(s, whole_lattice, 3, still);
    expect_close(queued(s, {0, 0}, 3, still), whole, 1e-3 * s.lattice.dx, "float");
}

// Held where nodes end, it comes out of the tools some substeps later: at first it differs by as
// much, and no particle is lost, left in a tool or thrown.
TEST_F(GpuBox, ClayThatAToolThrowsBeyondItComesThereLater)
{
    const auto motion = [](int) { return inside; };
    const Given s = overrun();
    const Result whole = played(s, whole_lattice, 2, motion);
    EXPECT_GT(whole.counts[2], 1000);  // projected
    const auto solver = gpu_solver(s, 0, {0, 0});
    Result small;
    for (int f = 0; f < 2; ++f) count(small, solver->advance(inside, frame));
    small.particles = solver->particles();
    EXPECT_GT(small.counts[2], 1000);
    EXPECT_EQ(small.counts[4] + small.counts[11], whole.counts[4] + whole.counts[11]);  // repaired
    for (const double depth : solver->penetration()) EXPECT_LT(depth, 1e-3 * s.lattice.dx);
    double max = 0;
    for (std::size_t i = 0; i < whole.particles.size(); ++i)
        max = std::fmax(max, length(small.particles[i].x - whole.particles[i].x));
    EXPECT_LT(max, 3 * s.lattice.dx);
}

TEST_F(GpuBox, ClayThatWakesAsItIsStruckGoesOnAlike)
{
    Given s = sleeping();
    const Result whole = played(s, whole_lattice, 14, still);
    long woken = 0;
    for (std::size_t k = 6; k < whole.counts.size(); k += 7) woken += whole.counts[k];
    EXPECT_GT(woken, 10);
    expect_close(queued(s, {0, 0}, 14, still), whole, 0.05 * s.lattice.dx, "asleep");
}

TEST_F(GpuBox, CutClayHasThreeVelocitiesThere)
{
    const Given s = cut();
    const Result whole = played(s, whole_lattice, 12, stroke);
    const Result small = queued(s, {0, 0}, 12, stroke);
    expect_same(small, whole, "cut");
    EXPECT_LT(small.before, small.after);
}

// A ball half as wide as the lattice, of which an eighth would be its box without room around and
// even rows.
TEST_F(GpuBox, OfALatticeTwiceAsWideAsTheClayLessThanHalfIsStored)
{
    const Given s = ball(128);
    const double held = double(gpu_solver(s, 0)->memory()),
                 whole = double(gpu_solver(s, 0, whole_lattice)->memory());
    const double of_nodes = 32.0 * 128 * 128 * 128;
    EXPECT_LT(held, whole - 0.5 * of_nodes);
}

TEST_F(GpuBox, MeasuringItsStagesTakesNothingFromTheClay)
{
    const Given s = spreading();
    const auto measured = gpu_solver(s, 0, {0, 0}), whole = gpu_solver(s, 0, whole_lattice);
    Result a, b;
    for (int f = 0; f < 8; ++f) {
        count(a, measured->advance(still(f), frame));
        count(b, whole->advance(still(f), frame));
        for (const StageTime& t : stage_times(*measured)) EXPECT_TRUE(std::isfinite(t.seconds));
    }
    a.particles = measured->particles(), b.particles = whole->particles();
    expect_same(a, b, "measured");
}

TEST_F(GpuBox, WithoutMemoryForMoreItSaysSoAndKeepsTheClay)
{
    const Given s = spreading();
    for (std::size_t max : {1u, 50000u, 100000u}) {
        const auto solver = gpu_solver(s, 0, {0, max}), whole = gpu_solver(s, 0, whole_lattice);
        bool refused = false;
        for (int f = 0; f < 30 && !refused; f += 2) {
            whole->advance(still(f), frame), whole->advance(still(f), frame);
            solver->submit(still(f), frame), solver->submit(still(f), frame);
            try {
                solver->collect(), solver->collect();
            } catch (const std::runtime_error& e) {
                EXPECT_NE(std::string(e.what()).find("MiB"), std::string::npos) << e.what();
                refused = true;
            }
        }
        EXPECT_TRUE(refused) << max;
        EXPECT_THROW(solver->collect(), std::logic_error);  // none is under way any more
        const auto a = solver->particles(), b = whole->particles();
        ASSERT_EQ(a.size(), b.size());
        double max_x = 0, max_v = 0;  // within the two frames nothing comes far
        for (std::size_t i = 0; i < a.size(); ++i) {
            max_x = std::fmax(max_x, length(a[i].x - b[i].x));
            max_v = std::fmax(max_v, length(a[i].v - b[i].v));
        }
        EXPECT_LT(max_x, 0.2) << max;
        EXPECT_LT(max_v, 8) << max;
        const auto goes_on = [&] {  // until clay needs more room again
            for (int f = 0; f < 4; ++f) solver->advance(still(0), frame);
        };
        EXPECT_THROW(goes_on(), std::runtime_error);
    }
}

}  // namespace
}  // namespace knead
