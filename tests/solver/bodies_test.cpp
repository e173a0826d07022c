// Bodies: objects of unlike category that do not weld. (25a): they touch without a gap, slide with
// Coulomb friction, roll, part without pull, and keep momentum and energy, with every solver.
#include "host/solver/bodies.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

#include "host/hands/hands.h"
#include "host/scene/presets.h"
#include "host/solver/audit.h"
#include "host/solver/pieces.h"
#include "host/verify/cases.h"
#include "host/verify/clay.h"
#include "tests/solver/back_ends.h"
#include "tests/solver/samples.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test
using Particles = std::vector<Particle<double>>;

constexpr double g = 9.81;

struct Solver {
    const char* name;
    bool reference, device, deterministic;
};
constexpr Solver solvers[] = {{"reference", true, false, false},
                              {"cpu", false, false, false},
                              {"cuda", false, true, false},
                              {"cuda_deterministic", false, true, true}};

class BodiesTouch : public ::testing::TestWithParam<Solver> {
  protected:
    void SetUp() override
    {
        if (GetParam().device && !gpu_present()) GTEST_SKIP() << "no CUDA device";
    }
    std::unique_ptr<Simulator> make(Given s) const
    {
        s.deterministic = GetParam().deterministic;
        if (GetParam().reference) return std::make_unique<Reference>(s);
        return GetParam().device ? gpu_solver(s, 0) : cpu_solver(s);
    }
    bool device() const { return GetParam().device; }
    // A measured value, in the test's report.
    void note(const std::string& what, double value) const
    {
        RecordProperty(what, fmt::format("{:.4f}", value));
        fmt::print("    {}: {} {:.4f}\n", GetParam().name, what, value);
    }
};
INSTANTIATE_TEST_SUITE_P(Solver, BodiesTouch, ::testing::ValuesIn(solvers),
                         [](const auto& at) { return std::string(at.param.name); });

// An empty box of `cells` of 1 cm, whose bodies are separate.
constexpr double dx = 0.01, h = dx / 2;
Given box(Int3 cells, double friction, ContactMode mode = ContactMode::separate)
{
    Given s = between_walls(cells, dx, mode, 0.4);
    s.gravity = {0, -g, 0};
    s.contact = {true, friction};
    return s;
}

// An elastic block of a category of its own, its lowest corner in cells from that of the box.
int put(Given& s, Vec3<double> at, Vec3<double> size, double density = 1000)
{
    Material<double> m = elastic(3e5 * density / 1000, 0.3, density);  // equal speed of sound
    m.category = int(s.materials.size());
    const Vec3<double> from = s.walls.min + dx * at;
    return fill(s, m, from, from + dx * size, 2);
}

struct Body {
    Vec3<double> middle{}, velocity{}, low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
};
Body body(const Particles& all, int object)
{
    Body b;
    double count = 0;
    for (const auto& q : all) {
        if (q.object != object) continue;
        b.middle = b.middle + q.x, b.velocity = b.velocity + q.v, ++count;
        b.low = lesser(b.low, q.x), b.high = greater(b.high, q.x);
    }
    b.middle = (1 / count) * b.middle, b.velocity = (1 / count) * b.velocity;
    return b;
}

// The mean height of an object's particles within h/2 of its lowest, or of its highest [m].
double face(const Particles& all, int object, bool lowest)
{
    const Body b = body(all, object);
    double sum = 0, count = 0;
    for (const auto& q : all) {
        if (q.object != object) continue;
        if (lowest ? q.x.y < b.low.y + h / 2 : q.x.y > b.high.y - h / 2) sum += q.x.y, ++count;
    }
    return sum / count;
}
double gap(const Particles& all, int lower, int upper)
{
    return (face(all, upper, true) - face(all, lower, false)) / h;
}

double energy(const Given& s, const Particles& all)
{
    double sum = 0;
    for (const auto& q : all) {
        const Material<double>& m = s.materials[std::size_t(q.object)];
        sum += 0.5 * m.mass * dot(q.v, q.v) + affine_energy(q.C, m.mass, dx) +
               m.volume * stored_energy(q, m) - m.mass * dot(s.gravity, q.x);
    }
    return sum;
}
Vec3<double> momentum_of(const Given& s, const Particles& all)
{
    Vec3<double> sum{};
    for (const auto& q : all) sum = sum + s.materials[std::size_t(q.object)].mass * q.v;
    return sum;
}

