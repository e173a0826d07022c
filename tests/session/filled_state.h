// States in which each number is another one, to see that files have all of them.
#pragma once
#include <vector>

#include "host/paging/local_state.h"
#include "host/solver/editable_simulator.h"
#include "host/splats/carried.h"

namespace knead {

// Numbers from 1 on, each of them once.
struct Next {
    int last = 0;
    template <class T>
    void operator()(T& number)
    {
        number = T(++last);
    }
    void operator()(bool& flag) { flag = ++last % 2; }
    void operator()(Vec3<double>& v) { (*this)(v.x), (*this)(v.y), (*this)(v.z); }
    void operator()(Vec3<float>& v) { (*this)(v.x), (*this)(v.y), (*this)(v.z); }
    template <class... T>
    void all(T&... numbers)
    {
        ((*this)(numbers), ...);
    }
};

inline void fill(SplatCloud& cloud, std::size_t count, Next& next)
{
    cloud.degree = 1, cloud.antialiased = true;
    resize(cloud, count);
    for (std::size_t i = 0; i < count; ++i) {
        next.all(cloud.centre[i], cloud.rotation[i].w, cloud.rotation[i].x, cloud.rotation[i].y,
                 cloud.rotation[i].z, cloud.scale[i], cloud.opacity[i]);
        for (std::size_t k = 0; k < 4; ++k) next(cloud.sh[4 * i + k]);
    }
}

template <class P>
void fill_strained(P& p, Next& next)
{
    next.all(p.object, p.sides, p.x);
    p.object = int(next.last % 3);
}

// The members `state`, `splats` and `local` of a checkpoint or a stored state.
template <class S>
void fill_state(S& of, Next& next)
{
    SavedState& s = of.state;
    s.contents.particles.resize(3), s.contents.gaussians.resize(2), s.sliding.resize(2);
    for (Particle<double>& p : s.contents.particles)
        fill_strained(p, next),
            next.all(p.v, p.C.a, p.C.b, p.C.c, p.e.xx, p.e.yy, p.e.zz, p.e.xy, p.e.xz, p.e.yz, p.k);
    for (Gaussian<double>& g : s.contents.gaussians)
        fill_strained(g, next), next.all(g.F.a, g.F.b, g.F.c);
    s.order = {2, 0, 1}, s.quiet = {7, 0, 9, 11};
    for (SlidingNode& n : s.sliding) next.all(n.place, n.force, n.time, n.impulse_deficit);
    s.quiet_low = {4, 8, 12}, s.quiet_stored = {16, 20, 24}, s.covered = true;
    next.all(s.speed_squared, s.stiffness, s.drift);
    fill(of.splats.cloud, 2, next);
    of.splats.extent.resize(2), next.all(of.splats.extent[0], of.splats.extent[1]);
    LocalState& l = of.local;
    fill(l.cloud, 4, next);
    l.active = {1, 0, 0, 1}, l.normal.resize(4), l.slot_of = {3, -1, 0, 2, 1};
    for (Vec3<float>& n : l.normal) next(n);
    l.clay = {{-5, -1}, {7, 2}}, l.objects = 3;
}

}  // namespace knead
