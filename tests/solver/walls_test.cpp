// Clay at walls that stand on a plane of nodes, as all back ends have it: as exact as without them.
#include <algorithm>
#include <cmath>

#include "host/verify/clay.h"
#include "tests/solver/back_ends.h"
#include "tests/solver/samples.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test
using Particles = std::vector<Particle<double>>;

// What the reference and a back end make of it, by the particles' numbers.
struct Ends {
    Particles exact, mine;
};
class AtAWall : public AgainstTheReference {
  protected:
    Ends both(const Given& s, int frames, double frame) const
    {
        const auto mine = GetParam().make(s);
        Reference reference(s);
        for (int i = 0; i < frames; ++i) mine->advance({}, frame), reference.advance({}, frame);
        return {reference.particles(), mine->save().contents.particles};
    }
};
INSTANTIATE_TEST_SUITE_P(Solver, AtAWall, ::testing::ValuesIn(back_ends),
                         [](const auto& at) { return std::string(at.param.name); });

// Clay in the corner of three low or three high walls, squeezed against them at rates of its own
// along each axis: the rates come back. Where nodes behind a wall stand still, what is within half
// a cell of it has half of them.
TEST_P(AtAWall, AUniformRateOfStrainComesBack)
{
    const double dx = 1.0 / 16, dt = 1e-4;
    const Vec3<double> rate{-1, -2, -3};
    const Mat3<double> gradient{{rate.x, 0, 0}, {0, rate.y, 0}, {0, 0, rate.z}};
    for (const ContactMode mode : {ContactMode::slip, ContactMode::separate})
        for (const bool high : {false, true}) {
            Given s = between_walls({6, 6, 6}, dx, mode, 0);
            const Vec3<double> corner = high ? s.walls.max : s.walls.min,
                               way = (high ? -dx : dx) * Vec3<double>{4, 3, 4};
            fill(s, elastic(1e5, 0.3, 1000), high ? corner + way : corner,
                 high ? corner : corner + way, 3);
            s.step.fixed = dt, s.threads = 1;
            for (auto& q : s.particles) q.C = gradient, q.v = gradient * (q.x - corner);
            const Ends ends = both(s, 1, dt);
            double exact = 0, mine = 0;
            for (const auto& q : ends.exact) exact = std::fmax(exact, size(q.C - gradient));
            for (const auto& q : ends.mine) mine = std::fmax(mine, size(q.C - gradient));
            EXPECT_LT(exact, 1e-10);
            EXPECT_LT(mine, 2e-4);
        }
}

// A column that falls on the floor of its shaft, and two that meet in the middle of one: to each
// happens the same, to rounding.
TEST_P(AtAWall, AFloorIsWhatASecondBodyThatComesToMeetItIs)
{
    const double dx = 1.0 / 16;
    const int cells = 5;
    double floor = 0;
    const auto run = [&](bool two) {
        Given s = between_walls({3, two ? 2 * cells : cells, 3}, dx, ContactMode::slip, 0);
        const double reach = (cells - 2) * dx;
        floor = s.walls.min.y + (two ? cells * dx : 0);
        fill(s, elastic(1e5, 0.3, 1000),
             {s.walls.min.x, two ? floor - reach : floor, s.walls.min.z},
             {s.walls.max.x, floor + reach, s.walls.max.z}, 3);
        for (auto& q : s.particles) q.v.y = q.x.y > floor ? -1 : 1;
        s.step.fixed = 1e-4, s.threads = 1;
        Ends ends = both(s, 15, 1e-3);
        for (Particles* all : {&ends.exact, &ends.mine}) {
            std::erase_if(*all, [&](const auto& q) { return q.x.y < floor; });
            for (auto& q : *all) q.x.y -= floor;
        }
        return ends;
    };
    const auto apart = [](const Particles& a, const Particles& b) {
        EXPECT_EQ(a.size(), b.size());
        double most = 0;
        for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
            most = std::fmax(most, std::fabs(a[i].x.y - b[i].x.y));
        return most;
    };
    const Ends one = run(false), two = run(true);
    EXPECT_LT(apart(one.exact, two.exact), 1e-12);
    EXPECT_LT(apart(one.mine, two.mine), 1e-5);
    double squeezed = 0;
    for (const auto& q : one.exact) squeezed = std::fmin(squeezed, q.e.yy);
    EXPECT_LT(squeezed, -0.05);
}

}  // namespace
}  // namespace knead
