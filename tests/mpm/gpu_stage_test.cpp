// Each stage of the device against a plain loop over the same formulas, on the same numbers. In a
// build without contraction (KNEAD_VERIFY) what is not a sum in varying order agrees to the bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <random>

#include "cuda/mpm/g2p.h"
#include "cuda/mpm/grid.h"
#include "cuda/mpm/p2g.h"
#include "cuda/mpm/plasticity.h"
#include "cuda/mpm/project.h"
#include "host/bench/ball.h"
#include "host/hands/hands.h"
#include "host/solver/gpu/stages.h"
#include "host/solver/substep.h"
#include "tests/mpm/updated_nodes.h"

namespace knead {
namespace {

#ifdef KNEAD_VERIFY
constexpr bool to_the_bit = true;
#else
constexpr bool to_the_bit = false;
#endif
constexpr double dt = 1e-4;

struct Random {
    std::mt19937 source{7};
    double operator()(double size) { return std::uniform_real_distribution<>(-size, size)(source); }
    Vec3<double> vector(double size) { return {(*this)(size), (*this)(size), (*this)(size)}; }
};

// The ball in turmoil: particles out of order, moving, spinning and strained beyond yield.
Setup turmoil(int nodes, Plasticity plasticity)
{
    knead::Setup s = ball(nodes);
    Random random;
    s.materials[0].plasticity = plasticity;
    s.materials[0].friction = 0.6, s.materials[0].compress = 0.025, s.materials[0].stretch = 0.0075;
    s.materials[0].snow = 10, s.materials[0].viscosity = 100;
    std::shuffle(s.particles.begin(), s.particles.end(), random.source);
    for (Particle<double>& q : s.particles) {
        q.x = q.x + random.vector(0.3 * s.lattice.dx);
        q.v = random.vector(2);
        q.C = {random.vector(50), random.vector(50), random.vector(50)};
        q.e = {random(0.1), random(0.1), random(0.1), random(0.1), random(0.1), random(0.1)};
    }
    return s;
}

// Hangs a knot of many primitives on each wrist, most in each other's way, some there twice.
void add_knots(Setup& s)
{
    Random random;
    constexpr int spheres = 12, primitives = 40;
    for (int side = 0; side < side_count; ++side) {
        const int first = int(s.rig.spheres.size());
        for (int k = 0; k < spheres; ++k) {
            Binding<float> b{};
            for (int& j : b.joint) j = side * joint_count + wrist;
            b.weight[0] = 1;
            b.offset[0] = cast<float>(random.vector(0.09));
            b.radius = float(0.02 + 0.002 * k);
            s.rig.spheres.push_back(b);
        }
        for (int k = 0; k < primitives; ++k) {
            const int a = first + k % spheres, b = first + (k + 1 + k / spheres) % spheres,
                      c = first + (k + 5) % spheres;
            s.rig.primitives.push_back({1 + k % 3, {a, k % 3 ? b : a, k % 3 < 2 ? b : c}, side});
            if (k % 4 == 0) s.rig.primitives.push_back(s.rig.primitives.back());
        }
        s.tools.push_back({side ? ContactMode::separate : ContactMode::sticky, 0.4, false, true});
    }
}

// Of so many points the two deepest primitives may be equally deep to rounding.
constexpr int equally_deep = 3;

const Motion squeeze{wrists(0.25, 0.1), wrists(0.2499, 0.1004), {1, 1}};

// The tools of a setup at the end of the substep.
struct Posed {
    std::vector<Sphere<float>> spheres;
    std::vector<Shape<float>> shapes;
    std::vector<Tool<float>> tools;
    Colliders<float> colliders;
    Mask every{};