// Two bodies rest as close as the particles of one: a block that is dropped on another.
TEST_P(BodiesTouch, WithoutAGapAfterADrop)
{
    for (const double ratio : {1.0, 0.1, 10.0}) {
        Given s = box({11, 14, 11}, 0.4);
        put(s, {2, 0, 2}, {7, 3, 7}, ratio > 1 ? 1000 / ratio : 1000);
        put(s, {3.3, 3 + 1.2, 3.2}, {4, 3, 4}, ratio < 1 ? 1000 * ratio : 1000);
        const auto solver = make(s);
        const double start = energy(s, s.particles);
        double rest = 0;
        for (int f = 0; f < 20; ++f) {
            solver->advance({}, 0.02);
            EXPECT_LE(energy(s, solver->particles()), start * (1 + 1e-6)) << f;
            if (f >= 15) rest += gap(solver->particles(), 0, 1) / 5;
        }
        note(fmt::format("gap, densities 1 to {}", ratio), rest);
        EXPECT_GE(rest, ratio == 1 ? 0.98 : 0.93);
        EXPECT_LE(rest, 1.14);
    }
}

// A block that is at rest on a slab and is pushed loses f g.
TEST_P(BodiesTouch, WithCoulombFriction)
{
    for (const double ratio : {1.0, 0.1, 10.0}) {
        Given s = box({26, 9, 12}, 0);
        s.walls.mode = ContactMode::sticky;
        put(s, {1, 0, 1}, {24, 3, 10}, ratio > 1 ? 1000 / ratio : 1000);
        put(s, {3, 3, 2}, {8, 4, 8}, ratio < 1 ? 1000 * ratio : 1000);
        {
            const auto settles = make(s);
            for (int k = 0; k < 8; ++k) settles->advance({}, 0.02);
            s.particles = settles->particles();
        }
        for (auto& q : s.particles) q.C = {}, q.v = {q.object == 1 ? 1.2 : 0, 0, 0};
        for (const double f : {0.2, 0.4, 0.8}) {
            if (ratio != 1 && f != 0.4) continue;
            s.contact.friction = f;
            const auto solver = make(s);
            const auto speed = [&] { return body(solver->particles(), 1).velocity.x; };
            solver->advance({}, 0.01);
            const double before = speed(), time = 0.1;
            for (int k = 0; k < 6; ++k) solver->advance({}, time / 6);
            const double lost = (before - speed()) / time / (f * g);
            note(fmt::format("loss over f g, f {}, densities 1 to {}", f, ratio), lost);
            EXPECT_GE(lost, 0.97);
            EXPECT_LE(lost, ratio == 1 ? 1.08 : 1.10);
        }
    }
}

// What bodies lose and gain is equal; angular momentum as the transfers have it.
TEST_P(BodiesTouch, WithTheMomentumTheyHad)
{
    Given s = box({20, 14, 14}, 0.4);
    s.gravity = {};
    put(s, {4, 4, 4}, {4, 6, 6}, 1000);
    put(s, {8.6, 4.5, 5}, {4, 6, 4}, 3000);
    for (auto& q : s.particles) q.v = q.object == 0 ? Vec3<double>{1, 0.1, 0} : Vec3<double>{};
    const Vec3<double> start = momentum_of(s, s.particles);
    const double energy_at_start = energy(s, s.particles);
    const auto solver = make(s);
    for (int f = 0; f < 10; ++f) {
        solver->advance({}, 0.002);
        EXPECT_LE(energy(s, solver->particles()), energy_at_start * (1 + 1e-6));
    }
    const Particles all = solver->particles();
    const double change = length(momentum_of(s, all) - start) / length(start);
    note("momentum 1e6", 1e6 * change);
    EXPECT_LT(change, GetParam().reference ? 1e-12 : 2e-6);
    EXPECT_LT(body(all, 0).velocity.x, 0.7);
    EXPECT_GT(body(all, 1).velocity.x, 0.1);
}

// A block that leaves another keeps what momentum it has, and the other feels nothing.
TEST_P(BodiesTouch, AndPartWithoutPull)
{
    Given s = box({14, 20, 14}, 0.4);
    s.gravity = {};
    put(s, {3, 4, 3}, {8, 4, 8});
    put(s, {4, 8, 4}, {6, 4, 6});
    for (auto& q : s.particles) q.v.y = q.object == 1 ? 0.5 : 0;
    const auto solver = make(s);
    for (int f = 0; f < 10; ++f) solver->advance({}, 0.01);
    const Particles all = solver->particles();
    note("kept", body(all, 1).velocity.y / 0.5);
    note("pulled", body(all, 0).velocity.y / 0.5);
    EXPECT_NEAR(body(all, 1).velocity.y, 0.5, 0.005);
    EXPECT_NEAR(body(all, 0).velocity.y, 0, 0.005);
}

