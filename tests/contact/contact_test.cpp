// Contact: the laws of contact, which primitives a block must look at, and that nothing stays
// inside.
#include "cuda/contact/contact.h"

#include <cmath>
#include <vector>

#include "cuda/mpm/grid.h"
#include "cuda/mpm/project.h"
#include "tests/solver/samples.h"

namespace knead {
namespace {

template <class R>
class ContactTest : public ::testing::Test {
};
TYPED_TEST_SUITE(ContactTest, Scalars);

constexpr ContactMode contact_modes[] = {ContactMode::sticky, ContactMode::slip,
                                         ContactMode::separate};

// Tools that own their memory.
template <class R>
struct Rig {
    std::vector<Sphere<R>> spheres;
    std::vector<Primitive> primitives;
    std::vector<Shape<R>> shapes;
    std::vector<Tool<R>> tools;

    void add(int count, const Sphere<R>& a, const Sphere<R>& b, const Sphere<R>& c)
    {
        const int first = int(spheres.size()), last = int(tools.size()) - 1;
        for (const Sphere<R>& s : {a, b, c}) spheres.push_back(s);
        primitives.push_back(
            {count, {first, first + std::min(1, count - 1), first + count - 1}, last});
        shapes.push_back(shape(count, a, count > 1 ? b : a, count > 2 ? c : count > 1 ? b : a));
    }
    Colliders<R> colliders() const
    {
        return {{spheres.data(), int(spheres.size())},
                {primitives.data(), int(primitives.size())},
                {shapes.data(), int(shapes.size())},
                {tools.data(), int(tools.size())}};
    }
    Mask all() const
    {
        Mask m{};
        for (std::size_t i = 0; i < primitives.size(); ++i) m.bits[i / 32] |= 1u << i % 32;
        return m;
    }
    Mask near(Vec3<R> p, R edge, R band) const
    {
        Mask m{};
        for (std::size_t i = 0; i < shapes.size(); ++i)
            if (reaches(shapes[i], p, edge, band)) m.bits[i / 32] |= 1u << i % 32;
        return m;
    }
};

template <class R>
Sphere<R> sphere(Vec3<double> c, double r, Vec3<double> v = {}, Vec3<double> w = {},
                 double rate = 0)
{
    return {cast<R>(c), cast<R>(v), cast<R>(w), R(r), R(rate)};
}

// Two tools of `count` primitives of all kinds in the unit cube, moving.
template <class R>
Rig<R> random_rig(Draw& draw, int count)
{
    Rig<R> rig;
    for (int tool = 0; tool < 2; ++tool) {
        rig.tools.push_back({contact_modes[draw.below(3)], R(draw.in(0, 1)), false, true});
        for (int i = 0; i < count; ++i) {
            const Vec3<double> at{draw.in(0.1, 0.9), draw.in(0.1, 0.9), draw.in(0.1, 0.9)};
            const auto one = [&] {
                return sphere<R>(at + draw.vector(0.1), draw.in(0.005, 0.05), draw.vector(),
                                 draw.vector(5), draw.in(-0.1, 0.1));
            };
            const Sphere<R> a = one(), b = one();
            rig.add(1 + draw.below(3), a, b, one());
        }
    }
    return rig;
}

TYPED_TEST(ContactTest, StickyHoldsWhatApproachesAndLetsGoOfWhatLeaves)
{
    using R = TypeParam;
    const Vec3<R> n{0, 1, 0}, u{1, 2, 3};
    const Vec3<R> in{5, 1, 5}, out{5, 3, 5};
    EXPECT_EQ(length(apply_contact(in, n, u, ContactMode::sticky, R(0.5)) - u), 0);
    EXPECT_EQ(length(apply_contact(out, n, u, ContactMode::sticky, R(0.5)) - out), 0);
}

TYPED_TEST(ContactTest, SlipTakesTheNormalPartOnlyEitherWay)
{
    using R = TypeParam;
    Draw draw(1);
    for (int round = 0; round < 1000; ++round) {
        const Vec3<R> n = cast<R>(draw.direction()), u = cast<R>(draw.vector()),
                      v = cast<R>(draw.vector());
        const Vec3<R> left = apply_contact(v, n, u, ContactMode::slip, R(0.7));
        EXPECT_NEAR(double(dot(left - u, n)), 0, either<R>(1e-6, 1e-15));
        EXPECT_NEAR(double(length(cross(left - v, n))), 0, either<R>(1e-6, 1e-15));
    }
}

TYPED_TEST(ContactTest, CoulombFrictionSticksBelowItsThresholdAndSlowsAboveIt)
{
    using R = TypeParam;
    Draw draw(2);
    int stuck = 0, slid = 0, left_alone = 0;
    for (int round = 0; round < 5000; ++round) {
        const Vec3<double> n = draw.direction(), u = draw.vector();
        const Vec3<double> along = orthogonal(n);
        const double vn = draw.in(-1, 1), vt = draw.in(0, 1), friction = draw.in(0, 2);
        const Vec3<double> v = u + vn * n + vt * along;
        const Vec3<double> found = cast<double>(
            apply_contact(cast<R>(v), cast<R>(n), cast<R>(u), ContactMode::separate, R(friction)));
        Vec3<double> expected = v;
        if (vn < 0) {
            const double kept = vt + friction * vn;
            expected = kept > 0 ? u + kept * along : u;
            ++(kept > 0 ? slid : stuck);
        } else {
            ++left_alone;
        }
        EXPECT_LT(length(found - expected), either<R>(2e-6, 4e-15));
    }
    EXPECT_GT(stuck, 500);
    EXPECT_GT(slid, 500);
    EXPECT_GT(left_alone, 500);
}

TYPED_TEST(ContactTest, EdgesOfTheFrictionLaw)
{
    using R = TypeParam;
    const Vec3<R> n{0, 0, 1}, u{};
    const auto law = [&](Vec3<R> v, R friction) {
        return apply_contact(v, n, u, ContactMode::separate, friction);
    };
    EXPECT_EQ(length(law({0, 0, -1}, R(0))), 0);  // straight in, no friction: no 0 / 0
    EXPECT_EQ(length(law({0, 0, -1}, R(0.5))), 0);
    EXPECT_EQ(length(law({R(0.5), 0, -1}, R(0.5))), 0);  // at the threshold it sticks
    EXPECT_EQ(law({3, 0, -1}, R(0)).x, 3);               // no friction: slides on
    EXPECT_EQ(law({3, 0, 0}, R(9)).x, 3);                // grazing: no pressure, no friction
    EXPECT_EQ(length(law({}, R(1))), 0);
}

TYPED_TEST(ContactTest, ContactNeverAddsEnergyInTheToolsFrameNorLeavesAnythingGoingIn)
{
    using R = TypeParam;
    Draw draw(3);
    for (int round = 0; round < 20000; ++round) {
        const ContactMode mode = contact_modes[round % 3];
        const Vec3<R> n = cast<R>(draw.direction()), u = cast<R>(draw.power(-3, 1) * draw.vector()),
                      v = cast<R>(draw.power(-3, 1) * draw.vector());
        const Vec3<R> left = apply_contact(v, n, u, mode, R(draw.power(-2, 1)));
        const double slack = either<R>(1e-6, 1e-15) * double(length(u) + length(v));
        EXPECT_LE(double(length(left - u)), double(length(v - u)) + slack);
        EXPECT_GE(double(dot(left - u, n)), -slack);
    }
}

TYPED_TEST(ContactTest, ContactIsTheSameInEveryMovingAndTurnedFrame)
{
    using R = TypeParam;
    Draw draw(4);
    for (int round = 0; round < 5000; ++round) {
        const ContactMode mode = contact_modes[round % 3];
        const Vec3<double> n = draw.direction(), u = draw.vector(), v = draw.vector(),
                           w = draw.vector();
        const Mat3<double> Q = draw.rotation();
        const R friction = R(draw.in(0, 1));
        if (std::abs(dot(v - u, n)) < 1e-4) continue;  // whether it approaches is then rounding
        const auto law = [&](Vec3<double> velocity, Vec3<double> normal, Vec3<double> surface) {
            return cast<double>(apply_contact(cast<R>(velocity), cast<R>(normal), cast<R>(surface),
                                              mode, friction));
        };
        const Vec3<double> expected = Q * law(v, n, u) + w;
        EXPECT_LT(length(law(Q * v + w, Q * n, Q * u + w) - expected), either<R>(3e-6, 1e-14));
    }
}

TEST(ContactInDouble, TheSurfaceMovesAsTheDistanceChanges)
{
    Draw draw(5);
    const double h = 1e-6;
    for (int round = 0; round < 2000; ++round) {
        Rig<double> rig;
        rig.tools.push_back({ContactMode::separate, 0, false, true});
        const auto one = [&] {
            return sphere<double>(draw.vector(), draw.in(0.1, 0.4), draw.vector(), {},
                                  draw.in(-1, 1));
        };
        const Sphere<double> a = one(), b = one(), c = one();
        const int count = 1 + draw.below(3);
        rig.add(count, a, b, c);
        const Vec3<double> p = draw.vector(2);
        const Contact<double> hit = nearest(rig.colliders(), rig.all(), p);
        if (hit.phi < 0.01) continue;
        const auto later = [&](double t) {
            const auto moved = [&](Sphere<double> s) {
                s.c = s.c + t * s.v, s.r += t * s.rate;
                return s;
            };
            Rig<double> r = rig;
            r.shapes.clear(), r.primitives.clear(), r.spheres.clear();
            r.add(count, moved(a), moved(b), moved(c));
            return nearest(r.colliders(), r.all(), p).phi;
        };
        EXPECT_NEAR((later(h) - later(-h)) / (2 * h), -dot(hit.n, hit.v), 2e-5);
    }
}

TYPED_TEST(ContactTest, ATwistingCapsuleDragsItsSurfaceAround)
{
    using R = TypeParam;
    Rig<R> rig;
    rig.tools.push_back({ContactMode::separate, R(0.5), false, true});
    const Vec3<double> spin{5, 0, 0};
    const Sphere<R> a = sphere<R>({0, 0, 0}, 0.1, {}, spin),
                    b = sphere<R>({1, 0, 0}, 0.1, {}, spin);
    rig.add(2, a, b, b);
    const Contact<R> hit = nearest(rig.colliders(), rig.all(), {R(0.5), R(0.08), 0});
    EXPECT_NEAR(double(hit.v.z), 5 * 0.1, 1e-6);
    const Vec3<R> still{0, R(-0.1), 0};  // pressed on, it is carried along with friction only
    EXPECT_GT(apply_contact(still, hit.n, hit.v, ContactMode::separate, R(0.5)).z, R(0.04));
    EXPECT_EQ(apply_contact(still, hit.n, hit.v, ContactMode::separate, R(0)).z, 0);
}

TYPED_TEST(ContactTest, MaskedContactEqualsBruteForceToTheBit)
{
    using R = TypeParam;
    Draw draw(6);
    long compared = 0;
    for (int round = 0; round < 20; ++round) {
        const Rig<R> rig = random_rig<R>(draw, 100);
        const Colliders<R> c = rig.colliders();
        const Mask all = rig.all();
        const Lattice<R> lattice{{32, 32, 32}, R(1) / 32};
        const R edge = 4 * lattice.dx, band = round % 2 ? 0 : lattice.dx;
        for (int b = 0; b < lattice.block_count(); b += 1 + draw.below(3)) {
            const Vec3<R> corner = lattice.position(4 * lattice.block_at(b));
            const Mask mask = rig.near(corner + R(0.5) * Vec3<R>{edge, edge, edge}, edge, band);
            for (int k = 0; k < 8; ++k) {
                const Vec3<R> p =
                    corner + edge * cast<R>(0.5 * (draw.vector() + Vec3<double>{1, 1, 1}));
                const Contact<R> expected = nearest(c, all, p), found = nearest(c, mask, p);
                const Vec3<R> v = cast<R>(draw.vector());
                EXPECT_EQ(length(apply_tools(c, all, p, v) - apply_tools(c, mask, p, v)), 0);
                if (expected.phi > band) continue;
                ++compared;
                EXPECT_EQ(expected.phi, found.phi);
                EXPECT_EQ(expected.tool, found.tool);
                EXPECT_EQ(length(expected.n - found.n), 0);
                EXPECT_EQ(length(expected.v - found.v), 0);
            }
        }
    }
    EXPECT_GT(compared, 3000);
}

TYPED_TEST(ContactTest, CandidatesAreVisitedInOrderAndOnce)
{
    Draw draw(7);
    for (int round = 0; round < 200; ++round) {
        Mask mask{};
        std::vector<int> expected, found;
        for (int i = 0; i < max_primitives; ++i)
            if (draw.below(5) == 0) mask.bits[i / 32] |= 1u << i % 32, expected.push_back(i);
        for_each_candidate(mask, [&](int i) { found.push_back(i); });
        EXPECT_EQ(expected, found);
    }
}

TYPED_TEST(ContactTest, FarFromEveryToolNothingHappens)
{
    using R = TypeParam;
    Draw draw(8);
    const Rig<R> rig = random_rig<R>(draw, 10);
    const Vec3<R> v{1, 2, 3}, far{9, 9, 9};
    EXPECT_EQ(nearest(rig.colliders(), Mask{}, far).tool, -1);
    EXPECT_EQ(length(apply_tools(rig.colliders(), Mask{}, far, v) - v), 0);
    EXPECT_EQ(length(apply_tools(rig.colliders(), rig.all(), far, v) - v), 0);
    Particle<R> q{};
    q.x = far, q.v = v, q.C = cast<R>(draw.matrix());
    const Particle<R> before = q;
    std::uint32_t touched = 0;
    const PushoutLimits<R> pushout{1, 1, 1, R(0.1)};
    EXPECT_EQ(project(q, rig.colliders(), rig.all(), 2, pushout, R(8), R(0.01), touched), 0);
    EXPECT_EQ(touched, 0u);
    EXPECT_EQ(length(q.x - before.x) + length(q.v - before.v) + size(q.C - before.C), 0);
}

// A shallow one stays where it is and is given a velocity: one by itself that which brings it out
// in a substep, one among others more, but no faster than asked for, or than twice that in a thin
// layer. What is deeper is moved, up to there. All is as with tools that are fatter by the skin.
TYPED_TEST(ContactTest, AParticleInsideAnyPrimitiveIsOnItsWayOutAndNeverDeep)
{
    using R = TypeParam;
    Draw draw(9);
    const R dt = R(0.01), shallow = R(0.025), thin = R(0.016), fastest = 4;
    int shallow_ones = 0, deep_ones = 0, faster_ones = 0;
    for (int round = 0; round < 20000; ++round) {
        Rig<R> rig;
        rig.tools.push_back({contact_modes[round % 3], R(0.3), false, true});
        const auto one = [&] {
            return sphere<R>(draw.vector(0.2), draw.in(0.05, 0.15), draw.vector());
        };
        const Sphere<R> a = one(), b = one();
        rig.add(1 + draw.below(3), a, b, one());
        Particle<R> q{};
        q.x = cast<R>(draw.vector(0.3)), q.v = cast<R>(draw.vector()), q.C = cast<R>(draw.matrix());
        const R skin = round % 2 ? R(0) : R(0.01);
        Contact<R> before = nearest(rig.colliders(), rig.all(), q.x);
        before.phi -= skin;
        const Particle<R> was = q;
        constexpr double per_cell[] = {0.2, 1, 8}, times[] = {1, 3.3, 31.3};
        const R among = R(per_cell[round / 3 % 3]);
        std::uint32_t touched = 0;
        const PushoutLimits<R> pushout{shallow, thin, fastest, skin};
        const R depth = project(q, rig.colliders(), rig.all(), 1, pushout, among, dt, touched);
        EXPECT_EQ(touched, before.phi < 0 ? tool_bit(before.tool) : 0);
        EXPECT_EQ(size(q.C - was.C), 0);
        if (before.phi >= 0) {
            EXPECT_EQ(depth, 0);
            EXPECT_EQ(length(q.x - was.x), 0);
            continue;
        }
        EXPECT_NEAR(double(depth), -double(before.phi), either<R>(1e-6, 1e-14));
        if (-before.phi <= shallow - R(1e-6)) {
            ++shallow_ones;
            EXPECT_EQ(length(q.x - was.x), 0);
        } else {
            ++deep_ones;
            EXPECT_NEAR(double(nearest(rig.colliders(), rig.all(), q.x).phi),
                        double(skin) - double(shallow), either<R>(2e-6, 1e-12));
        }
        double most = double(fastest);
        if (among > 1 && depth < thin) {
            ++faster_ones;
            most = double(fastest) * std::min(2.0, double(thin) / double(depth));
        }
        const double out = std::min(times[round / 3 % 3] * double(depth) / double(dt), most);
        EXPECT_GE(double(dot(q.v - before.v, before.n)), out - either<R>(1e-4, 1e-12));
        if (double(dot(was.v - before.v, before.n)) > out) {  // what leaves faster is left alone
            EXPECT_EQ(length(q.v - was.v), 0);
        } else {
            EXPECT_LE(double(dot(q.v - before.v, before.n)), out + either<R>(1e-4, 1e-12));
        }
    }
    EXPECT_GT(shallow_ones, 500);
    EXPECT_GT(deep_ones, 500);
    EXPECT_GT(faster_ones, 100);
}

TYPED_TEST(ContactTest, APlaneIsWhereItIsForNodesAndParticlesAlikeAtEveryFractionOfACell)
{
    using R = TypeParam;
    const Lattice<R> lattice{{16, 16, 16}, R(1) / 16};
    const Walls<R> walls = walls_on<R>(lattice, walls_inside(lattice, 2, ContactMode::slip, 0));
    for (int tenth = 0; tenth < 20; ++tenth) {
        const double height = (5 + (tenth + 0.5) / 20) / 16;
        Rig<R> rig;  // the upper face of a slab far wider than the box
        rig.tools.push_back({ContactMode::separate, 0, false, true});
        rig.add(3, sphere<R>({-9, height - 2, -9}, 2), sphere<R>({20, height - 2, -9}, 2),
                sphere<R>({0, height - 2, 20}, 2));
        for (int j = 3; j < 13; ++j) {
            const Int3 n{8, j, 8};
            bool clipped;
            const Node<R> node{{0, R(-0.01), 0}, R(0.01)};
            const Node<R> after = update(node, n, lattice, walls, {0, 0, 0}, R(1e-3), clipped,
                                         [&](Vec3<R> x, Vec3<R> v) {
                                             return apply_tools(rig.colliders(), rig.all(), x, v);
                                         });
            EXPECT_NEAR(double(after.p.y), j / 16.0 < height ? 0 : -1, either<R>(1e-6, 1e-14)) << j;
        }
        Particle<R> q{};
        q.x = {R(0.5), R(height - 0.02), R(0.5)}, q.v = {0, -1, 0};
        std::uint32_t touched = 0;
        const PushoutLimits<R> pushout{lattice.dx / 4, lattice.dx / 4, R(1e3), 0};
        const R depth =
            project(q, rig.colliders(), rig.all(), 2, pushout, R(0.1), R(1e-3), touched);
        EXPECT_NEAR(double(depth), 0.02, either<R>(5e-6, 1e-12));
        EXPECT_NEAR(double(q.x.y), height - 1.0 / 64, either<R>(5e-6, 1e-12));  // a quarter is left
        EXPECT_NEAR(double(q.v.y), 20, either<R>(5e-3, 1e-9));
    }
}

}  // namespace
}  // namespace knead
