// Splats that are split and added between the frames of a solver, on every back end that is there.
#include "host/splats/upkeep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <future>

#include "host/solver/reference.h"
#include "tests/solver/same_bits.h"
#include "tests/splats/kneaded.h"

namespace knead::kneaded {
namespace {

using Given = Setup;  // the name is a member of testing::Test
using Gaussians = std::vector<Gaussian<double>>;

class Kept : public testing::TestWithParam<bool> {
  protected:
    void SetUp() override
    {
        if (GetParam() && !gpu_present()) GTEST_SKIP() << "no CUDA device";
    }
    std::unique_ptr<EditableSimulator> make(const Given& s) const
    {
        Given same = s;
        same.deterministic = true;
        return GetParam() ? gpu_solver(same, 0) : cpu_solver(same);
    }
};
INSTANTIATE_TEST_SUITE_P(Splats, Kept, testing::Values(false, true),
                         [](const auto& at) { return std::string(at.param ? "cuda" : "cpu"); });

Body drawn()
{
    Body b = body_of(0.01);
    draw_out(b, 4, 10 * frame);
    return b;
}

void advance(EditableSimulator& solver, int frames, SplatUpkeep* upkeep = nullptr, int from = 0)
{
    for (int f = from + 1; f <= from + frames; ++f) {
        solver.advance({}, frame);
        if (upkeep) upkeep->after(f, solver);
    }
}

UpkeepOptions options()
{
    UpkeepOptions r;
    r.splits = r.refills = true, r.every = 2, r.split.budget = 300;
    return r;
}

TEST_P(Kept, AllMayBeReplacedAndTheClayDoesNotHearOfIt)
{
    const Body b = drawn();
    const auto solver = make(b.setup), other = make(b.setup);
    advance(*solver, 2), advance(*other, 2);
    Gaussians all = solver->gaussians();
    std::reverse(all.begin(), all.end());
    all.resize(all.size() - 10);
    all.push_back(gaussian_at(middle, 0));
    all.back().F.b = {0.5, 2, 0};
    solver->set_gaussians(all);
    EXPECT_TRUE(same_bits(solver->gaussians(), all));
    advance(*solver, 3), advance(*other, 3);
    EXPECT_TRUE(same_bits(solver->particles(), other->particles()));
    const Gaussians turned = solver->gaussians(), plain = other->gaussians();
    for (std::size_t i = 0; i + 1 < turned.size(); ++i)
        ASSERT_TRUE(same_bits(Gaussians{turned[i]}, {plain[plain.size() - 1 - i]})) << i;
    EXPECT_GT(length(turned.back().F.b), 1);
    solver->set_gaussians({});
    EXPECT_TRUE(solver->gaussians().empty());
    advance(*solver, 1), advance(*other, 1);
    EXPECT_TRUE(same_bits(solver->particles(), other->particles()));
    all[3].x.y = 0.01;
    EXPECT_THROW(other->set_gaussians(all), std::invalid_argument);
    all[3] = all[4], all[5].object = 3;
    EXPECT_THROW(other->set_gaussians(all), std::invalid_argument);
    EXPECT_EQ(other->gaussians().size(), plain.size());
}

TEST_P(Kept, TheyGrowWhenDueUpToTheCapacity)
{
    const Body b = drawn();
    UpkeepOptions few = options();
    few.capacity = b.splats.count() + 700;
    SplatUpkeep upkeep(few, b.splats.cloud);
    const auto solver = make(b.setup), bare = make(b.setup);
    std::size_t count = b.splats.count();
    for (int f = 1; f <= 12; ++f) {
        solver->advance({}, frame), bare->advance({}, frame);
        const UpkeepReport done = upkeep.after(f, *solver);
        EXPECT_TRUE(f % 2 == 0 || done.split + done.added == 0);
        EXPECT_LE(done.split, 300u);
        count += done.split + done.added;
        ASSERT_EQ(solver->gaussians().size(), count);
        ASSERT_EQ(upkeep.cloud().count(), count);
    }
    EXPECT_EQ(count, few.capacity) << "not drawn out enough";
    EXPECT_TRUE(same_bits(solver->particles(), bare->particles()));
}

// As a checkpoint does.
TEST_P(Kept, TheSavedStateGoesOnInTheSameBits)
{
    const Body b = drawn();
    SplatUpkeep first(options(), b.splats.cloud), second(options(), b.splats.cloud);
    const auto solver = make(b.setup), loaded = make(b.setup);
    advance(*solver, 9, &first);
    const SavedState state = solver->save();
    second.set_state(first.state());
    ASSERT_GT(first.cloud().count(), b.splats.count());
    loaded->load(state);
    advance(*solver, 4, &first, 9), advance(*loaded, 4, &second, 9);
    EXPECT_GT(first.cloud().count(), state.contents.gaussians.size());
    EXPECT_TRUE(same_bits(solver->gaussians(), loaded->gaussians()));
    EXPECT_TRUE(same_bits(first.cloud().scale, second.cloud().scale));
    EXPECT_TRUE(same_bits(first.cloud().opacity, second.cloud().opacity));
}

// Planned by another thread while frames go on: what comes of it is put where the clay is by then.
TEST_P(Kept, ItMayGoOnBesideFrames)
{
    const Body b = drawn();
    SplatUpkeep upkeep(options(), b.splats.cloud);
    const auto solver = make(b.setup), bare = make(b.setup);
    advance(*solver, 4), advance(*bare, 4);
    const auto shown = upkeep.shared();
    const UpkeepTask task = upkeep.task();
    auto plan =
        std::async(std::launch::async, [&, then = solver->snapshot(), config = solver->config()] {
            return task.plan(solver->held(*then), config);
        });
    advance(*solver, 3), advance(*bare, 3);
    UpkeepPlan made = plan.get();
    const GaussianEdits edits = made.edits;
    const UpkeepReport done = upkeep.adopt(std::move(made), *solver);
    EXPECT_EQ(done.split, 300u);
    EXPECT_GT(done.added, 0u);
    EXPECT_EQ(shown->count(), b.splats.count()) << "who draws them has those of before";
    ASSERT_EQ(upkeep.cloud().count(), b.splats.count() + done.split + done.added);
    const Gaussians now = solver->gaussians(), before = bare->gaussians();
    ASSERT_EQ(now.size(), upkeep.cloud().count());
    for (std::size_t k = 0; k < edits.splits.size(); ++k) {
        const GaussianSplit& s = edits.splits[k];
        const Gaussian<double>&first = now[std::size_t(s.index)], &second = now[before.size() + k];
        const Vec3<double> x = before[std::size_t(s.index)].x;
        ASSERT_LT(length(first.x - (x - s.way)), 1e-6) << k;
        ASSERT_LT(length(second.x - (x + s.way)), 1e-6) << k;
    }
    const auto q = bare->particles();
    for (std::size_t k = 0; k < edits.added.size(); ++k) {
        const GaussianBeside& a = edits.added[k];
        const Vec3<double> x = now[before.size() + edits.splits.size() + k].x;
        ASSERT_LT(length(x - (q[std::size_t(a.particle)].x + a.way)), 1e-6) << k;
    }
    advance(*solver, 2), advance(*bare, 2);
    EXPECT_TRUE(same_bits(solver->particles(), bare->particles()));
}

TEST(KeptOnTheCpu, TheBitsAreTheSameForAnyNumberOfThreads)
{
    Body b = drawn();
    Gaussians wanted;
    for (const int threads : {1, 2, 5}) {
        b.setup.threads = threads;
        SplatUpkeep upkeep(options(), b.splats.cloud);
        const auto solver = cpu_solver(b.setup);
        advance(*solver, 10, &upkeep);
        if (threads == 1) wanted = solver->gaussians();
        EXPECT_TRUE(same_bits(solver->gaussians(), wanted)) << threads;
    }
    EXPECT_GT(wanted.size(), b.splats.count());
}

}  // namespace
}  // namespace knead::kneaded