// The lower body of a pair at rest, lifted as a hand lifts a bun off a patty: what is left behind
// is pulled by no more than a hundredth of the weight of what leaves.
TEST_P(BodiesTouch, AndALiftedBunPullsWithLessThanAHundredthOfItsWeight)
{
    Given s = box({16, 24, 16}, 0.4);
    put(s, {4, 0, 4}, {8, 3, 8});
    put(s, {4, 3, 4}, {8, 4, 8});
    const double frame = 0.01;
    auto solver = make(s);
    for (int f = 0; f < 15; ++f) solver->advance({}, frame);
    Given lifted = s;
    lifted.particles = solver->particles();
    double mass = 0, lower = 0;
    for (auto& q : lifted.particles) {
        if (q.object == 1) q.v = {0, 1.2, 0}, mass += s.materials[1].mass;
        if (q.object == 0) q.v = {}, q.C = {}, lower += s.materials[0].mass;
    }
    lifted.gravity = {};  // the upper one flies on at constant speed; the lower one springs back
    solver = make(lifted);
    Given alone = lifted;  // without it
    std::erase_if(alone.particles, [](const auto& q) { return q.object == 1; });
    const auto other = make(alone);
    for (int f = 0; f < 5; ++f) solver->advance({}, frame), other->advance({}, frame);
    const double pulled =
        lower * (body(solver->particles(), 0).velocity.y - body(other->particles(), 0).velocity.y);
    note("pull over weight", pulled / (mass * g * 5 * frame));
    EXPECT_LT(pulled, 0.01 * mass * g * 5 * frame);
}

// A ball set off on a block slides, then rolls, as on a floor.
TEST_P(BodiesTouch, AndABallRollsOnABlock)
{
    const double radius = 4 * dx, v0 = 1, f = 0.4;
    Given s = box({38, 16, 12}, f);
    s.walls.mode = ContactMode::sticky;
    put(s, {1, 0, 1}, {36, 3, 10});
    Material<double> m = elastic(3e5, 0.3, 1000);
    m.category = 1;
    const Vec3<double> centre = s.walls.min + Vec3<double>{6 * dx, 3 * dx + radius, 6 * dx},
                       edge = {radius, radius, radius};
    fill(s, m, centre - edge, centre + edge, 2,
         [&](Vec3<double> x) { return length(x - centre) < radius; });
    for (auto& q : s.particles) q.v.x = q.object == 1 ? v0 : 0;
    const auto solver = make(s);
    const double from = body(s.particles, 1).middle.x, time = 0.4;
    for (int k = 0; k < 20; ++k) solver->advance({}, time / 20);
    const Body ball = body(solver->particles(), 1);
    const double slides = 2 * v0 / (7 * f * g),
                 exact = v0 * slides - f * g * slides * slides / 2 + 5.0 / 7 * v0 * (time - slides);
    note("way of closed form", (ball.middle.x - from) / exact);
    note("speed", ball.velocity.x);
    EXPECT_GE((ball.middle.x - from) / exact, 0.9);
    EXPECT_LE((ball.middle.x - from) / exact, 1.02);
}

// Three blocks of three categories, one on the other, stand.
TEST_P(BodiesTouch, AndAStackStands)
{
    Given s = box({10, 14, 10}, 0.4);
    for (int k = 0; k < 3; ++k) put(s, {3, 3.0 * k, 3}, {4, 3, 4});
    const auto solver = make(s);
    const double start = energy(s, s.particles);
    const auto run = [&](double time) {
        for (int f = 0; f < int(time / 0.05 + 0.5); ++f) {
            solver->advance({}, 0.05);
            EXPECT_LE(energy(s, solver->particles()), start * (1 + 1e-6));
        }
    };
    run(0.5);
    const Particles settled = solver->particles();
    run(std::getenv("KNEAD_LONG") ? 9.5 : 0.5);
    const Particles all = solver->particles();
    for (int k = 0; k < 3; ++k)
        EXPECT_LT(length(body(all, k).middle - body(settled, k).middle), 0.02 * dx) << k;
    note("moved [dx]", length(body(all, 2).middle - body(settled, 2).middle) / dx);
    for (int k = 0; k < 2; ++k) {
        note("gap", gap(all, k, k + 1));
        EXPECT_NEAR(gap(all, k, k + 1), 1.02, 0.12);
    }
}

