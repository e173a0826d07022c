#include "host/hands/rig.h"

#include <initializer_list>
#include <iterator>

#include "host/hands/rig_table.h"

namespace knead {
namespace {

// Joints of finger f, from 0, the index, to 3, the little finger.
JointName metacarpal(int f) { return JointName(index_metacarpal + 5 * f); }
JointName proximal(int f) { return JointName(index_proximal + 5 * f); }
JointName intermediate(int f) { return JointName(index_intermediate + 5 * f); }
JointName distal(int f) { return JointName(index_distal + 5 * f); }

struct Spanning {
    std::vector<Primitive>& to;
    void cone(int a, int b) const { to.push_back({2, {a, b, b}, 0}); }
    void slab(int a, int b, int c) const { to.push_back({3, {a, b, c}, 0}); }
    void chain(std::initializer_list<int> along) const
    {
        for (auto a = along.begin(); a + 1 != along.end(); ++a) cone(a[0], a[1]);
    }
};

constexpr int at(int joint) { return joint - wrist; }  // index of the sphere that starts at a joint

Layout h25()
{
    Layout l;
    for (int j = wrist; j < joint_count; ++j) l.spheres.push_back({JointName(j), JointName(j), 0});
    const Spanning span{l.primitives};
    for (int f = 0; f < 4; ++f) {
        const int p = at(proximal(f));
        span.chain({p, p + 1, p + 2, p + 3});
    }
    span.chain({at(thumb_proximal), at(thumb_distal), at(thumb_tip)});
    for (int f = 0; f < 3; ++f) {
        const int m = at(metacarpal(f)), p = at(proximal(f));
        span.slab(m, p, p + 5);
        span.slab(m, p + 5, m + 5);
        span.slab(at(wrist), m, m + 5);
    }
    span.slab(at(thumb_metacarpal), at(thumb_proximal), at(index_metacarpal));
    span.slab(at(thumb_proximal), at(index_proximal), at(index_metacarpal));
    span.slab(at(wrist), at(thumb_metacarpal), at(index_metacarpal));
    return l;
}

Layout h47()
{
    Layout l{h25().spheres, {}};
    const auto add = [&](JointName a, JointName b, double s) {
        l.spheres.push_back({a, b, s});
        return int(l.spheres.size()) - 1;
    };
    const Spanning span{l.primitives};
    int hand[4], base[4];  // middle of the metacarpal; finger root beyond the knuckle
    for (int f = 0; f < 4; ++f) {
        hand[f] = add(metacarpal(f), proximal(f), 0.5);
        base[f] = add(proximal(f), intermediate(f), 0.2);
        const int first = add(proximal(f), intermediate(f), 0.6);
        const int second = add(intermediate(f), distal(f), 0.5);
        span.chain({base[f], first, at(intermediate(f)), second, at(distal(f)), at(distal(f)) + 1});
    }
    const int ball = add(thumb_metacarpal, thumb_proximal, 0.5);
    const int thumb = add(thumb_proximal, thumb_distal, 0.5);
    span.chain({at(thumb_proximal), thumb, at(thumb_distal), at(thumb_tip)});
    for (int f = 0; f < 3; ++f) {
        const int web = add(proximal(f), proximal(f + 1), 0.5);
        const int m = at(metacarpal(f)), p = at(proximal(f));
        span.slab(at(wrist), m, m + 5);
        span.slab(m, hand[f], hand[f + 1]);
        span.slab(m, hand[f + 1], m + 5);
        span.slab(hand[f], p, p + 5);
        span.slab(hand[f], p + 5, hand[f + 1]);
        span.slab(p, p + 5, web);
        span.slab(p, base[f], web);
        span.slab(p + 5, base[f + 1], web);
    }
    const int web = add(thumb_proximal, index_proximal, 0.5);
    span.slab(at(wrist), at(thumb_metacarpal), at(index_metacarpal));
    span.slab(at(thumb_metacarpal), ball, at(index_metacarpal));
    span.slab(ball, hand[0], at(index_metacarpal));
    span.slab(ball, web, hand[0]);
    span.slab(ball, at(thumb_proximal), web);
    span.slab(hand[0], web, at(index_proximal));
    span.slab(at(thumb_proximal), web, thumb);
    return l;
}

}  // namespace

Layout layout(Topology topology) { return topology == Topology::h25 ? h25() : h47(); }

Rig hang(const std::vector<FittedSphere>& spheres, const std::vector<Primitive>& primitives,
         const Hand& open, Side side)
{
    Rig rig{{}, primitives};
    for (const FittedSphere& s : spheres) {
        const Vec3<float> c{side == right ? s.c.x : -s.c.x, s.c.y, s.c.z};
        Binding<float> b{};
        b.radius = s.r;
        for (int k = 0; k < 4; ++k) {
            const Joint<float>& j = open.joints[s.joint[k]];
            b.joint[k] = int(side) * joint_count + s.joint[k];
            b.weight[k] = s.weight[k];
            b.offset[k] = rotate(conjugate(j.q), c - j.p);
        }
        rig.spheres.push_back(b);
    }
    return rig;
}

Rig hand_rig(Topology topology, Side side)
{
    std::vector<FittedSphere> spheres;
    if (topology == Topology::h25)
        spheres.assign(std::begin(h25_spheres), std::end(h25_spheres));
    else
        spheres.assign(std::begin(h47_spheres), std::end(h47_spheres));
    return hang(spheres, layout(topology).primitives, open_hand(side), side);
}

}  // namespace knead
