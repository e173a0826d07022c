// A frame tells which tools found clay: a hand feels what it touches itself.
#include "tests/solver/back_ends.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test

constexpr double frame = 1.0 / 90;
constexpr Vec3<double> middle{0.5, 0.5, 0.5};

// A ball of clay and four tools on joints of their own: three spheres, and a blade that is
// a thin plate across x.
Given ball_and_tools()
{
    Given s;
    s.lattice = {{32, 32, 32}, 1.0 / 32};
    s.walls = walls_inside(s.lattice, 3, ContactMode::separate, 0);
    Material<double> m{};
    m.density = 1000, m.mu = 4e4, m.lambda = 6e4;
    m.volume = std::pow(s.lattice.dx / 2, 3), m.mass = m.density * m.volume;
    s.materials.push_back(m);
    for (int k = 0; k < 64 * 64 * 64; ++k) {
        Particle<double> q{};
        q.x = s.lattice.dx / 2 * Vec3<double>{k % 64 + 0.5, k / 64 % 64 + 0.5, k / 4096 + 0.5};
        if (length(q.x - middle) < 0.15) s.particles.push_back(q);
    }
    for (int t = 0; t < 4; ++t) {
        const int first = int(s.rig.spheres.size());
        for (int corner = 0; corner < (t < 3 ? 1 : 3); ++corner) {
            Binding<float> b{};
            for (int& j : b.joint) j = t;
            b.weight[0] = 1, b.radius = t < 3 ? 0.08f : 0.002f;
            if (t == 3) b.offset[0] = {0, corner == 2 ? 0.3f : 0, corner == 1 ? 0.3f : -0.3f};
            s.rig.spheres.push_back(b);
        }
        const bool plate = t == 3;
        s.rig.primitives.push_back(
            {plate ? 3 : 1, {first, plate ? first + 1 : first, plate ? first + 2 : first}, t});
        s.tools.push_back({ContactMode::separate, 0.3, t == 3, true});
    }
    return s;
}

// One of the spheres, or the blade, comes into the ball; the others stay away.
Motion one_comes(int tool)
{
    Motion m;
    const Vec3<double> side[] = {{-1, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}};
    for (int t = 0; t < 4; ++t) {
        const double to = t < 3 ? 0.21 : 0.12;
        m.from.push_back({{1, 0, 0, 0}, middle + (t == tool ? to + 0.05 : 0.3) * side[t]});
        m.to.push_back({{1, 0, 0, 0}, middle + (t == tool ? to : 0.3) * side[t]});
    }
    return m;
}

class Touched : public AgainstTheReference {};

TEST_P(Touched, IsWhatEachToolFindsItself)
{
    for (int tool = -1; tool < 4; ++tool) {
        const Given s = rounded_to_float(ball_and_tools());
        const std::uint32_t wanted = tool < 0 ? 0 : tool_bit(tool);
        EXPECT_EQ(GetParam().make(s)->advance(one_comes(tool), frame).touched, wanted) << tool;
        EXPECT_EQ(Reference(s).advance(one_comes(tool), frame).touched, wanted) << tool;
    }
    EXPECT_EQ(tool_bit(200), tool_bit(31)) << "the last bit is for all others";
}

INSTANTIATE_TEST_SUITE_P(Solver, Touched, ::testing::ValuesIn(back_ends),
                         [](const auto& end) { return end.param.name; });

}  // namespace
}  // namespace knead