// Three bodies that meet at one edge, two sweeps: none enters another, momentum stays.
TEST_P(BodiesTouch, AndThreeMeetAtAnEdge)
{
    Given s = box({20, 20, 12}, 0.4);
    s.gravity = {};
    put(s, {4, 4, 2}, {6, 6, 8});
    put(s, {10, 4, 2}, {6, 6, 8});
    put(s, {7, 10.3, 2}, {6, 6, 8});
    for (auto& q : s.particles) q.v.y = q.object == 2 ? -0.5 : 0;
    const Vec3<double> start = momentum_of(s, s.particles);
    const double before = energy(s, s.particles);
    const auto solver = make(s);
    for (int f = 0; f < 10; ++f) {
        solver->advance({}, 0.003);
        EXPECT_LE(energy(s, solver->particles()), before * (1 + 1e-6));
    }
    const Particles all = solver->particles();
    EXPECT_LT(length(momentum_of(s, all) - start) / length(start),
              GetParam().reference ? 1e-12 : 2e-6);
    for (int k = 0; k < 2; ++k) EXPECT_GT(body(all, 2).low.y - face(all, k, false), 0.5 * h) << k;
    note("closest [h]", (body(all, 2).low.y - face(all, 0, false)) / h);
}

// Seven layers of seven categories on each other, with four fields: none is welded to another, and
// they stand; those that are lifted pull none of the others.
TEST_P(BodiesTouch, AndSevenLayersStand)
{
    Given s = box({14, 26, 10}, 0.4);
    for (int k = 0; k < 7; ++k) put(s, {3, 3.0 * k, 2}, {8, 3, 6});
    const auto solver = make(s);
    const double start = energy(s, s.particles);
    for (int f = 0; f < 6; ++f) {
        EXPECT_EQ(solver->advance({}, 0.05).welded_bodies, 0) << f;
        EXPECT_LE(energy(s, solver->particles()), start * (1 + 1e-6));
    }
    const Particles all = solver->particles();
    for (int k = 0; k < 6; ++k) {
        note("gap", gap(all, k, k + 1));
        EXPECT_NEAR(gap(all, k, k + 1), 1.0, 0.16) << k;
    }
    // Some of them are lifted off, and pull none of the others.
    Given lifted = s;
    lifted.gravity = {};
    for (auto& q : lifted.particles) q.v.y = q.object >= 3 ? 0.5 : 0;
    const auto rises = make(lifted);
    for (int f = 0; f < 4; ++f) EXPECT_EQ(rises->advance({}, 0.01).welded_bodies, 0);
    const Particles after = rises->particles();
    for (int k = 0; k < 7; ++k) {
        note("speed", body(after, k).velocity.y);
        EXPECT_NEAR(body(after, k).velocity.y, k >= 3 ? 0.5 : 0, 0.005) << k;
    }
}

// Six bodies that meet at one place, with four fields: those that share one are counted, and
// momentum stays.
TEST_P(BodiesTouch, AndMoreThanFourAtAPlaceAreCounted)
{
    Given s = box({16, 16, 16}, 0.4);
    s.gravity = {};
    for (int k = 0; k < 6; ++k)
        put(s, {4 + 3.0 * (k % 2), 4 + 3.0 * (k / 2 % 2), 4 + 3.0 * (k / 4)}, {3, 3, 3});
    for (auto& q : s.particles) q.v = {0.1 * (q.object % 3), -0.1 * (q.object % 2), 0.05};
    const auto solver = make(s);
    const Vec3<double> start = momentum_of(s, s.particles);
    EXPECT_GT(solver->advance({}, 0.005).welded_bodies, 0);
    const Vec3<double> change = momentum_of(s, solver->particles()) - start;
    EXPECT_LT(length(change), (GetParam().reference ? 1e-12 : 2e-6) * length(start));
}

// A liquid rests on a block and in a plastic body's hollow: it does not weld, nor enter.
TEST_P(BodiesTouch, LiquidsAndPlasticBodiesToo)
{
    Given s = box({14, 16, 14}, 0.4);
    Material<double> clay = preset("soft-clay"), liquid = preset("viscous-liquid");
    clay.category = 0, liquid.category = 1;
    const Vec3<double> from = s.walls.min + dx * Vec3<double>{0, 0, 0};
    fill(s, clay, from, from + dx * Vec3<double>{14, 4, 14}, 2);
    fill(s, liquid, from + dx * Vec3<double>{4, 4.5, 4}, from + dx * Vec3<double>{10, 8.5, 10}, 2);
    const auto solver = make(s);
    for (int f = 0; f < 10; ++f) solver->advance({}, 0.02);
    const Particles all = solver->particles();
    const double closest = body(all, 1).low.y - face(all, 0, false);
    note("closest [h]", closest / h);
    EXPECT_GT(closest, 0.3 * h);
    EXPECT_LT(closest, 1.3 * h);
}

// A knife 2 mm thick, its edge along z at the joint's height, its sheet in the plane x of the
// joint.
void add_knife(Given& s)
{
    const Vec3<float> corner[3] = {{0, 0, -0.2f}, {0, 0, 0.2f}, {0, 0.3f, 0}};
    for (const Vec3<float>& c : corner) {
        Binding<float> b{};
        b.weight[0] = 1, b.offset[0] = c, b.radius = 5e-4f;
        s.rig.spheres.push_back(b);
    }
    s.rig.primitives = {{3, {0, 1, 2}, 0}};
    s.tools = {{ContactMode::separate, 0.1, true, true}};
}

