// The projection of a splat to the screen of one eye, to first order a 2D Gaussian; its visibility
// and depth. [Zwicker 2001] [Kerbl 2023]
#pragma once
#include "cuda/math/fast.h"
#include "cuda/splats/eye.h"
#include "cuda/splats/gaussian.h"

namespace knead {

// How splats are drawn; lengths in metres.
template <class R>
struct SplatOptions {
    R near = R(0.03);          // depth at which opacity has faded to 0
    R near_full = R(0.08);     // depth from which on opacity is full
    bool antialiased = false;  // compensates opacity for the screen filter: SplatCloud::antialiased
};

constexpr double min_alpha = 1.0 / 255;  // less is not drawn
constexpr double max_alpha = 0.99;       // of one splat
constexpr double log2_min_alpha = -7.99435343685886;
constexpr double log2_max_alpha = -0.01449956969511509;
constexpr double screen_variance = 0.3;  // of the screen-space filter [pixels^2]
constexpr double tangent_margin = 1.3;   // factor on the tangents to clamp slopes

// log2 of alpha at (u + dx, v + dy) is peak - (a dx^2 + b dx dy + c dy^2).
template <class R>
struct Footprint {
    R u, v;                     // centre [pixels]
    R a, b, c, peak;            // peak: log2 of the opacity
    R depth, gx, gy;            // of the splat at (u + dx, v + dy): depth + gx dx + gy dy [m]
    R half_width, half_height;  // of the bounding box of alpha >= min_alpha [pixels]
};

// The half axes of a splat as columns: Sigma = L L^T. For a deformed splat, F times these.
template <class R>
HD Mat3<R> half_axes(const Ellipsoid<R>& e)
{
    const Mat3<R> Q = rotation(e.q);
    return {e.scale.x * Q.a, e.scale.y * Q.b, e.scale.z * Q.c};
}

// The rotation R of F = R S, S symmetric: the nearest to F in the least-squares sense. If F is
// mirrored or flattened, its smallest stretch is negated or replaced, so that R is no reflection.
template <class R>
HD Mat3<R> polar_rotation(const Mat3<R>& F)
{
    const Eigen<R> e = eigen(symmetric(transpose(F) * F));
    // Right-handed axes with the least stretch last.
    Vec3<R> p = e.axes.a, q = e.axes.b;
    if (e.value.x <= min(e.value.y, e.value.z))
        p = e.axes.c;
    else if (e.value.y <= e.value.z)
        q = e.axes.c;
    const auto unit_or = [](Vec3<R> u, Vec3<R> otherwise) {
        const R n = length(u);
        return n > R(1e-18) ? (1 / n) * u : otherwise;
    };
    const Vec3<R> Fp = F * p, Fq = F * q;
    const bool p_longer = dot(Fp, Fp) >= dot(Fq, Fq);
    const Vec3<R> first = unit_or(p_longer ? Fp : Fq, p_longer ? p : q);
    const Vec3<R> other = p_longer ? Fq : Fp;
    const Vec3<R> second = unit_or(other - dot(other, first) * first, orthogonal(first));
    const Vec3<R> u = p_longer ? first : second, v = p_longer ? second : first;
    return outer(u, p) + outer(v, q) + outer(cross(u, v), cross(p, q));
}

// Clamps a colour for display: not below 0; black if not finite or extremely large.
template <class R>
HD Vec3<R> drawable(Vec3<R> colour)
{
    const auto one = [](R c) { return c >= 0 && c < R(1e4) ? c : R(0); };
    return {one(colour.x), one(colour.y), one(colour.z)};
}

// Opacity factor near the eye: 0 at `near`, 1 from `near_full` on, smooth between.
template <class R>
HD R near_fade(R depth, const SplatOptions<R>& options)
{
    if (depth >= options.near_full) return 1;
    const R s = clamp((depth - options.near) / (options.near_full - options.near), R(0), R(1));
    return s * s * (3 - 2 * s);
}

// Whether the ellipsoid with centre t and half axes whose rows are x, y and z in the eye's axes,
// scaled by k, lies outside one of the four sides. `margin`: the tangent that the screen filter
// adds. Linear projection would smear large splats that lie there into the view.
template <class R>
HD bool outside_sides(const Pinhole<R>& eye, Vec3<R> t, Vec3<R> x, Vec3<R> y, Vec3<R> z, R k)
{
    const R beyond_x = max(t.x - eye.right * t.z, eye.left * t.z - t.x);
    const R beyond_y = max(t.y - eye.down * t.z, eye.up * t.z - t.y);
    if (!(beyond_x > 0) && !(beyond_y > 0)) return false;
    const R side_x = t.x > eye.right * t.z ? eye.right : eye.left;
    const R side_y = t.y > eye.down * t.z ? eye.down : eye.up;
    const R margin_x = 2 * t.z / eye.fx, margin_y = 2 * t.z / eye.fy;
    return beyond_x > k * length(x - side_x * z) + margin_x ||
           beyond_y > k * length(y - side_y * z) + margin_y;
}

// The footprint of a splat of centre x and half axes L. Returns false if it is not visible: too
// near, behind, outside the view, too faint, or with values that are not finite or too large.
template <class R>
HD bool project(const Pinhole<R>& eye, const SplatOptions<R>& options, Vec3<R> centre,
                const Mat3<R>& L, R opacity, Footprint<R>& f)
{
    const Vec3<R> t = eye.to_eye * (centre - eye.position);
    if (!(t.z > options.near) || !(opacity > 0)) return false;
    const Mat3<R> rows = transpose(eye.to_eye * L);  // columns: x, y and z of the three half axes
    opacity = min(opacity, R(1)) * near_fade(t.z, options);

    // Sigma = M M^T with the rows m and n of M = J rows^T; the slopes in J are clamped slightly
    // outside of the view, where a first-order projection is invalid.
    const R by_z = 1 / t.z;
    const R over_x = R(0.5 * (tangent_margin - 1)) * (eye.right - eye.left);
    const R over_y = R(0.5 * (tangent_margin - 1)) * (eye.down - eye.up);
    const R sx = clamp(t.x * by_z, eye.left - over_x, eye.right + over_x);
    const R sy = clamp(t.y * by_z, eye.up - over_y, eye.down + over_y);
    const Vec3<R> m = (eye.fx * by_z) * (rows.a - sx * rows.c);
    const Vec3<R> n = (eye.fy * by_z) * (rows.b - sy * rows.c);
    const R h = R(screen_variance), mm = dot(m, m), nn = dot(n, n), mn = dot(m, n);
    if (!(mm + nn < R(1e16))) return false;
    // By the cross product: for a long, thin splat mm nn - mn^2 would be rounding error.
    const Vec3<R> area = cross(m, n);
    const R sharp = dot(area, area), det = sharp + h * (mm + nn) + h * h;
    if (options.antialiased) opacity = opacity * std::sqrt(sharp / det);
    if (!(opacity >= R(min_alpha))) return false;

    f.peak = std::log2(opacity);
    const R reach = f.peak - R(log2_min_alpha);  // of a dx^2 + b dx dy + c dy^2
    const R half_log2_e = R(0.7213475204444817), k = reach / half_log2_e;  // squared, in sigmas
    if (outside_sides(eye, t, rows.a, rows.b, rows.c, std::sqrt(k))) return false;
    f.u = eye.fx * t.x * by_z + eye.cx;
    f.v = eye.fy * t.y * by_z + eye.cy;
    f.half_width = std::sqrt(k * (mm + h));
    f.half_height = std::sqrt(k * (nn + h));
    if (!(f.u + f.half_width >= 0 && f.u - f.half_width <= R(eye.width - 1) &&
          f.v + f.half_height >= 0 && f.v - f.half_height <= R(eye.height - 1)))
        return false;
    const R by_det = 1 / det, xx = (nn + h) * by_det, yy = (mm + h) * by_det, xy = -mn * by_det;
    f.a = half_log2_e * xx, f.b = 2 * half_log2_e * xy, f.c = half_log2_e * yy;
    // The mean depth along a line of sight is linear in the pixel: cov(z, uv) Sigma^-1.
    const R zm = dot(rows.c, m), zn = dot(rows.c, n);
    f.depth = t.z, f.gx = zm * xx + zn * xy, f.gy = zm * xy + zn * yy;
    return true;
}

// The minimum of a dx^2 + b dx dy + c dy^2 over pixels [x0, x1] x [y0, y1]: 0 if the centre is
// inside; else on one of the sides that face the centre.
template <class R>
HD R least_fall(R u, R v, R a, R b, R c, R x0, R y0, R x1, R y1)
{
    const R dx = fast_clamp(u, x0, x1) - u, dy = fast_clamp(v, y0, y1) - v;
    const R y = fast_clamp(fast_divide(-b * dx, 2 * c), y0 - v, y1 - v);
    const R x = fast_clamp(fast_divide(-b * dy, 2 * a), x0 - u, x1 - u);
    const R on_x = fast_fma(c * y, y, dx * fast_fma(b, y, a * dx));
    const R on_y = fast_fma(c * dy, dy, x * fast_fma(a, x, b * dy));
    return dx == 0 ? on_y : dy == 0 ? on_x : min(on_x, on_y);
}

// Whether alpha is at least min_alpha anywhere between pixels (x0, y0) and (x1, y1).
template <class R>
HD bool reaches(const Footprint<R>& f, R x0, R y0, R x1, R y1)
{
    return f.peak - least_fall(f.u, f.v, f.a, f.b, f.c, x0, y0, x1, y1) >= R(log2_min_alpha);
}

}  // namespace knead
