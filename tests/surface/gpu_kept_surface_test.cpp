// A surface that keeps what has not moved since the last one, against one that knows of none: equal
// to the bit after every frame, whatever moves, rests, comes or goes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "host/bench/ball.h"
#include "host/solver/editable_simulator.h"
#include "host/surface/gpu_surface.h"
#include "tests/solver/same_bits.h"
#include "tests/surface/surface_clay.h"

namespace knead {
namespace {

using Given = knead::Setup;

constexpr double frame = 1.0 / 90;
constexpr int nodes = 32;

// Clay in a ball, or in a cube as wide, thrown.
struct Lump {
    Vec3<double> centre;
    double radius;
    Vec3<double> v;  // [m/s]
    int object = 0;
    bool cube = false;
};

// Without weight, 8 particles a cell. Sleeps at once where it is slower than 1 cm/s, and wakes
// where it is pushed by more than `push` [m/s^2].
Given thrown(const std::vector<Lump>& lumps, double push = 5)
{
    Given s = knead::ball(nodes);
    s.gravity = {0, 0, 0};
    s.particles.clear();
    unsigned seed = 1;
    for (const Lump& lump : lumps) {
        const auto in = [&](Vec3<double> x) {
            const Vec3<double> d = x - lump.centre;
            const double off =
                lump.cube ? std::max({std::fabs(d.x), std::fabs(d.y), std::fabs(d.z)}) : length(d);
            return off < lump.radius;
        };
        for (Particle<double> q : filled(0.5 / nodes, seed++, lump.object, in)) {
            q.v = lump.v;
            s.particles.push_back(q);
        }
    }
    s.materials.push_back(s.materials[0]);
    s.materials[1].category = 7;
    s.rest = {RestMode::sleep, 0.01, 1, push, 0};
    return s;
}

// One thrown at another that rests; one of another kind in nobody's way; one that flies, several
// cells in a frame.
std::vector<Lump> lumps()
{
    return {{{0.25, 0.6, 0.5}, 0.1, {2, -1.2, 0.1}},
            {{0.65, 0.35, 0.5}, 0.18, {0, 0, 0}},
            {{0.75, 0.75, 0.3}, 0.1, {0, 0, 0}, 1},
            {{0.2, 0.78, 0.76}, 0.08, {6, 0, 0}}};
}

// Softened not at all, in one round, in three.
std::vector<SurfaceOptions> rules() { return {rule_of(31), rule_of(64), rule_of(96)}; }

void expect_same(const GpuSurface& a, const GpuSurface& b, const std::string& where)
{
    EXPECT_TRUE(same_bits(a.meshes(), b.meshes())) << where;
    for (const int category : {0, 7})
        EXPECT_TRUE(same_bits(a.density(category).value, b.density(category).value)) << where;
}

// Advances and makes surfaces by all rules, frame by frame; what was made anew after the first.
template <class Advance>
SurfaceWork followed(const Given& s, int frames, Advance&& advance,
                     const std::vector<SurfaceOptions>& by = rules())
{
    const auto solver = gpu_solver(s, 0);
    std::vector<std::unique_ptr<GpuSurface>> kept;
    for (const SurfaceOptions& options : by)
        kept.push_back(std::make_unique<GpuSurface>(s.particles, s.materials, options));
    SurfaceWork sum;
    for (int f = 0; f <= frames; ++f) {
        if (f > 0) advance(*solver, f);
        for (std::size_t k = 0; k < kept.size(); ++k) {
            const std::string where = "frame " + std::to_string(f) + ", rule " + std::to_string(k);
            SurfaceStats stats, fresh_tally;
            GpuSurface fresh(s.particles, s.materials, by[k]);
            kept[k]->surface(*solver->clay(), &stats);
            fresh.surface(*solver->clay(), &fresh_tally);
            expect_same(*kept[k], fresh, where);
            EXPECT_EQ(stats.outside, fresh_tally.outside) << where;
            const SurfaceWork work = kept[k]->work();
            EXPECT_GT(work.blocks, 0);
            EXPECT_EQ(fresh.work().smoothed, fresh.work().blocks);
            if (f == 0) continue;
            sum.blocks += work.blocks, sum.deposited += work.deposited;
            sum.smoothed += work.smoothed;
        }
    }
    return sum;
}

class GpuKeptSurface : public ::testing::Test {
  protected:
    void SetUp() override
    {
        if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    }
};

TEST_F(GpuKeptSurface, IsThatOfAllParticlesWhileClayFliesIntoClayThatSleeps)
{
    const Given s = thrown(lumps(), 50);
    const long count = long(s.particles.size());
    const SurfaceWork work = followed(s, 20, [&](Simulator& solver, int f) {
        const FrameStats t = solver.advance(closing(f * frame, frame), frame);
        EXPECT_GT(t[Count::moved], 0);
        EXPECT_LT(t[Count::moved], t.substeps * count);
    });
    EXPECT_GT(work.deposited, 100);
    EXPECT_LT(work.deposited, work.smoothed);
    EXPECT_LT(double(work.smoothed), 0.95 * double(work.blocks));
}

TEST_F(GpuKeptSurface, IsThatOfAllParticlesWhereClayIsWokenByAPush)
{
    long woken = 0;
    followed(thrown(lumps()), 12, [&](Simulator& solver, int f) {
        woken += solver.advance(closing(f * frame, frame), frame)[Count::woken];
    });
    EXPECT_GT(woken, 0);
}

TEST_F(GpuKeptSurface, IsThatOfAllParticlesWhereOnlyClayNearToolsMoves)
{
    Given s = knead::ball(nodes);
    add_tools(s);
    s.rest = {RestMode::localized, 0.01, 1, 5, 0.04};
    long projected = 0;
    const SurfaceWork work = followed(s, 12, [&](Simulator& solver, int f) {
        projected += solver.advance(closing((f - 1) * frame, frame), frame)[Count::projected];
    });
    EXPECT_GT(projected, 0);
    EXPECT_LT(double(work.smoothed), 0.9 * double(work.blocks));
}

// Almost a cell in a frame's only substep, out of all blocks that move: there nobody looks at it
// again. On a density four times as fine, so that its blocks end where those of the clay do.
TEST_F(GpuKeptSurface, KnowsWhereClayHasComeToInTheLastSubstep)
{
    const double far = 0.98 / nodes, dt = 1e-3;
    struct Throw {
        Vec3<double> from, way;
    };
    for (const Throw& out :
         {Throw{{0.26, 0.5, 0.5}, {1, 0.05, -0.05}}, Throw{{0.26, 0.635, 0.5}, {-0.05, 1, 0.05}}}) {
        Given s = thrown({{out.from, 0.1, (far / dt) * out.way, 0, true},
                          {{0.75, 0.4, 0.6}, 0.1, {0, 0, 0}, 1}});
        for (Material<double>& m : s.materials) m.mu = 300, m.lambda = 500;
        add_tools(s);
        s.grid_contact = false, s.passes = 0;
        s.step.fixed = dt;
        s.rest = {RestMode::localized, 0.01, 1, 5, 0.01};
        const Motion still{wrists(0.31, 0), wrists(0.31, 0), {1, 0}};
        followed(s, 6,
                 [&](Simulator& solver, int) { EXPECT_EQ(solver.advance(still, dt).substeps, 1); },
                 {rule_of(96), rule_of(128)});
    }
}

TEST_F(GpuKeptSurface, IsNotMadeAgainWhereNothingMoves)
{
    std::vector<Lump> all = lumps();
    for (Lump& lump : all) lump.v = {0, 0, 0};
    const Given s = thrown(all);
    const auto solver = gpu_solver(s, 0);
    for (const SurfaceOptions& options : rules()) {
        GpuSurface kept(s.particles, s.materials, options),
            fresh(s.particles, s.materials, options);
        const auto first = kept.surface(*solver->clay());
        ASSERT_EQ(first.size(), 2u);
        for (int round = 0; round < 3; ++round) {
            EXPECT_EQ(solver->advance(closing(0, frame), frame)[Count::moved], 0);
            SurfaceStats stats;
            EXPECT_TRUE(same_bits(kept.surface(*solver->clay(), &stats), first));
            EXPECT_EQ(kept.work().deposited, 0);
            EXPECT_EQ(kept.work().smoothed, 0);
            EXPECT_GT(kept.work().blocks, 0);
        }
        fresh.surface(*solver->clay());
        expect_same(kept, fresh, "");
    }
}

TEST_F(GpuKeptSurface, IsMadeBehindTheFrameThatMovesItsClay)
{
    const Given s = thrown(lumps());
    const auto solver = gpu_solver(s, 0);
    GpuSurface kept(s.particles, s.materials, rule_of(64)),
        fresh(s.particles, s.materials, rule_of(64));
    kept.launch(*solver->clay());
    for (int f = 0; f < 4; ++f) {
        solver->submit(closing(0, frame), frame);
        kept.launch(*solver->clay());
        kept.launch(*solver->clay());  // of which nothing comes
        solver->collect();
    }
    fresh.surface(solver->particles());
    expect_same(kept, fresh, "");
    EXPECT_EQ(kept.work().smoothed, 0);
}

TEST_F(GpuKeptSurface, KeepsNothingOfOtherClay)
{
    const Given s = thrown(lumps());
    std::vector<Lump> all = lumps();
    for (Lump& lump : all) lump.centre.x += 0.02;
    const Given other = thrown(all);
    const auto solver = gpu_solver(s, 0), another = gpu_solver(other, 0);
    GpuSurface kept(s.particles, s.materials, rule_of(64));
    const auto same = [&](const auto& clay, const char* where) {
        GpuSurface fresh(s.particles, s.materials, rule_of(64));
        kept.surface(clay), fresh.surface(clay);
        expect_same(kept, fresh, where);
    };
    same(*solver->clay(), "first");
    same(*another->clay(), "another's");
    same(*solver->clay(), "the first again");
    same(other.particles, "the host's");
    same(s.particles, "others of the host");
    same(*another->clay(), "another's again");
    EXPECT_EQ(kept.stage_times().size(), 10u);
    same(*another->clay(), "measured");
    another->advance(closing(0, frame), frame);
    same(*another->clay(), "moved");
}

// Elsewhere clay moves, and there the surface is mended.
TEST_F(GpuKeptSurface, SaysEachTimeThatClayIsTooDense)
{
    Given s = thrown(lumps());
    for (Particle<double>& q : s.particles)
        if (q.object == 1) q.x = {0.75, 0.75, 0.3};
    const auto solver = gpu_solver(s, 0);
    GpuSurface kept(s.particles, s.materials, rule_of(64));
    for (int round = 0; round < 3; ++round) {
        EXPECT_THROW(kept.surface(*solver->clay()), std::runtime_error) << round;
        EXPECT_GT(solver->advance(closing(0, frame), frame)[Count::moved], 0);
    }
}

}  // namespace
}  // namespace knead
