// What presses clay that slides along a wall, on an average: the law itself, node by node.
#include "cuda/mpm/sliding.h"

#include <cmath>
#include <set>
#include <vector>

#include "cuda/mpm/grid.h"
#include "tests/solver/samples.h"

namespace knead {
namespace {

constexpr double friction = 0.3, dx = 0.01, mass = 2, dt = 1e-4;
const Lattice<double> lattice{{16, 20, 24}, dx};
const Vec3<double> up{0, 1, 0};

// A node that a floor presses with so much [N] while it goes at `speed` [m/s]; what friction takes
// of that, as a force [N].
struct Pressed {
    Walls<double> walls =
        walls_on<double>(lattice, walls_inside(lattice, 3, ContactMode::separate, friction));
    std::vector<Sliding<double>> kept = std::vector<Sliding<double>>(1);
    int substep = 10;

    double rubbing(double force, double speed, double step = dt)
    {
        const Vec3<double> v{speed, -force * step / mass, 0};
        const SlidingInArray<double> slides{kept.data(), dx, ++substep};
        const Vec3<double> left = apply_friction(v, up, 0.0, walls, mass, step, 0, slides);
        EXPECT_EQ(left.y, v.y < 0 ? 0 : v.y);
        EXPECT_EQ(left.z, 0);
        return (speed - left.x) * mass / step;
    }
};

// Of a swinging force the first substeps have what presses just then, later ones the mean of what
// has pressed so far, and in the long run the mean of the last 50 ms.
TEST(Sliding, IsRubbedByTheMeanOfWhatPressesIt)
{
    Pressed node;
    const auto force = [](int n) { return 10 + 6 * std::sin(0.02 * n); };  // 314 substeps
    EXPECT_NEAR(node.rubbing(force(0), 0.01), friction * force(0), 1e-12);
    double sum = force(0), mean = 0;
    for (int n = 1; n < 20000; ++n) {
        const double by = node.rubbing(force(n), 1e-3);
        sum += force(n);
        if (n < 300) {
            EXPECT_NEAR(by, friction * sum / (n + 1), 1e-9) << n;
        }
        mean += by / 20000;
        // What swings as fast is left by 1 / sqrt(1 + (0.02 * 500)^2).
        if (n > 5000) {
            EXPECT_NEAR(by, friction * 10, friction * 6 * 0.105) << n;
        }
    }
    EXPECT_NEAR(mean, friction * 10, 0.03);
}

// A node that clay passes at once has other clay above it soon: a quarter of a cell on, two thirds
// of what there was are forgotten.
TEST(Sliding, ForgetsWhatHasPassed)
{
    Pressed node;
    const double speed = 0.5;
    for (int n = 0; n < 3000; ++n) node.rubbing(10, speed);
    const int passes = int(0.25 * dx / speed / dt);
    double by = 0;
    for (int n = 0; n < passes; ++n) by = node.rubbing(20, speed);
    EXPECT_NEAR(by, friction * (20 - 10 * std::exp(-1)), 0.15);
}

// Clay that sticks, lifts or was away begins anew: by what presses it just then.
TEST(Sliding, BeginsAnewWhereItDidNotSlide)
{
    const auto long_pressed = [] {
        Pressed node;
        for (int n = 0; n < 1000; ++n) node.rubbing(10, 0.1);
        return node;
    };
    Pressed stuck = long_pressed();
    EXPECT_NEAR(stuck.rubbing(20, 1e-9), 1e-9 * mass / dt, 1e-12);  // all of its speed
    EXPECT_NEAR(stuck.rubbing(20, 0.1), friction * 20, 1e-12);
    Pressed lifted = long_pressed();
    EXPECT_EQ(lifted.rubbing(-1, 0.1), 0);
    EXPECT_NEAR(lifted.rubbing(20, 0.1), friction * 20, 1e-12);
    Pressed away = long_pressed();
    away.substep += 1;
    EXPECT_NEAR(away.rubbing(20, 0.1), friction * 20, 1e-12);
    Pressed stays = long_pressed();
    EXPECT_LT(stays.rubbing(20, 0.1), friction * 10.3);
}

// While its pressure rises the mean is behind; where the clay lifts it pays the rest at once: in
// all it was rubbed for what has pressed it.
TEST(Sliding, PaysWhatItOwesWhereItLifts)
{
    Pressed node;
    double pressed = 0, rubbing = 0;
    for (int n = 1; n <= 40; ++n) pressed += n, rubbing += node.rubbing(n, 0.1);
    EXPECT_LT(rubbing, 0.9 * friction * pressed);
    const double last = node.rubbing(-1, 0.1);
    EXPECT_NEAR(rubbing + last, friction * pressed, 1e-9 * pressed);
    EXPECT_EQ(node.rubbing(-1, 0.1), 0);
    // It gets nothing back where it was rubbed for more.
    Pressed other;
    for (int n = 40; n > 0; --n) other.rubbing(n, 0.1);
    EXPECT_EQ(other.rubbing(-1, 0.1), 0);
}

// A substep of any length, and clay of next to no mass.
TEST(Sliding, IsNumbersForAnySubstepAndMass)
{
    Draw draw(3);
    for (int round = 0; round < 20000; ++round) {
        Walls<float> walls = walls_on<float>(
            lattice, walls_inside(lattice, 3, ContactMode::separate, draw.in(0, 2)));
        const float impulse_deficit = float(draw.power(-30, 10) * (round % 3 ? 1 : -1));
        Sliding<float> kept{float(draw.power(-30, 10)), float(draw.power(-9, -1.31)), 1,
                            impulse_deficit};
        const SlidingInArray<float> slides{&kept, float(draw.power(-4, 0)), 2};
        const Vec3<float> v = cast<float>(draw.vector(1));
        const float m = round % 10 ? float(draw.power(-44, 3)) : 0;
        const Vec3<float> left =
            apply_friction(v, {0, 1, 0}, 0.0f, walls, m, float(draw.power(-9, -1)), 0, slides);
        ASSERT_TRUE(std::isfinite(left.x + left.y + left.z)) << m;
        EXPECT_LE(dot(left, left), dot(v, v) * 1.00001f);
        EXPECT_GE(kept.force, 0);
        EXPECT_FALSE(std::isnan(kept.force));
    }
}

// Nodes at one wall have places of their own; in corners, away from walls and where friction does
// not hang on pressure there are none.
TEST(Sliding, HasAPlaceForEachNodeAtOneWall)
{
    const auto places = [](const WallOptions& options) {
        const Walls<double> walls = walls_on<double>(lattice, options);
        std::set<int> all;
        int count = 0;
        const Int3 size = lattice.size;
        for (int i = 0; i < size.x * size.y * size.z; ++i) {
            const Int3 n{i % size.x, i / size.x % size.y, i / (size.x * size.y)};
            const int place = sliding_place(n, walls_holding(n, walls), walls, size);
            if (place < 0) continue;
            EXPECT_LT(place, sliding_places(size, options));
            all.insert(place), ++count;
        }
        EXPECT_EQ(int(all.size()), count);
        return count;
    };
    // Two layers of each face, those on it and behind it, without their rims: 16 x 20 x 24 nodes of
    // which 8 x 12 x 16 are free.
    WallOptions options = walls_inside(lattice, 3, ContactMode::separate, 0.1);
    EXPECT_EQ(places(options), 2 * 2 * (8 * 12 + 12 * 16 + 16 * 8));
    options.friction = 0;
    EXPECT_EQ(places(options), 0);
    options = walls_inside(lattice, 3, ContactMode::sticky, 0.1);
    EXPECT_EQ(places(options), 0);
    EXPECT_EQ(sliding_places({8, 23170, 23170}, walls_inside(lattice, 3, ContactMode::separate, 1)),
              0);  // more than can be counted
}

}  // namespace
}  // namespace knead