// Draws the knife down to a height, up again, and waits `rest` frames.
template <class Each>
void stroke(Simulator& solver, Vec3<double> above, double to, int rest, Each&& each)
{
    const double frame = 1.0 / 60;
    Motion motion;
    motion.from.assign(2 * joint_count, {{1, 0, 0, 0}, above});
    motion.to = motion.from;
    const auto move = [&](double height) {
        motion.from[0] = motion.to[0];
        motion.to[0].p.y = height;
        solver.advance(motion, frame);
        each();
    };
    for (int f = 1; f <= 15; ++f) move(above.y + (to - above.y) * f / 15);
    for (int f = 1; f <= 8; ++f) move(to + (above.y - to) * f / 8);
    for (int f = 0; f < rest; ++f) move(above.y);
}

std::vector<int> pieces_of(const Particles& all, int object, const Lattice<double>& lattice)
{
    Particles clay;
    for (const auto& q : all)
        if (q.object == object) clay.push_back(q);
    std::vector<int> piece;
    std::vector<int> size(std::size_t(pieces(clay, lattice, piece)), 0);
    for (const int p : piece) ++size[std::size_t(p)];
    return size;
}

// The gap between the bodies 0 and 1 at 2.5 to 5 cells on both sides of a cut in the plane x
// [h], from the mean of the highest and lowest particles of columns of a cell.
double gap_beside(const Particles& all, double x)
{
    struct Column {
        double high = -1e9, low = 1e9;
    };
    std::map<std::pair<int, int>, Column> columns;
    for (const auto& q : all) {
        const double away = std::fabs(q.x.x - x) / dx;
        if (away < 2.5 || away > 5) continue;
        Column& c = columns[{int(std::floor(q.x.x / dx)), int(std::floor(q.x.z / dx))}];
        if (q.object == 0) c.high = std::fmax(c.high, q.x.y);
        if (q.object == 1) c.low = std::fmin(c.low, q.x.y);
    }
    double sum = 0, count = 0;
    for (const auto& [at, c] : columns)
        if (c.high > -1e9 && c.low < 1e9) sum += c.low - c.high, ++count;
    return sum / count / h;
}

Material<double> plastic(int category)
{
    Material<double> m = elastic(2e5, 0.3, 1000);
    m.plasticity = Plasticity::von_mises, m.yield = 8e3, m.category = category;
    return m;
}

// A knife that parts the upper of two bodies: the lower one stays whole, and bears both halves
// without a gap; the halves are no longer held together.
TEST_P(BodiesTouch, AndAKnifePartsTheUpperOfTwo)
{
    Given s = box({20, 20, 14}, 0.4);
    const Vec3<double> at = s.walls.min;
    fill(s, plastic(0), at + dx * Vec3<double>{2, 0, 2}, at + dx * Vec3<double>{18, 3, 12}, 2);
    fill(s, plastic(1), at + dx * Vec3<double>{4, 3, 3}, at + dx * Vec3<double>{16, 7, 11}, 2);
    add_knife(s);
    const auto solver = make(s);
    const double table = at.y + 3 * dx, middle = at.x + 10 * dx;
    double most = 0;
    const Vec3<double> start{middle, at.y + 9 * dx, at.z + 7 * dx};
    stroke(*solver, start, table, 12, [&] {
        for (const auto& q : solver->particles())
            if (length(q.v) > most) most = length(q.v);
    });
    note("fastest [m/s]", most);
    EXPECT_LT(most, 1.5);
    const Particles all = solver->particles();
    EXPECT_EQ(pieces_of(all, 0, s.lattice).size(), 1u);
    const std::vector<int> size = pieces_of(all, 1, s.lattice);
    ASSERT_GE(size.size(), 2u);
    EXPECT_GT(size[1], (size[0] + size[1]) * 2 / 5);
    const double rest = gap_beside(all, middle);
    note("gap", rest);
    EXPECT_GE(rest, 0.8);
    EXPECT_LE(rest, 1.14);
    // Drawn apart, each half goes its way.
    Given after = s;
    after.gravity = {}, after.rig = {}, after.tools = {{ContactMode::separate, 0, true, true}};
    after.particles = all;
    for (auto& q : after.particles)
        q.C = {}, q.v = {q.object == 0 ? 0 : q.x.x < middle ? -0.4 : 0.4, 0, 0};
    after.contact.friction = 0;
    const auto apart = make(after);
    Motion still;
    still.from.assign(2 * joint_count, {{1, 0, 0, 0}, {0, 0, 0}}), still.to = still.from;
    apart->advance(still, 0.02);
    double speed = 0, count = 0;
    for (const auto& q : apart->particles())
        if (q.object == 1) speed += std::fabs(q.v.x), ++count;
    note("kept", speed / count / 0.4);
    EXPECT_GT(speed / count, 0.97 * 0.4);
}