    explicit Posed(const knead::Setup& s)
    {
        for (const Binding<float>& b : s.rig.spheres)
            spheres.push_back(posed(b, joints_at<float>(squeeze, 0), joints_at<float>(squeeze, 1),
                                    float(dt), 1.0f));
        for (const Primitive& p : s.rig.primitives)
            shapes.push_back(shape(p.count, spheres[std::size_t(p.sphere[0])],
                                   spheres[std::size_t(p.sphere[1])],
                                   spheres[std::size_t(p.sphere[2])]));
        for (const Tool<double>& t : s.tools)
            tools.push_back({t.mode, float(t.friction), t.blade, t.active});
        colliders = {{spheres.data(), int(spheres.size())},
                     {s.rig.primitives.data(), int(s.rig.primitives.size())},
                     {shapes.data(), int(shapes.size())},
                     {tools.data(), int(tools.size())}};
        for (std::size_t i = 0; i < shapes.size(); ++i) every.bits[i / 32] |= 1u << (i % 32);
    }
};

struct View {
    Lattice<float> lattice;
    Walls<float> walls;
    Material<float> material;
    explicit View(const knead::Setup& s)
        : lattice{s.lattice.size, float(s.lattice.dx)},
          walls(walls_on<float>(s.lattice, s.walls)),
          material(cast<float>(s.materials[0]))
    {
    }
};

// Sums in double over the shares of the float formula, and the largest of the sums.
std::vector<Node<double>> scattered(const knead::Setup& s)
{
    const View v(s);
    std::vector<Node<double>> nodes(std::size_t(v.lattice.node_count()));
    for (const Particle<double>& given : s.particles) {
        const Particle<float> q = cast<float>(given);
        const Stencil<float> st = stencil(q.x, v.lattice.dx);
        scatter(q, v.material, st, v.lattice.dx, float(dt), [&](Int3 step, const Node<float>& n) {
            Node<double>& to = nodes[std::size_t(v.lattice.index(st.base + step))];
            to = {to.p + cast<double>(n.p), to.m + double(n.m)};
        });
    }
    return nodes;
}

// Momenta as a substep would find them.
std::vector<Node<float>> momenta(const knead::Setup& s)
{
    std::vector<Node<float>> out;
    for (const Node<double>& n : scattered(s)) out.push_back({cast<float>(n.p), float(n.m)});
    return out;
}

std::vector<Node<float>> updated(const knead::Setup& s, const std::vector<Node<float>>& sums,
                                 const Posed& t)
{
    const View v(s);
    return updated_nodes(
        sums, v.lattice, v.walls, cast<float>(s.gravity), float(dt),
        [&](Vec3<float> x, Vec3<float> u) { return apply_tools(t.colliders, t.every, x, u); });
}

Particle<float> moved(const knead::Setup& s, Particle<float> q,
                      const std::vector<Node<float>>& velocities, const Posed& t)
{
    const View v(s);
    const Particle<float> before = q;
    const Stencil<float> st = stencil(q.x, v.lattice.dx);
    const auto node = [&](Int3 step) {
        return velocities[std::size_t(v.lattice.index(st.base + step))];
    };
    const auto sum = gather(q, st, v.lattice.dx, [&](Int3 step) { return four(node(step)); });
    const float per_cell = mass_around(sum) / v.material.mass;
    damp_isolated_particle(q.C, node(nearest_node).m / v.material.mass);
    StepLimits limits = step_limits(s);
    limits.fixed = dt;  // as GpuStages has it
    const auto way = cast<float>(pushout_limits(limits));
    q.e = advance_b(q.e, q.C, float(dt));
    q.x = q.x + float(dt) * q.v;
    std::uint32_t touched = 0;
    project(q, t.colliders, t.every, s.passes, way, per_cell, float(dt), touched);
    confine(q, v.walls);
    yield(q, v.material, float(dt));
    repair(q, before);
    return q;
}

template <class A>
bool same_bits(const A& a, const A& b)
{
    return std::memcmp(&a, &b, sizeof a) == 0;
}

void expect_near(const std::vector<Node<double>>& expected, const std::vector<Node<float>>& got,
                 double share)
{
    double max_p = 0, max_m = 0, off_p = 0, off_m = 0;
    ASSERT_EQ(expected.size(), got.size());
    for (std::size_t i = 0; i < got.size(); ++i) {
        max_p = std::fmax(max_p, length(expected[i].p)), max_m = std::fmax(max_m, expected[i].m);
        off_p = std::fmax(off_p, length(cast<double>(got[i].p) - expected[i].p));
        off_m = std::fmax(off_m, std::fabs(double(got[i].m) - expected[i].m));
    }
    EXPECT_GT(max_p, 0);
    EXPECT_GT(max_m, 0);
    EXPECT_LE(off_p, share * max_p);
    EXPECT_LE(off_m, share * max_m);
}

// The difference of two velocities or strains, over the larger of their size and `floor`.
double apart(Vec3<float> a, Vec3<float> b, double floor)
{
    return double(length(a - b)) / std::fmax(double(length(b)), floor);
}

class GpuStage : public ::testing::Test {
  protected:
    void SetUp() override
    {
        if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    }
};

TEST_F(GpuStage, ScatterAgreesWithALoop)
{
    for (Plasticity plasticity :
         {Plasticity::von_mises, Plasticity::drucker_prager, Plasticity::fluid}) {
        knead::Setup s = turmoil(32, plasticity);
        s.materials[0].bulk = 1e5, s.materials[0].exponent = 7;
        GpuStages stages(s, squeeze, dt);
        expect_near(scattered(s), stages.p2g(), to_the_bit ? 1e-6 : 3e-6);
    }
}

TEST_F(GpuStage, ScatterOfSortedParticlesAgreesWithALoop)
{
    const knead::Setup s = turmoil(32, Plasticity::von_mises);
    GpuStages stages(s, squeeze, dt);
    stages.sort();
    expect_near(scattered(s), stages.p2g(), to_the_bit ? 1e-6 : 3e-6);
}

TEST_F(GpuStage, FixedPointSumsAreTheSameEveryTime)
{
    knead::Setup s = turmoil(32, Plasticity::von_mises);
    s.deterministic = true;
    std::vector<Node<float>> first;
    for (int run = 0; run < 10; ++run) {
        GpuStages stages(s, squeeze, dt);
        stages.sort();
        const auto sums = stages.p2g();
        if (run == 0) first = sums;
        for (std::size_t i = 0; i < sums.size(); ++i) ASSERT_TRUE(same_bits(sums[i], first[i]));
    }
    expect_near(scattered(s), first, to_the_bit ? 1e-6 : 3e-6);
}

TEST_F(GpuStage, GridUpdateAgreesWithALoop)
{
    for (const auto add : {add_tools, add_knots}) {
        knead::Setup s = turmoil(32, Plasticity::von_mises);
        add(s);
        const Posed tools(s);
        const auto sums = momenta(s), expected = updated(s, sums, tools);
        const auto without = updated(s, sums, Posed(ball(16)));
        const auto got = GpuStages(s, squeeze, dt).grid(sums);
        int held_nodes = 0, astray = 0;
        for (std::size_t i = 0; i < got.size(); ++i) {
            held_nodes += !same_bits(expected[i], without[i]);
            if (to_the_bit) {
                const Vec3<float>&a = got[i].p, &b = expected[i].p;
                ASSERT_TRUE(a.x == b.x && a.y == b.y && a.z == b.z && got[i].m == expected[i].m)
                    << i;
            }
            astray += !(apart(got[i].p, expected[i].p, 1) < 1e-4);
        }
        EXPECT_GT(held_nodes, 50);  // the tools mattered
        EXPECT_LE(astray, add == add_knots ? equally_deep : 0);
    }
}

TEST_F(GpuStage, EveryPrimitiveThatTouchesABlockIsInItsMask)
{
    knead::Setup s = ball(32);
    add_tools(s);
    const Posed t(s);
    const View v(s);
    const auto masks = GpuStages(s, squeeze, dt).masks();
    Random random;
    int inside = 0, left_out = 0;
    for (int k = 0; k < 200000; ++k) {
        const Vec3<float> x = cast<float>(Vec3<double>{0.5, 0.5, 0.5} + random.vector(0.49));
        const Int3 cell = {int(x.x / v.lattice.dx), int(x.y / v.lattice.dx),
                           int(x.z / v.lattice.dx)};
        const Mask& mask = masks[std::size_t(v.lattice.block_of(cell))];
        for (int i = 0; i < t.colliders.shapes.count; ++i) {
            const bool listed = mask.bits[i / 32] >> (i % 32) & 1;
            const bool apply_contact = closest_point(t.shapes[std::size_t(i)], x).phi < 0;
            inside += apply_contact, left_out += !listed;
            ASSERT_TRUE(listed || !apply_contact);
        }
    }
    EXPECT_GT(inside, 1000);
    EXPECT_GT(left_out, 100000);
}

// How far apart two results for a particle are, of positions [m], a tenth of velocities, strains.
double distance(const Particle<float>& a, const Particle<float>& b)
{
    return std::fmax(std::fmax(apart(a.x, b.x, 1), 0.1 * apart(a.v, b.v, 1)),
                     double(std::sqrt(norm_squared(a.e + (-1.0f) * b.e))));
}

TEST_F(GpuStage, MovedParticlesAgreeWithALoop)
{
    for (Plasticity plasticity :
         {Plasticity::none, Plasticity::von_mises, Plasticity::drucker_prager, Plasticity::clamp}) {
        for (const auto add : {add_tools, add_knots}) {
            knead::Setup s = turmoil(32, plasticity);
            add(s);
            const Posed tools(s), none(ball(16));
            const auto velocities = updated(s, momenta(s), tools);
            GpuStages stages(s, squeeze, dt);
            if (add == add_knots) stages.sort();  // else no two particles of a warp are neighbours
            const auto got = stages.g2p(velocities);
            const bool bits = to_the_bit && (plasticity == Plasticity::none ||
                                             plasticity == Plasticity::von_mises);
            int astray = 0, put_out = 0;
            for (std::size_t i = 0; i < got.size(); ++i) {
                const Particle<float> before = cast<float>(s.particles[i]), a = cast<float>(got[i]),
                                      b = moved(s, before, velocities, tools);
                if (bits) {
                    ASSERT_TRUE(same_bits(a.x, b.x) && same_bits(a.v, b.v) && same_bits(a.C, b.C) &&
                                same_bits(a.e, b.e) && a.k == b.k)
                        << i;
                }
                put_out += !same_bits(b.x, moved(s, before, velocities, none).x);
                astray += !(distance(a, b) < 2e-5);
            }
            EXPECT_GT(put_out, 100);
            EXPECT_LE(astray, add == add_knots ? equally_deep : 0) << "flow " << int(plasticity);
        }
    }
}

// On lattices for which the radix sort takes one pass, two and three, and by counting; from either
// side to the other, and again in the order that is there already; all in one cell, too; and so
// many that their rows move one by one.
TEST_F(GpuStage, ASortOrdersTheParticlesByCellAndChangesNoneOfThem)
{
    for (int given = 0; given < 10; ++given) {
        const bool many = given >= 8, crowded = given / 2 == 3;
        const int nodes = many ? 176 : 16 << given / 2 % 3;
        knead::Setup s = turmoil(nodes, Plasticity::von_mises);
        s.deterministic = given % 2;
        ASSERT_EQ(s.particles.size() > few_particles, many);
        // The smallest ball would be beyond walls of more nodes.
        s.walls = walls_inside(s.lattice, 2, s.walls.mode, s.walls.friction);
        if (crowded)
            for (Particle<double>& q : s.particles) q.x = s.particles[0].x;
        const auto key = [v = View(s), &s](int i) {
            return v.lattice.index(
                base_node(cast<float>(s.particles[std::size_t(i)].x), v.lattice.dx));
        };
        std::vector<int> expected(s.particles.size());
        std::iota(expected.begin(), expected.end(), 0);
        std::stable_sort(expected.begin(), expected.end(),
                         [&](int a, int b) { return key(a) < key(b); });
        GpuStages stages(s, squeeze, dt);
        for (int time = 0; time < 3; ++time) {
            std::vector<int> order = stages.sort();
            const auto less = [&](int a, int b) { return key(a) < key(b); };
            ASSERT_TRUE(std::is_sorted(order.begin(), order.end(), less)) << given << ", " << time;
            // By counting, those of a cell come in any order.
            if (!s.deterministic)
                std::sort(order.begin(), order.end(),
                          [&](int a, int b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
            ASSERT_EQ(order, expected) << given << ", " << time;
            const std::vector<Particle<double>> got = stages.particles();
            for (std::size_t i = 0; i < got.size(); ++i) {
                const Particle<float> a = cast<float>(got[i]), b = cast<float>(s.particles[i]);
                ASSERT_TRUE(same_bits(a.x, b.x) && same_bits(a.v, b.v) && same_bits(a.C, b.C) &&
                            same_bits(a.e, b.e) && a.k == b.k && a.object == b.object &&
                            a.sides == b.sides)
                    << given << ", " << time << ", " << i;
            }
        }
    }
}

TEST_F(GpuStage, AParticleThatIsNoLongerANumberIsPutBack)
{
    knead::Setup s = turmoil(32, Plasticity::von_mises);
    auto velocities = updated(s, momenta(s), Posed(s));
    for (Node<float>& n : velocities) n.p.x = std::nanf("");
    const auto got = GpuStages(s, squeeze, dt).g2p(velocities);
    for (std::size_t i = 0; i < got.size(); ++i) {
        ASSERT_TRUE(same_bits(cast<float>(got[i]).x, cast<float>(s.particles[i]).x)) << i;
        ASSERT_EQ(length(got[i].v), 0) << i;
    }
}

}  // namespace
}  // namespace knead
