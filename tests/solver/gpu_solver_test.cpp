// Whole frames on the device against the same frames on the CPU, through the one face both have.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <string>

#include "cuda/mpm/particle.h"
#include "cuda/mpm/time_step.h"
#include "host/bench/ball.h"
#include "host/solver/gpu/region_padding.h"
#include "host/solver/substep.h"
#include "tests/solver/stepwise.h"

namespace knead {
namespace {

constexpr double frame = 1.0 / 90;

// The ball between two tools, on 32^3 nodes.
Setup scene(bool tools)
{
    knead::Setup s = ball(32);
    if (tools) add_tools(s);
    return s;
}

// One object per flow, side by side.
Setup menagerie()
{
    knead::Setup s = ball(32);
    const double dx = s.lattice.dx;
    const Material<double> clay = s.materials[0];
    s.materials.clear();
    for (Plasticity plasticity :
         {Plasticity::none, Plasticity::von_mises, Plasticity::drucker_prager, Plasticity::clamp,
          Plasticity::herschel_bulkley, Plasticity::fluid}) {
        Material<double> m = clay;
        m.plasticity = plasticity;
        m.elasticity = plasticity == Plasticity::drucker_prager ? Elasticity::hencky
                       : plasticity == Plasticity::clamp        ? Elasticity::fixed_corotated
                                                                : Elasticity::neo_hookean;
        m.friction = 0.6, m.compress = 0.025, m.stretch = 0.0075, m.snow = 5;
        m.bulk = 1e5, m.exponent = plasticity == Plasticity::fluid ? 7 : 0.8;
        m.viscosity = plasticity == Plasticity::fluid ? 1 : 100;
        m.yield = 2e3;
        s.materials.push_back(m);
    }
    for (Particle<double>& q : s.particles) {
        q.object = std::clamp(int((q.x.x - 0.25) / 0.5 * 6), 0, 5);
        q.v = {0, q.x.x > 0.5 ? -3.0 : 3.0, dx * q.object};
    }
    return s;
}

struct Result {
    std::vector<Particle<double>> particles;
    FrameStats last;
    std::vector<double> depths;
    int substeps = 0;
    long projected = 0, repaired = 0, yielded = 0;
};

Result played(Simulator& solver, int frames)
{
    Result r;
    for (int f = 0; f < frames; ++f) {
        r.last = solver.advance(closing(f * frame, frame), frame);
        r.substeps += r.last.substeps, r.projected += r.last[Count::projected];
        r.repaired += r.last[Count::repaired], r.yielded += r.last[Count::yielded];
    }
    r.particles = solver.particles();
    r.depths = solver.penetration();
    return r;
}

double farthest(const Result& a, const Result& b)
{
    double d = 0;
    EXPECT_EQ(a.particles.size(), b.particles.size());
    for (std::size_t i = 0; i < a.particles.size(); ++i)
        d = std::fmax(d, length(a.particles[i].x - b.particles[i].x));
    return d;
}

class GpuSolver : public ::testing::Test {
  protected:
    void SetUp() override
    {
        if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    }
};

TEST_F(GpuSolver, MovesTheBallAsTheCpuDoes)
{
    const knead::Setup s = scene(false);
    const Result gpu = played(*gpu_solver(s, 0), 3), cpu = played(*cpu_solver(s), 3);
    EXPECT_EQ(gpu.substeps, cpu.substeps);
    EXPECT_LT(farthest(gpu, cpu), 1e-3 * s.lattice.dx);
    EXPECT_EQ(gpu.repaired, 0);
}

// In short substeps, for contact is chaotic: on the CPU the same ball begun half an ulp elsewhere
// (24 tries) ends at most 0.016 cells and 0.2 % of projections away; at a courant of 0.85 up to
// 0.08 cells and 3 %, so that one run in four broke these bounds by chance.
TEST_F(GpuSolver, SqueezesTheBallAsTheCpuDoes)
{
    knead::Setup s = scene(true);
    s.step.courant = 0.2;
    const Result gpu = played(*gpu_solver(s, 0), 8), cpu = played(*cpu_solver(s), 8);
    EXPECT_NEAR(gpu.substeps, cpu.substeps, 2);
    EXPECT_GT(gpu.projected, 100);
    EXPECT_NEAR(double(gpu.projected), double(cpu.projected), 0.02 * double(cpu.projected));
    EXPECT_NEAR(double(gpu.yielded), double(cpu.yielded), 0.02 * double(cpu.yielded) + 10);
    EXPECT_NEAR(gpu.last.found_depth, cpu.last.found_depth, 0.05 * cpu.last.found_depth + 1e-6);
    EXPECT_LT(farthest(gpu, cpu), 0.05 * s.lattice.dx);
    double deepest = 0;
    for (double d : gpu.depths) deepest = std::fmax(deepest, d);
    EXPECT_LT(deepest, 0.25 * s.lattice.dx);  // what is left to velocities (19)
}

TEST_F(GpuSolver, TreatsEveryMaterialAsTheCpuDoes)
{
    const knead::Setup s = menagerie();
    const Result gpu = played(*gpu_solver(s, 0), 1), cpu = played(*cpu_solver(s), 1);
    EXPECT_EQ(gpu.substeps, cpu.substeps);
    EXPECT_GT(gpu.yielded, 1000);
    EXPECT_NEAR(double(gpu.yielded), double(cpu.yielded), 0.02 * double(cpu.yielded));
    EXPECT_LT(farthest(gpu, cpu), 0.01 * s.lattice.dx);
}

TEST_F(GpuSolver, DeterministicRunsAgreeToTheBit)
{
    knead::Setup s = scene(true);
    s.deterministic = true;
    const Result a = played(*gpu_solver(s, 0), 6), b = played(*gpu_solver(s, 0), 6);
    for (std::size_t i = 0; i < a.particles.size(); ++i) {
        const Particle<double>&p = a.particles[i], &q = b.particles[i];
        ASSERT_TRUE(p.x.x == q.x.x && p.x.y == q.x.y && p.x.z == q.x.z && p.v.x == q.v.x &&
                    p.v.y == q.v.y && p.v.z == q.v.z && p.e.xx == q.e.xx && p.k == q.k)
            << i;
    }
    EXPECT_EQ(a.last[Count::yielded], b.last[Count::yielded]);
    EXPECT_EQ(a.last.dt_min, b.last.dt_min);
}

TEST_F(GpuSolver, KeepsMomentumWhereNothingTouches)
{
    knead::Setup s = scene(false);
    s.gravity = {0, 0, 0};
    for (Particle<double>& q : s.particles) q.v = {0.3 + q.x.y, -0.2, q.x.x};
    Vec3<double> before{}, after{};
    for (const Particle<double>& q : s.particles) before = before + q.v;
    const Result r = played(*gpu_solver(s, 0), 4);
    for (const Particle<double>& q : r.particles) after = after + q.v;
    EXPECT_GT(r.substeps, 4);
    EXPECT_LT(length(after - before), 1e-5 * length(before));
}

TEST_F(GpuSolver, PassesThroughToolsThatAreNotActive)
{
    const knead::Setup s = scene(true);
    const auto solver = gpu_solver(s, 0);
    Motion motion = closing(0.11, frame);
    motion.active = {0, 0};
    const FrameStats t = solver->advance(motion, frame);
    EXPECT_EQ(t[Count::projected], 0);
    EXPECT_TRUE(solver->penetration().empty());
    motion.active = {0, 1};
    EXPECT_GT(solver->advance(motion, frame)[Count::projected], 0);
}

TEST_F(GpuSolver, TakesPreciselyTheFixedStepsOfAFrame)
{
    knead::Setup s = scene(true);
    s.step.fixed = 1e-4;
    const auto solver = gpu_solver(s, 0);
    for (int f = 0; f < 3; ++f) {
        const FrameStats t = solver->advance(closing(f * 5e-4, 5e-4), 5e-4);
        EXPECT_EQ(t.substeps, 5);
        EXPECT_NEAR(t.dt_min, 1e-4, 1e-12);
    }
    EXPECT_EQ(solver->advance(closing(0, 0), 0).substeps, 0);
}

TEST_F(GpuSolver, PutsAParticleBackThatIsNotANumber)
{
    knead::Setup s = scene(false);
    s.particles[500].v.x = std::nan("");
    const auto solver = gpu_solver(s, 0);
    long repaired = 0;
    for (int f = 0; f < 3; ++f)
        repaired += solver->advance(closing(0, frame), frame)[Count::repaired];
    EXPECT_GT(repaired, 0);
    for (const Particle<double>& q : solver->particles())
        ASSERT_TRUE(std::isfinite(length(q.x)) && std::isfinite(length(q.v)));
}

TEST_F(GpuSolver, MeasuringItsStagesChangesNothing)
{
    knead::Setup s = scene(true);
    s.deterministic = true;
    const auto measured = gpu_solver(s, 0), left_alone = gpu_solver(s, 0);
    played(*measured, 4), played(*left_alone, 4);
    double sum = 0;
    for (const StageTime& t : stage_times(*measured)) sum += t.seconds;
    EXPECT_GT(sum, 0);
    EXPECT_EQ(measured->penetration().size(), left_alone->penetration().size());
    EXPECT_EQ(farthest(played(*measured, 2), played(*left_alone, 2)), 0);
}

// Twelve rows of 16 bytes and two ids, and of many seven rows; what CUB asks for is less than one
// byte.
TEST_F(GpuSolver, HoldsTwoHundredBytesAParticleAndOfManyAHundredAndTwenty)
{
    knead::Setup s = scene(true);
    const std::vector<Particle<double>> ball = s.particles;
    const auto memory_of = [&](std::size_t count) {
        s.particles.resize(count);
        for (std::size_t i = 0; i < count; ++i) s.particles[i] = ball[i % ball.size()];
        return double(gpu_solver(s, 0, whole_lattice)->memory());
    };
    const auto each = [&](std::size_t fewer, std::size_t more) {
        return (memory_of(more) - memory_of(fewer)) / double(more - fewer);
    };
    const double of_few = each(100000, few_particles),
                 of_many = each(few_particles + 1, few_particles + 500000);
    EXPECT_GE(of_few, 200);
    EXPECT_LT(of_few, 201);
    EXPECT_GE(of_many, 120);
    EXPECT_LT(of_many, 121);
}

TEST_F(GpuSolver, TakesAFrameWhileAnotherIsUnderWay)
{
    knead::Setup s = scene(true);
    s.deterministic = true;
    const Result one_by_one = played(*gpu_solver(s, 0), 6);
    const auto solver = gpu_solver(s, 0);
    EXPECT_THROW(solver->collect(), std::logic_error);
    solver->submit(closing(0, frame), frame);
    long waits = 0, projected = 0;
    for (int f = 1; f <= 6; ++f) {
        const long before = gpu_waits();
        if (f < 6) solver->submit(closing(f * frame, frame), frame);
        waits += gpu_waits() - before;
        if (f == 1) {
            EXPECT_THROW(solver->submit(closing(0, frame), frame), std::logic_error);
        }
        projected += solver->collect()[Count::projected];
    }
    const char* graph = std::getenv("KNEAD_GRAPH");  // "0": substep by substep, each of them waits
    EXPECT_TRUE(waits == 0 || (graph && std::string(graph) == "0")) << waits;
    EXPECT_EQ(projected, one_by_one.projected);
    Result queued;
    queued.particles = solver->particles();
    EXPECT_EQ(farthest(queued, one_by_one), 0);
}

// A frame in which nothing comes far leaves the order of the particles as it is, and the next one
// still knows it.
TEST_F(GpuSolver, GoesOnWithoutSortingEveryFrame)
{
    knead::Setup s = scene(true);
    s.step.fixed = 1e-4;
    const auto gpu = gpu_solver(s, 0), cpu = cpu_solver(s);
    for (int f = 0; f < 60; ++f) {
        const Motion motion = closing(0.06 + f * 5e-4, 5e-4);
        gpu->advance(motion, 5e-4), cpu->advance(motion, 5e-4);
    }
    Result a, b;
    a.particles = gpu->particles(), b.particles = cpu->particles();
    EXPECT_LT(farthest(a, b), 0.02 * s.lattice.dx);
    EXPECT_GT(length(a.particles[0].x - s.particles[0].x), 0);
}

// Graphs are for frames as long as most have been: longer ones, shorter ones, and those after which
// they are captured anew are to be alike.
TEST_F(GpuSolver, TakesFramesOfAnyLength)
{
    knead::Setup s = scene(true);
    s.deterministic = true;
    s.step.fixed = 1e-4;
    const auto captured = gpu_solver(s, 0);
    const auto one_by_one = [&s] {
        const Stepwise stepwise;
        return gpu_solver(s, 0);
    }();
    double time = 0.06;
    for (int f = 0; f < 75; ++f) {
        const int substeps = f < 2 ? 70 : f < 36 ? 3 : f < 73 ? 9 : 100;
        const double duration = substeps * s.step.fixed;
        const Motion motion = closing(time, duration);
        ASSERT_EQ(captured->advance(motion, duration).substeps, substeps);
        ASSERT_EQ(one_by_one->advance(motion, duration).substeps, substeps);
        time += duration;
    }
    Result a, b, before;
    a.particles = captured->particles(), b.particles = one_by_one->particles();
    before.particles = s.particles;
    EXPECT_EQ(farthest(a, b), 0);
    EXPECT_GT(farthest(a, before), 0);
}

TEST_F(GpuSolver, RefusesWhatDoesNotHangTogether)
{
    const auto refuses = [](auto&& spoil) {
        knead::Setup s = scene(true);
        spoil(s);
        EXPECT_THROW(gpu_solver(s, 0), std::invalid_argument);
    };
    refuses([](knead::Setup& s) { s.particles[3].x.y = 2; });
    refuses([](knead::Setup& s) { s.particles[3].x.y = std::nan(""); });
    refuses([](knead::Setup& s) { s.particles[3].object = 1; });
    refuses([](knead::Setup& s) { s.lattice.size.x = 33; });
    refuses([](knead::Setup& s) { s.walls.min.y = s.lattice.dx; });
    refuses([](knead::Setup& s) { s.walls.max.z = 30 * s.lattice.dx; });
    refuses([](knead::Setup& s) { s.walls.min.x = s.walls.max.x; });
    refuses([](knead::Setup& s) { s.rig.primitives[0].sphere[1] = 99; });
    refuses([](knead::Setup& s) { s.rig.primitives[1].tool = 2; });
    refuses([](knead::Setup& s) { s.rig.spheres[1].joint[2] = -1; });
    EXPECT_THROW(gpu_solver(scene(true), 99), std::runtime_error);
    Motion motion = closing(0, frame);
    motion.to.resize(joint_count);  // the second cone hangs on a wrist beyond
    EXPECT_THROW(gpu_solver(scene(true), 0)->advance(motion, frame), std::invalid_argument);
}

}  // namespace
}  // namespace knead