// A knife through two bodies at once parts both; momentum stays as it is with the knife away.
TEST_P(BodiesTouch, AndAKnifePartsTwoAtOnce)
{
    Given s = box({20, 16, 12}, 0.4);
    const Vec3<double> at = s.walls.min;
    fill(s, plastic(0), at + dx * Vec3<double>{4, 0, 2}, at + dx * Vec3<double>{16, 3, 10}, 2);
    fill(s, plastic(1), at + dx * Vec3<double>{4, 3, 2}, at + dx * Vec3<double>{16, 6, 10}, 2);
    add_knife(s);
    const auto solver = make(s);
    stroke(*solver, {at.x + 10 * dx, at.y + 9 * dx, at.z + 6 * dx}, at.y - dx, 6, [] {});
    const Particles all = solver->particles();
    for (int object = 0; object < 2; ++object) {
        const std::vector<int> size = pieces_of(all, object, s.lattice);
        ASSERT_EQ(size.size(), 2u) << object;
        EXPECT_GT(size[1], size[0] * 2 / 3);
    }
    const double rest = gap_beside(all, at.x + 10 * dx);
    note("gap", rest);
    EXPECT_GE(rest, 0.8);
    EXPECT_LE(rest, 1.14);
    Given after = s;  // the four parts meet in flight
    after.gravity = {}, after.rig = {}, after.tools = {{ContactMode::separate, 0, true, true}};
    after.particles = all;
    for (auto& q : after.particles) {
        q.C = {}, q.x.y += 5 * dx;
        q.v = {q.x.x < at.x + 10 * dx ? 0.3 : -0.1, q.object == 1 ? -0.3 : 0, 0};
    }
    const Vec3<double> before = momentum_of(after, after.particles);
    const auto meet = make(after);
    Motion still;
    still.from.assign(2 * joint_count, {{1, 0, 0, 0}, {0, 0, 0}}), still.to = still.from;
    meet->advance(still, 0.005);
    const Particles met = meet->particles();
    const double change = length(momentum_of(after, met) - before) / length(before);
    note("momentum 1e6", 1e6 * change);
    EXPECT_LT(change, GetParam().reference ? 1e-12 : 1e-5);
}

// One category: the bits of welded clay. Bodies far from each other: theirs, too.
TEST_P(BodiesTouch, NothingChangesWhereNoneTouch)
{
    if (device()) GTEST_SKIP() << "atomic sums differ from run to run";
    for (const bool apart : {false, true}) {
        Given s = box({24, 12, 12}, 0.4);
        put(s, {2, 0, 3}, {5, 5, 5});
        put(s, {apart ? 17.0 : 8.0, 0, 3}, {5, 5, 5});
        if (!apart) s.materials[1].category = 0;
        if (apart && GetParam().reference) continue;  // it has a field a body everywhere
        Given welded = s;
        welded.contact.separate = false;
        const auto one = make(s), other = make(welded);
        for (int f = 0; f < 3; ++f) one->advance({}, 0.02), other->advance({}, 0.02);
        const Particles a = one->particles(), b = other->particles();
        for (std::size_t i = 0; i < a.size(); ++i) ASSERT_EQ(length(a[i].x - b[i].x), 0) << i;
    }
}

template <class R>
class BodyContactOf : public ::testing::Test {
};
TYPED_TEST_SUITE(BodyContactOf, Scalars);

TYPED_TEST(BodyContactOf, TheDepthBelowASurfaceFollowsFromTheRatioOfTwoNodes)
{
    using R = TypeParam;
    for (const double apart : {0.578, 0.8, 1.0})
        for (double t = -1.45; t < 1.3; t += 0.05) {
            const R ratio = share_below(R(t)) / share_below(R(t + apart));
            EXPECT_NEAR(depth_of_ratio(ratio, R(apart)), t, 1e-3) << apart;
        }
    EXPECT_EQ(depth_of_ratio(R(0), R(1)), R(-1.5));
    EXPECT_EQ(depth_of_ratio(R(1), R(1)), R(1.5));
    EXPECT_NEAR(share_below(R(0)), 0.5, 1e-7);
    for (double t = -1.5; t <= 1.5; t += 0.1)  // a spline and its integral
        EXPECT_NEAR((share_below(R(t + 0.01)) - share_below(R(t - 0.01))) / R(0.02), spline(R(t)),
                    1e-3);
}

