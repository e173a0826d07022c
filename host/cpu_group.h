// A group of particles in the lanes of registers, and the way there and back.
#pragma once
#include <cstddef>

#include "cpu_lanes.h"
#include "cuda/four.h"
#include "cuda/stencil.h"

namespace knead {

// As many particles of one object as there are lanes; where there are fewer, the last one stands in
// the lanes left over.
template <class R>
struct Group {
    static constexpr int count = Lanes<R>::count;
    Particle<R>* of[count];
    int index[count];  // of each in the array of particles
    int size;
};

// From four numbers of each particle, at(lane), to a register for each of the numbers.
template <class R, class At>
[[gnu::always_inline]] inline void load_four(Lanes<R> (&words)[4], At&& at)
{
    const auto in_row = [&](int r) __attribute__((always_inline))
    {
        if constexpr (Lanes<R>::count == 4) {
            return at(r);
        } else {
            const auto low = __builtin_shufflevector(at(r), at(r + 4), 0, 1, 2, 3, 4, 5, 6, 7);
            if constexpr (Lanes<R>::count == 8) {
                return low;
            } else {
                const auto high =
                    __builtin_shufflevector(at(r + 8), at(r + 12), 0, 1, 2, 3, 4, 5, 6, 7);
                return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12,
                                               13, 14, 15);
            }
        }
    };
    UNROLL
    for (int r = 0; r < 4; ++r) words[r] = in_row(r);
    transpose(words[0].v, words[1].v, words[2].v, words[3].v);
}
// And back: to(lane, its four numbers).
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

// A vector of each particle, and a fourth number.
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

// The words of a particle from `word` on, four at a time.
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

// Where the parts of a particle stand among its words.
template <class R>
constexpr bool particle_is_22_words = offsetof(Particle<R>, C) == 6 * sizeof(R) &&
                                      offsetof(Particle<R>, e) == 15 * sizeof(R) &&
                                      offsetof(Particle<R>, k) == 21 * sizeof(R);

// A group's places and strains alone.
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

// A group's stencils, number by number.
template <class R>
struct Stencils {
    using L = Lanes<R>;
    alignas(vector_bytes) R weight[3][3][L::count];  // of node base + k along axis a: [k][a]
    alignas(vector_bytes) int base[3][L::count];
    Vec3<L> d;

    Stencils(const Vec3<L>& place, R dx)
    {
        alignas(vector_bytes) R x[3][L::count], way[3][L::count];
        std::memcpy(x, &place, sizeof x);
        for (int l = 0; l < L::count; ++l) {
            const Stencil<R> s = stencil(Vec3<R>{x[0][l], x[1][l], x[2][l]}, dx);
            base[0][l] = s.base.x, base[1][l] = s.base.y, base[2][l] = s.base.z;
            way[0][l] = s.d.x, way[1][l] = s.d.y, way[2][l] = s.d.z;
            UNROLL
            for (int k = 0; k < 3; ++k) {
                weight[k][0][l] = s.w[k].x, weight[k][1][l] = s.w[k].y;
                weight[k][2][l] = s.w[k].z;
            }
        }
        std::memcpy(&d, way, sizeof d);
    }
    Stencil<R> operator[](int l) const
    {
        const auto w = [&](int k) {
            return Vec3<R>{weight[k][0][l], weight[k][1][l], weight[k][2][l]};
        };
        return {{base[0][l], base[1][l], base[2][l]}, {w(0), w(1), w(2)}, {d.x[l], d.y[l], d.z[l]}};
    }
};

}  // namespace knead
