// A group of particles in vector lanes: gather and scatter between AoS and registers.
#pragma once
#include <cstddef>

#include "cuda/math/node4.h"
#include "cuda/mpm/particle.h"
#include "cuda/mpm/stencil.h"
#include "host/solver/cpu/lanes.h"

namespace knead {
inline namespace KNEAD_CPU_LEVEL {

// Up to one particle per lane, of one object; unused lanes repeat the last particle.
template <class R>
struct Group {
    static constexpr int count = Lanes<R>::count;
    Particle<R>* of[count];
    int index[count];  // particle indices
    int size;
    // Requires equal object and equal still().
    bool takes(const Particle<R>& q) const
    {
        return size == 0 || (q.object == of[0]->object && q.still() == of[0]->still());
    }
};

// Loads four consecutive numbers per particle, at(lane), and transposes: one register per number.
template <class R, class At>
[[gnu::always_inline]] inline void load_four(Lanes<R> (&words)[4], At&& at)
{
    constexpr int count = Lanes<R>::count;
    UNROLL
    for (int r = 0; r < 4; ++r) {
        if constexpr (count == 4)
            words[r] = at(r);
        else if constexpr (count == 8)
            words[r] = joined(at(r), at(r + 4));
        else
            words[r] = joined(joined(at(r), at(r + 4)), joined(at(r + 8), at(r + 12)));
    }
    transpose(words[0].v, words[1].v, words[2].v, words[3].v);
}
// The inverse: calls to(lane, its four numbers).
template <class R, class To>
[[gnu::always_inline]] inline void store_four(const Lanes<R> (&words)[4], To&& to)
{
    typename Lanes<R>::V row[4] = {words[0].v, words[1].v, words[2].v, words[3].v};
    transpose(row[0], row[1], row[2], row[3]);
    UNROLL
    for (int l = 0; l < Lanes<R>::count; ++l) {
        typename Four<R>::V part;
        std::memcpy(&part, reinterpret_cast<const R*>(&row[l % 4]) + l / 4 * 4, sizeof part);
        to(l, part);
    }
}

// Stores a vector and a fourth number of each particle.
template <class R>
[[gnu::always_inline]] inline void spread(const Vec3<Lanes<R>>& u, Lanes<R> w, Four<R>* each)
{
    store_four<R>({u.x, u.y, u.z, w}, [&](int l, typename Four<R>::V part) { each[l] = {part}; });
}
template <class R>
[[gnu::always_inline]] inline Vec3<Lanes<R>> collected(const Four<R>* each)
{
    Lanes<R> words[4];
    load_four(words, [&](int l) { return each[l].v; });
    return {words[0], words[1], words[2]};
}

// Loads four consecutive words of each particle, beginning with `word`.
template <class R>
[[gnu::always_inline]] inline void load_words(const Group<R>& group, int word, Lanes<R> (&words)[4])
{
    load_four(words, [&](int l) {
        typename Four<R>::V part;
        std::memcpy(&part, reinterpret_cast<const R*>(group.of[l]) + word, sizeof part);
        return part;
    });
}
template <class R>
[[gnu::always_inline]] inline void store_words(const Group<R>& group, int word,
                                               const Lanes<R> (&words)[4])
{
    store_four(words, [&](int l, typename Four<R>::V part) {
        std::memcpy(reinterpret_cast<R*>(group.of[l]) + word, &part, sizeof part);
    });
}

// Word offsets of a particle's members.
template <class R>
constexpr bool particle_is_22_words = offsetof(Particle<R>, C) == 6 * sizeof(R) &&
                                      offsetof(Particle<R>, e) == 15 * sizeof(R) &&
                                      offsetof(Particle<R>, k) == 21 * sizeof(R);

// Loads x, e and k only.
template <class R>
[[gnu::always_inline]] inline void load_shape(const Group<R>& group, Particle<Lanes<R>>& p)
{
    static_assert(particle_is_22_words<R>);
    Lanes<R> place[4], e[4], f[4];
    load_words(group, 0, place), load_words(group, 15, e), load_words(group, 18, f);
    p.x = {place[0], place[1], place[2]};
    p.e = {e[0], e[1], e[2], f[0], f[1], f[2]};
    p.k = f[3];
}
template <class R>
[[gnu::always_inline]] inline Particle<Lanes<R>> load(const Group<R>& group)
{
    Particle<Lanes<R>> p;
    load_shape(group, p);
    Lanes<R> a[4], b[4], c[4];
    load_words(group, 3, a), load_words(group, 7, b), load_words(group, 11, c);
    p.v = {a[0], a[1], a[2]};
    p.C = {{a[3], b[0], b[1]}, {b[2], b[3], c[0]}, {c[1], c[2], c[3]}};
    return p;
}
template <class R>
[[gnu::always_inline]] inline void store(const Particle<Lanes<R>>& p, const Group<R>& group)
{
    static_assert(particle_is_22_words<R>);
    store_words(group, 0, {p.x.x, p.x.y, p.x.z, p.v.x});
    store_words(group, 4, {p.v.y, p.v.z, p.C.a.x, p.C.a.y});
    store_words(group, 8, {p.C.a.z, p.C.b.x, p.C.b.y, p.C.b.z});
    store_words(group, 12, {p.C.c.x, p.C.c.y, p.C.c.z, p.e.xx});
    store_words(group, 16, {p.e.yy, p.e.zz, p.e.xy, p.e.xz});
    store_words(group, 18, {p.e.xy, p.e.xz, p.e.yz, p.k});
}

// Per-lane values as an array, for scalar loops.
template <class R>
struct alignas(vector_bytes) Each {
    R of[Lanes<R>::count];
    Each() = default;
    explicit Each(Lanes<R> a) { std::memcpy(of, &a.v, sizeof of); }
    Lanes<R> lanes() const
    {
        Lanes<R> a;
        std::memcpy(&a.v, of, sizeof of);
        return a;
    }
};

// The stencils of a group, as structure of arrays.
template <class R>
struct Stencils {
    static constexpr int count = Lanes<R>::count;
    Vec3<Each<R>> weight[3], way;  // of node base + k; from the particle to base [m]
    alignas(vector_bytes) int x[count], y[count], z[count];  // base

    Stencils(const Vec3<Lanes<R>>& place, R dx)
    {
        const Each<R> px(place.x), py(place.y), pz(place.z);
        for (int l = 0; l < count; ++l) {
            const Stencil<R> s = stencil(Vec3<R>{px.of[l], py.of[l], pz.of[l]}, dx);
            x[l] = s.base.x, y[l] = s.base.y, z[l] = s.base.z;
            way.x.of[l] = s.d.x, way.y.of[l] = s.d.y, way.z.of[l] = s.d.z;
            UNROLL
            for (int k = 0; k < 3; ++k) {
                weight[k].x.of[l] = s.w[k].x, weight[k].y.of[l] = s.w[k].y;
                weight[k].z.of[l] = s.w[k].z;
            }
        }
    }
    Vec3<Lanes<R>> d() const { return {way.x.lanes(), way.y.lanes(), way.z.lanes()}; }
    Stencil<R> operator[](int l) const
    {
        const auto at = [&](const Vec3<Each<R>>& v) {
            return Vec3<R>{v.x.of[l], v.y.of[l], v.z.of[l]};
        };
        return {{x[l], y[l], z[l]}, {at(weight[0]), at(weight[1]), at(weight[2])}, at(way)};
    }
};

}  // namespace KNEAD_CPU_LEVEL
}  // namespace knead