// Two half spaces with a gap between them, along an axis and along diagonals.
TYPED_TEST(BodyContactOf, AGapBetweenHalfSpacesIsFoundWhereverNodesLie)
{
    using R = TypeParam;
    for (const Vec3<double>& axis : {Vec3<double>{1, 0, 0}, Vec3<double>{1, 1, 0}}) {
        const Vec3<double> n = (1 / length(axis)) * axis;
        for (const double width : {0.0, 0.2, 0.5, 0.8})
            for (double at = -0.4; at <= 0.4; at += 0.2) {
                // The node lies `at` from the middle of the gap [cells].
                const Gap<R> gap = gap_between<R>([&](int f, Int3 step) {
                    const double x = at + n.x * step.x + n.y * step.y + n.z * step.z;
                    return share_below(R(f ? x - width / 2 : -x - width / 2));
                });
                ASSERT_TRUE(gap.found);
                EXPECT_NEAR(gap.n.x, n.x, 1e-5);
                EXPECT_NEAR(gap.n.y, n.y, 1e-5);
                if (axis.y == 0) {
                    EXPECT_NEAR(gap.width, std::fmax(0, width - touching), 2e-3) << at;
                }
            }
    }
}

class Bodies : public AgainstTheReference {};
INSTANTIATE_TEST_SUITE_P(Solver, Bodies, ::testing::ValuesIn(back_ends),
                         [](const auto& at) { return std::string(at.param.name); });

TEST_P(Bodies, AreAsTheReferenceHasThem)
{
    Given s = box({20, 16, 14}, 0.4);
    put(s, {3, 0, 3}, {12, 4, 8});
    put(s, {5, 4.2, 4}, {5, 4, 5}, 2000);
    put(s, {10.2, 4.1, 4}, {4, 5, 5}, 500);
    for (auto& q : s.particles) q.v.x = q.object == 1 ? 0.5 : 0;
    s = rounded_to_float(s);
    s.contact.friction = double(float(s.contact.friction));
    const auto mine = GetParam().make(s);
    Reference reference(s);
    for (int f = 0; f < 4; ++f) mine->advance({}, 0.01), reference.advance({}, 0.01);
    const Particles one = mine->particles(), other = reference.particles();
    double worst = 0;
    for (std::size_t i = 0; i < one.size(); ++i)
        worst = std::fmax(worst, length(one[i].x - other[i].x));
    fmt::print("    {}: apart by {:.3g} m\n", GetParam().name, worst);
    EXPECT_LT(worst, 2e-6);
}

TEST_P(Bodies, AreOf64CategoriesAtMost)
{
    Given s = box({30, 12, 12}, 0.4);
    for (int k = 0; k < 64; ++k) put(s, {1 + 3.0 * (k % 8), 1, 1 + 1.2 * (k / 8.0)}, {1, 1, 1});
    const auto solver = GetParam().make(s);
    Material<double> m = s.materials[0];
    m.category = 64;
    Particles clay(s.particles.begin(), s.particles.begin() + 8);
    EXPECT_THROW(solver->add(m, clay), std::invalid_argument);
    EXPECT_EQ(solver->particle_count(), s.particles.size());
    m.category = 63;
    solver->add(m, clay);
    solver->advance({}, 0.005);
    put(s, {25, 1, 1}, {2, 2, 2});
    EXPECT_THROW(GetParam().make(s), std::invalid_argument);
    s.contact.separate = false;
    GetParam().make(s);
}

// The same with a knife in the upper body, and clay that is cut already.
TEST_P(Bodies, AreAsTheReferenceHasThemWithAKnifeToo)
{
    Given s = box({20, 16, 12}, 0.4);
    const Vec3<double> at = s.walls.min;
    put(s, {3, 0, 2}, {14, 3, 8});
    put(s, {4, 3.1, 3}, {12, 4, 6}, 2000);
    add_knife(s);
    for (auto& q : s.particles)
        if (q.object == 1 && q.x.x > at.x + 7 * dx && q.x.x < at.x + 13 * dx)
            q.sides = q.x.x < at.x + 10 * dx ? below : above;
    s = rounded_to_float(s);
    s.contact.friction = double(float(s.contact.friction));
    const auto mine = GetParam().make(s);
    Reference reference(s);
    Motion motion;
    motion.from.assign(2 * joint_count, {{1, 0, 0, 0}, at + dx * Vec3<double>{10, 5, 6}});
    motion.to = motion.from;
    for (int f = 0; f < 4; ++f) {
        motion.from[0] = motion.to[0];
        motion.to[0].p.y -= 0.2 * dx;
        mine->advance(motion, 0.004), reference.advance(motion, 0.004);
    }
    const Particles one = mine->particles(), other = reference.particles();
    double worst = 0;
    long labels = 0;
    for (std::size_t i = 0; i < one.size(); ++i) {
        worst = std::fmax(worst, length(one[i].x - other[i].x));
        labels += one[i].label() != other[i].label();
    }
    fmt::print("    {}: apart by {:.3g} m, {} labels differ\n", GetParam().name, worst, labels);
    EXPECT_LT(worst, 2e-5);
    EXPECT_LE(labels, long(one.size()) / 1000);
}

