// Spheres and points for the tests of distance: every way in which a slab may degenerate, and the
// least distance found without any of the closed forms.
#pragma once
#include <algorithm>
#include <array>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "cuda/contact/medial.h"
#include "tests/solver/samples.h"

namespace knead {

// Three spheres and a point near them.
struct Case {
    std::array<Vec3<double>, 3> c;
    std::array<double, 3> r;
    Vec3<double> p;
};

template <class R>
Shape<R> shape_of(const Case& k, int count = 3, std::array<int, 3> order = {0, 1, 2})
{
    Sphere<R> s[3]{};
    for (int i = 0; i < 3; ++i) {
        const std::size_t from = std::size_t(order[std::size_t(std::min(i, count - 1))]);
        s[i].c = cast<R>(k.c[from]);
        s[i].r = R(k.r[from]);
    }
    return shape(count, s[0], s[1], s[2]);
}

// The case that code in the scalar R sees.
template <class R>
Case rounded(Case k)
{
    for (Vec3<double>& c : k.c) c = cast<double>(cast<R>(c));
    for (double& r : k.r) r = R(r);
    k.p = cast<double>(cast<R>(k.p));
    return k;
}

inline double at(const Case& k, double l1, double l2)
{
    const double l0 = 1 - l1 - l2;
    return length(k.p - (l0 * k.c[0] + l1 * k.c[1] + l2 * k.c[2])) -
           (l0 * k.r[0] + l1 * k.r[1] + l2 * k.r[2]);
}

// Least value of a convex function on [0, 1] by golden section.
template <class F>
double min_of(F&& f)
{
    constexpr double ratio = 0.6180339887498949;
    double low = 0, high = 1, x = 1 - ratio, y = ratio, fx = f(x), fy = f(y);
    for (int i = 0; i < 80; ++i) {
        if (fx < fy) {
            high = y, y = x, fy = fx, x = high - ratio * (high - low), fx = f(x);
        } else {
            low = x, x = y, fx = fy, y = low + ratio * (high - low), fy = f(y);
        }
    }
    return std::min(fx, fy);
}

inline double brute(const Case& k, int count)
{
    double best = at(k, 0, 0);
    if (count > 1)
        best = std::min({best, at(k, 1, 0), min_of([&](double t) { return at(k, t, 0); })});
    if (count < 3) return best;
    best = std::min(best, at(k, 0, 1));
    return std::min(best, min_of([&](double u) {
                        return min_of([&](double w) { return at(k, u * (1 - w), u * w); });
                    }));
}

// How far the point is from the sheet of the centres: there the distance has a crease, and the
// normal jumps from one side to the other.
template <class R>
double above_sheet(const Case& k, const ClosestPoint<R>& f)
{
    return double(f.phi) + double(f.l0) * k.r[0] + double(f.l1) * k.r[1] + double(f.l2) * k.r[2];
}

struct Family {
    std::string name;
    std::function<Case(Draw&)> draw;
};

inline Case generic(Draw& d)
{
    Case k;
    for (Vec3<double>& c : k.c) c = d.vector();
    for (double& r : k.r) r = d.in(0.1, 0.5);
    k.p = d.vector(1.5);
    return k;
}

// Radii that change by the gradient g, so that the spheres have common tangent planes for |g| < 1.
inline void taper(Case& k, Vec3<double> g)
{
    for (std::size_t i = 0; i < 3; ++i) k.r[i] = 1.5 + dot(g, k.c[i] - k.c[0]);
    const double min_radius = std::min({k.r[0], k.r[1], k.r[2]});
    for (double& r : k.r) r += 0.05 - min_radius;
}

inline Vec3<double> on_sheet(const Case& k, Draw& d)
{
    const double a = d.in(0, 1), b = d.in(0, 1 - a);
    return (1 - a - b) * k.c[0] + a * k.c[1] + b * k.c[2];
}

inline Case sliver(Draw& d)
{
    Case k = generic(d);
    const Vec3<double> u = d.direction();
    const double reach = d.in(0.3, 1), along = d.in(-0.5, 1.5) * reach;
    k.c[1] = k.c[0] + reach * u;
    k.c[2] = k.c[0] + along * u + (reach * d.power(-12, 0)) * orthogonal(u);
    taper(k, d.in(0, 0.95) * d.direction());
    if (d.below(2)) std::swap(k.c[0], k.c[2]), std::swap(k.r[0], k.r[2]);
    k.p = on_sheet(k, d) + d.power(-6, 0) * d.direction();
    return k;
}

inline Case collinear(Draw& d)
{
    Case k = generic(d);
    k.c[2] = k.c[0] + d.in(-1, 2) * (k.c[1] - k.c[0]);
    return k;
}

inline Case near_nested(Draw& d)  // the slope of the radius is 1 to between 1e-1 and 1e-13
{
    Case k = generic(d);
    const Vec3<double> N = cross(k.c[1] - k.c[0], k.c[2] - k.c[0]);
    const double area = length(N), angle = d.in(0, 6.3);
    if (area < 0.2) return near_nested(d);
    const Vec3<double> n = (1 / area) * N, t = orthogonal(n);
    const double slope = 1 + (d.below(2) ? -1 : 1) * d.power(-13, -1);
    taper(k, slope * (std::cos(angle) * t + std::sin(angle) * cross(n, t)));
    return k;
}

inline std::vector<Family> families()
{
    const auto with = [](auto change) {
        return [change](Draw& d) {
            Case k = generic(d);
            change(k, d);
            return k;
        };
    };
    return {
        {"generic", generic},
        {"strongly tapered or nested", with([](Case& k, Draw& d) {
             for (double& r : k.r) r = d.in(0.01, 1.5);
         })},
        {"sliver", sliver},
        {"collinear", collinear},
        {"two centres coincide", with([](Case& k, Draw& d) {
             k.c[std::size_t(d.below(2) + 1)] = k.c[0];
             if (d.below(2)) std::swap(k.c[0], k.c[2]), std::swap(k.r[0], k.r[2]);
         })},
        {"all centres coincide", with([](Case& k, Draw&) { k.c[1] = k.c[2] = k.c[0]; })},
        {"one ball contains all", with([](Case& k, Draw& d) {
             k.r[std::size_t(d.below(3))] = 4;
             k.p = d.vector(5);
         })},
        {"tiny radii", with([](Case& k, Draw& d) {
             for (double& r : k.r) r = d.in(0, 1e-3);
         })},
        {"sharp tips", with([](Case& k, Draw& d) { k.r[std::size_t(d.below(3))] = 0; })},
        {"on the sheet", with([](Case& k, Draw& d) { k.p = on_sheet(k, d); })},
        {"at a centre", with([](Case& k, Draw& d) { k.p = k.c[std::size_t(d.below(3))]; })},
        {"hardly a tangent plane", near_nested},
    };
}

}  // namespace knead
