// A node of the lattice: momentum and mass, also as four packed numbers: a vector register on the
// CPU, four plain registers on the GPU.
#pragma once
#include <cstring>

#include "cuda/math/vec.h"

namespace knead {

// One lattice node: momentum and mass; after the grid update velocity and mass.
template <class R>
struct Node {
    Vec3<R> p;  // momentum [kg m/s], then velocity [m/s]
    R m;        // mass [kg]
};

template <class R>
struct Four;

#if VECTOR_EXTENSION
template <>
struct Four<float> {
    typedef float V __attribute__((vector_size(16)));
    V v;
};
template <>
struct Four<double> {
    typedef double V __attribute__((vector_size(32)));
    V v;
};
template <class R>
HD Four<R> operator+(Four<R> a, Four<R> b)
{
    return {a.v + b.v};
}
template <class R>
HD Four<R> operator-(Four<R> a, Four<R> b)
{
    return {a.v - b.v};
}
template <class R>
HD Four<R> operator*(R s, Four<R> a)
{
    return {s * a.v};
}
// a with s times d added to its first three numbers
template <class R>
HD Four<R> slid(Four<R> a, R s, Vec3<R> d)
{
    return {a.v + s * typename Four<R>::V{d.x, d.y, d.z, 0}};
}
template <class R>
HD Four<R> four(Vec3<R> u, R w)
{
    return {typename Four<R>::V{u.x, u.y, u.z, w}};
}
template <class R>
HD Vec3<R> first_three(Four<R> a)
{
    return {a.v[0], a.v[1], a.v[2]};
}
template <class R>
HD R last(Four<R> a)
{
    return a.v[3];
}
#else
template <class R>
struct Four {
    R x, y, z, w;
};
template <class R>
HD Four<R> operator+(Four<R> a, Four<R> b)
{
    return {a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w};
}
template <class R>
HD Four<R> operator-(Four<R> a, Four<R> b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z, a.w - b.w};
}
template <class R>
HD Four<R> operator*(R s, Four<R> a)
{
    return {s * a.x, s * a.y, s * a.z, s * a.w};
}
template <class R>
HD Four<R> slid(Four<R> a, R s, Vec3<R> d)
{
    return {a.x + s * d.x, a.y + s * d.y, a.z + s * d.z, a.w};
}
template <class R>
HD Four<R> four(Vec3<R> u, R w)
{
    return {u.x, u.y, u.z, w};
}
template <class R>
HD Vec3<R> first_three(Four<R> a)
{
    return {a.x, a.y, a.z};
}
template <class R>
HD R last(Four<R> a)
{
    return a.w;
}
#endif

template <class R>
HD Vec3<R> first_three(Vec3<R> a)
{
    return a;
}
template <class R>
HD Four<R> four(const Node<R>& n)
{
    Four<R> f;
    static_assert(sizeof f == sizeof n);
    std::memcpy(&f, &n, sizeof f);
    return f;
}
template <class R>
HD Node<R> node(Four<R> f)
{
    Node<R> n;
    std::memcpy(&n, &f, sizeof n);
    return n;
}

}  // namespace knead
