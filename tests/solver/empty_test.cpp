// A solver that begins without clay does what one does that was made with it, once it has it.
#include "host/bench/ball.h"
#include "tests/solver/back_ends.h"
#include "tests/solver/same_bits.h"

namespace knead {
namespace {

class WithoutClay : public AgainstTheReference {};

TEST_P(WithoutClay, BeginsAndTakesItLater)
{
    constexpr double frame = 1.0 / 90;
    knead::Setup full = ball(24);
    full.threads = 1;
    add_tools(full);
    knead::Setup bare = full;
    bare.particles.clear();
    full.materials.push_back(full.materials.at(0));
    for (Particle<double>& p : full.particles) p.object = 1;
    const auto later = GetParam().make(bare), once = GetParam().make(full);
    EXPECT_TRUE(later->particles().empty());
    EXPECT_EQ(later->advance(closing(0, frame), frame)[Count::moved], 0);
    EXPECT_TRUE(later->penetration().empty());
    EXPECT_EQ(later->add(full.materials[1], full.particles), 1);
    const auto edited = GetParam().make(full);  // rows to build an edit in have room, too
    EXPECT_EQ(edited->add(full.materials[1], {full.particles[0]}), 2);
    EXPECT_LT(double(later->memory()), 1.1 * double(edited->memory()))
        << "of nodes about the clay alone";
    long projected = 0;
    for (int f = 0; f < 4; ++f) {
        projected += later->advance(closing(f * frame, frame), frame)[Count::projected];
        once->advance(closing(f * frame, frame), frame);
    }
    EXPECT_GT(projected, 0);
    const std::vector<Particle<double>> a = later->particles(), b = once->particles();
    ASSERT_EQ(a.size(), b.size());
    if (GetParam().deterministic) {
        EXPECT_TRUE(same_bits(a, b));
    }
    Vec3<double> middle{}, other{};
    for (std::size_t i = 0; i < a.size(); ++i) middle = middle + a[i].x, other = other + b[i].x;
    EXPECT_LT(length(middle - other), 1e-5 * double(a.size()));
}

INSTANTIATE_TEST_SUITE_P(BackEnds, WithoutClay, ::testing::ValuesIn(back_ends),
                         [](const auto& device) { return device.param.name; });

}  // namespace
}  // namespace knead