// Bodies that share colours: a run that goes on from a snapshot, or from a saved state in another
// simulator, has the same bits, though colours have changed since.
TEST_P(Bodies, ShareColoursByWhereTheyAreNow)
{
    if (GetParam().device && !GetParam().deterministic) GTEST_SKIP() << "sums in any order";
    Given s = box({34, 12, 12}, 0.4);
    s.deterministic = true;
    for (int k = 0; k < 6; ++k) put(s, {1 + 5.2 * k, 1, 2}, {4, 4, 6});
    for (auto& q : s.particles) q.v.x = q.object == 5 ? -4 : q.object == 0 ? 4 : 0;
    const auto solver = GetParam().make(s), other = GetParam().make(s);
    for (int f = 0; f < 4; ++f) solver->advance({}, 0.01);
    const auto then = solver->snapshot();
    const SavedState saved = solver->save();
    for (int f = 0; f < 4; ++f) EXPECT_EQ(solver->advance({}, 0.01).welded_bodies, 0);
    const Particles once = solver->particles();
    solver->restore(*then);
    for (int f = 0; f < 4; ++f) solver->advance({}, 0.01);
    other->load(saved);
    for (int f = 0; f < 4; ++f) other->advance({}, 0.01);
    const Particles again = solver->particles(), elsewhere = other->particles();
    for (std::size_t i = 0; i < once.size(); ++i) {
        ASSERT_EQ(length(once[i].x - again[i].x), 0) << i;
        ASSERT_EQ(length(once[i].x - elsewhere[i].x), 0) << i;
    }
}

TEST(BodyColours, DifferForBodiesThatTouchAsFarAsTheySuffice)
{
    const auto edge = [](BodyGraph& of, int a, int b, bool touch) {
        for (auto [x, y] : {std::pair(a, b), std::pair(b, a)}) {
            if (touch) of.touching[std::size_t(x)] |= std::uint64_t(1) << y;
            of.near[std::size_t(x)] |= std::uint64_t(1) << y;
        }
    };
    BodyGraph stack;
    for (int k = 0; k + 1 < 64; ++k) edge(stack, (7 * k) % 64, (7 * (k + 1)) % 64, true);
    for (int k = 0; k + 2 < 64; ++k) edge(stack, (7 * k) % 64, (7 * (k + 2)) % 64, false);
    const Colouring of_stack = coloured(stack, 64, 4);
    EXPECT_EQ(of_stack.welded, 0);
    for (int a = 0; a < 64; ++a)
        for (int b = 0; b < 64; ++b)
            if (stack.near[std::size_t(a)] >> b & 1) {
                EXPECT_NE(of_stack.colour[std::size_t(a)], of_stack.colour[std::size_t(b)]);
            }
    BodyGraph all;
    for (int a = 0; a < 6; ++a)
        for (int b = 0; b < a; ++b) edge(all, a, b, true);
    const Colouring of_all = coloured(all, 6, 4);
    EXPECT_EQ(of_all.welded, 2);
    for (const int c : of_all.colour) EXPECT_TRUE(c >= 1 && c <= 4);
    EXPECT_EQ(coloured({}, 5, 4).welded, 0);
}

// A category that changes, an object that is added or removed: the fields follow.
TEST_P(Bodies, FollowEdits)
{
    Given s = box({14, 20, 14}, 0.4);
    s.gravity = {};
    put(s, {3, 4, 3}, {8, 4, 8});
    put(s, {4, 8, 4}, {6, 4, 6});
    s.materials[1].category = 0;
    for (auto& q : s.particles) q.v.y = q.object == 1 ? 0.5 : 0;
    for (const bool parts : {false, true}) {
        const auto solver = GetParam().make(s);
        Material<double> m = s.materials[1];
        m.category = parts;
        solver->set_material(1, m);
        for (int f = 0; f < 5; ++f) solver->advance({}, 0.01);
        const double upper = body(solver->particles(), 1).velocity.y;
        if (parts)
            EXPECT_NEAR(upper, 0.5, 0.005);
        else
            EXPECT_LT(upper, 0.4);
        solver->remove(0);
        solver->advance({}, 0.01);
        EXPECT_NEAR(body(solver->particles(), 1).velocity.y, upper, parts ? 0.005 : 0.2);
    }
}

}  // namespace
}  // namespace knead
