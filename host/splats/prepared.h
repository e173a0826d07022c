// Shared by both CPU rasterisers: every splat as seen by one eye.
#pragma once
#include "host/splats/raster.h"

namespace knead {

inline Vec3<double> middle_of(const SplatFrame& frame)
{
    Vec3<double> sum{0, 0, 0};
    for (const Eye<float>& e : frame.eyes) sum = sum + cast<double>(e.position);
    return (1 / double(frame.eyes.size())) * sum;
}

template <class R>
Eye<R> cast(const Eye<float>& e)
{
    return {cast<R>(e.position),
            cast<R>(e.rotation),
            R(e.left),
            R(e.right),
            R(e.up),
            R(e.down),
            e.width,
            e.height};
}
template <class R>
SplatOptions<R> cast(const SplatOptions<float>& r)
{
    return {R(r.near), R(r.near_full), r.antialiased};
}

// A splat, posed for a frame.
template <class R>
struct PosedSplat {
    Vec3<R> centre;
    Mat3<R> half_axes;
    Mat3<R> turn;  // rotation of its colours
    bool turned;
};

template <class R>
PosedSplat<R> posed(const SplatCloud& cloud, const SplatFrame& frame, std::size_t i)
{
    const Ellipsoid<R> e{cast<R>(cloud.rotation[i]), cast<R>(cloud.scale[i])};
    PosedSplat<R> s{cast<R>(cloud.centre[i]), half_axes(e), diagonal(R(1)), false};
    if (i >= frame.moved_centre.size()) return s;
    const Mat3<float>& G = frame.moved_F[i];
    const Mat3<R> F{cast<R>(G.a), cast<R>(G.b), cast<R>(G.c)};
    s.centre = cast<R>(frame.moved_centre[i]);
    s.half_axes = F * s.half_axes;
    s.turn = polar_rotation(F), s.turned = true;
    return s;
}

// Colour as seen from `eye`.
template <class R>
Vec3<R> colour_from(Vec3<R> eye, const PosedSplat<R>& s, const SplatCloud& cloud, std::size_t i)
{
    const Vec3<R> ray = s.centre - eye;
    Vec3<R> d = (1 / length(ray)) * ray;
    if (s.turned) d = transpose(s.turn) * d;
    const Vec3<float>* const sh = cloud.sh.data() + i * std::size_t(harmonics(cloud.degree));
    return drawable(sh_colour(cloud.degree, d, [sh](int k) { return cast<R>(sh[k]); }));
}

}  // namespace knead
