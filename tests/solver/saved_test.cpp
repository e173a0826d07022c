// What a snapshot holds is what was saved when it was taken, and reading it while frames are
// computed changes no bit of them.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "host/bench/ball.h"
#include "host/solver/editable_simulator.h"
#include "tests/solver/back_ends.h"
#include "tests/solver/same_bits.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test
constexpr double frame = 1.0 / 90;

class Saved : public OnBothDevices {};
INSTANTIATE_TEST_SUITE_P(Solver, Saved, testing::Values(false, true), device_of);

// Clay at a wall and between two cones, with Gaussians; with sleep.
Given pressed()
{
    Given s = ball(32);
    add_tools(s), add_gaussians(s, 200);
    s.deterministic = true, s.threads = 2;
    for (Particle<double>& p : s.particles) p.x.y -= 0.12;
    for (Gaussian<double>& g : s.gaussians) g.x.y -= 0.12;
    s.walls.min.y = 0.13, s.walls.mode = ContactMode::separate;
    std::erase_if(s.particles, [&](const auto& p) { return p.x.y < s.walls.min.y; });
    std::erase_if(s.gaussians, [&](const auto& g) { return g.x.y < s.walls.min.y; });
    s.rest = {RestMode::sleep, 1e-3, 3, 4.9, 0.1};
    return s;
}

void play(Simulator& solver, int from, int frames)
{
    for (int f = from; f < from + frames; ++f) solver.advance(closing(f * frame, frame), frame);
}

void expect_same(const SavedState& a, const SavedState& b)
{
    EXPECT_TRUE(same_bits(a.contents.particles, b.contents.particles));
    EXPECT_TRUE(same_bits(a.contents.gaussians, b.contents.gaussians));
    EXPECT_EQ(a.order, b.order);
    EXPECT_EQ(a.speed_squared, b.speed_squared);
    EXPECT_EQ(a.stiffness, b.stiffness);
    EXPECT_EQ(a.drift, b.drift);
    EXPECT_EQ(a.quiet_low, b.quiet_low);
    EXPECT_EQ(a.quiet_stored, b.quiet_stored);
    EXPECT_EQ(a.quiet, b.quiet);
    EXPECT_EQ(a.covered, b.covered);
    EXPECT_TRUE(same_bits(a.sliding, b.sliding));
    EXPECT_EQ(a.config.materials, b.config.materials);
    EXPECT_EQ(a.config.gravity.y, b.config.gravity.y);
    EXPECT_EQ(a.config.tools.size(), b.config.tools.size());
}

TEST_P(Saved, IsWhatWasSavedThen)
{
    const auto solver = make(pressed());
    for (int round = 0; round < 3; ++round) {
        play(*solver, 3 * round, 3);
        const SavedState then = solver->save();
        const auto snapshot = solver->snapshot();
        EXPECT_FALSE(then.sliding.empty());
        expect_same(solver->saved(*snapshot), then);
        play(*solver, 3 * round + 3, 1);
        if (round == 1) solver->remove(0), solver->set_gravity({});
        expect_same(solver->saved(*snapshot), then);
        EXPECT_THROW(make(pressed())->saved(*snapshot), std::invalid_argument);
        solver->restore(*snapshot);
    }
}

TEST_P(Saved, GoesOnInAnotherSimulator)
{
    const auto solver = make(pressed()), other = make(pressed());
    play(*solver, 0, 4);
    const auto snapshot = solver->snapshot();
    play(*solver, 4, 3);
    other->load(solver->saved(*snapshot));
    play(*other, 4, 3);
    EXPECT_TRUE(same_bits(solver->particles(), other->particles()));
    EXPECT_TRUE(same_bits(solver->gaussians(), other->gaussians()));
}

TEST_P(Saved, ReservingChangesNothing)
{
    const auto solver = make(pressed()), other = make(pressed());
    play(*solver, 0, 2), play(*other, 0, 2);
    const long version = solver->version();
    solver->reserve_snapshots(3);
    EXPECT_EQ(solver->version(), version);
    expect_same(solver->save(), other->save());
    const auto one = solver->snapshot(), two = solver->snapshot();
    EXPECT_EQ(solver->rows(*one).planes, solver->rows(*two).planes);
    play(*solver, 2, 2), play(*other, 2, 2);
    EXPECT_TRUE(same_bits(solver->particles(), other->particles()));
}

// A thread reads each snapshot while the frames after it are computed.
TEST_P(Saved, ReadingInAnotherThreadChangesNoBit)
{
    const auto solver = make(pressed()), alone = make(pressed());
    solver->reserve_snapshots(2);
    std::atomic<std::shared_ptr<const Snapshot>> newest;
    std::atomic<bool> ends = false;
    std::atomic<long> read = 0;
    std::thread reader([&] {
        while (!ends) {
            const auto snapshot = newest.exchange(nullptr);
            if (!snapshot) {
                std::this_thread::yield();
                continue;
            }
            const ClayRows rows = solver->rows(*snapshot);
            const SavedState state = solver->saved(*snapshot);
            std::vector<Vec3<double>> one, other;
            for (std::size_t i = 0; i < rows.count; ++i)
                one.push_back(cast<double>(particle_at(rows, i).x));
            for (const Particle<double>& p : state.contents.particles) other.push_back(p.x);
            EXPECT_TRUE(same_bits(one, other));
            ++read;
        }
    });
    for (int f = 0; f < 30; ++f) {
        newest = solver->snapshot();
        solver->submit(closing(f * frame, frame), frame);
        solver->submit(closing((f + 0.5) * frame, frame / 2), frame / 2);
        solver->collect(), solver->collect();
        alone->advance(closing(f * frame, frame), frame);
        alone->advance(closing((f + 0.5) * frame, frame / 2), frame / 2);
    }
    while (newest.load()) std::this_thread::yield();
    ends = true;
    reader.join();
    EXPECT_GT(read, 0);
    EXPECT_TRUE(same_bits(solver->particles(), alone->particles()));
    EXPECT_TRUE(same_bits(solver->gaussians(), alone->gaussians()));
    EXPECT_EQ(solver->save().order, alone->save().order);
}

}  // namespace
}  // namespace knead
