#include "host/splats/coverage.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "host/splats/prepared.h"

namespace knead {
namespace {

struct Point {
    double u, v, depth;
};

Point seen_at(const Pinhole<double>& eye, Vec3<float> x)
{
    const Vec3<double> p = eye.to_eye * (cast<double>(x) - eye.position);
    return {eye.fx * p.x / p.z + eye.cx, eye.fy * p.y / p.z + eye.cy, p.z};
}

void fill_triangle(const Point* p, const Eye<float>& eye, std::vector<float>& nearest)
{
    const auto area = [](const Point& a, const Point& b, double u, double v) {
        return (b.u - a.u) * (v - a.v) - (b.v - a.v) * (u - a.u);
    };
    const auto range = [](double a, double b, double c, int count) {
        const double low = std::min({a, b, c}), high = std::max({a, b, c});
        return std::pair{int(clamp(std::ceil(low), 0.0, double(count))),
                         int(clamp(std::floor(high), -1.0, double(count - 1)))};
    };
    const auto [left, right] = range(p[0].u, p[1].u, p[2].u, eye.width);
    const auto [top, bottom] = range(p[0].v, p[1].v, p[2].v, eye.height);
    for (int v = top; v <= bottom; ++v)
        for (int u = left; u <= right; ++u) {
            const double a = area(p[0], p[1], u, v), b = area(p[1], p[2], u, v),
                         c = area(p[2], p[0], u, v);
            if (!(a >= 0 && b >= 0 && c >= 0) && !(a <= 0 && b <= 0 && c <= 0)) continue;
            // 1 / depth is linear on the screen.
            const double whole = a + b + c;
            if (whole == 0) continue;
            const double z = whole / (b / p[0].depth + c / p[1].depth + a / p[2].depth);
            float& to = nearest[std::size_t(v) * std::size_t(eye.width) + std::size_t(u)];
            to = min(to, float(z));
        }
}

// Erosion: a pixel is kept only if its four neighbours are covered, too.
std::vector<char> without_rim(const std::vector<char>& mask, int width, int height)
{
    std::vector<char> out(mask.size(), 0);
    const auto at = [&](int u, int v) {
        return mask[std::size_t(v) * std::size_t(width) + std::size_t(u)];
    };
    for (int v = 1; v + 1 < height; ++v)
        for (int u = 1; u + 1 < width; ++u)
            out[std::size_t(v) * std::size_t(width) + std::size_t(u)] =
                at(u, v) && at(u - 1, v) && at(u + 1, v) && at(u, v - 1) && at(u, v + 1);
    return out;
}

// Counts the pixels of the hole that contains `first`, and clears them.
std::size_t hole(std::vector<char>& open, std::size_t first, int width)
{
    std::vector<std::size_t> front{first};
    const auto w = std::size_t(width);
    std::size_t count = 0;
    open[first] = 0;
    while (!front.empty()) {
        const std::size_t i = front.back();
        front.pop_back(), ++count;
        const auto visit = [&](bool there, std::size_t n) {
            if (there && open[n]) open[n] = 0, front.push_back(n);
        };
        visit(i % w > 0, i - 1), visit(i % w + 1 < w, i + 1);
        visit(i >= w, i - w), visit(i + w < open.size(), i + w);
    }
    return count;
}

}  // namespace

std::vector<float> mesh_depths(const Eye<float>& eye, const std::vector<Vec3<float>>& vertices,
                               const std::vector<Int3>& triangles, double near)
{
    std::vector<float> nearest(std::size_t(eye.width) * std::size_t(eye.height), float(no_depth));
    std::vector<Point> seen;
    seen.reserve(vertices.size());
    const Pinhole<double> from = pinhole(cast<double>(eye));
    for (const Vec3<float>& x : vertices) seen.push_back(seen_at(from, x));
    for (const Int3& t : triangles) {
        const Point p[3] = {seen[std::size_t(t.x)], seen[std::size_t(t.y)], seen[std::size_t(t.z)]};
        if (std::min({p[0].depth, p[1].depth, p[2].depth}) > near) fill_triangle(p, eye, nearest);
    }
    return nearest;
}

Coverage coverage(const Picture& picture, const std::vector<float>& mesh, int rim, double least,
                  double slack)
{
    if (mesh.size() != picture.pixels())
        throw std::invalid_argument("a mesh's depths of another size than their picture");
    std::vector<char> inside;
    inside.reserve(mesh.size());
    for (const float depth : mesh) inside.push_back(depth < no_depth);
    for (int k = 0; k < rim; ++k) inside = without_rim(inside, picture.width, picture.height);
    Coverage c;
    std::vector<char> open(inside.size(), 0);
    double sum = 0;
    for (std::size_t i = 0; i < inside.size(); ++i) {
        if (!inside[i]) continue;
        const auto alpha = double(picture.alpha[i]);
        ++c.pixels, sum += alpha;
        c.least_alpha = min(c.least_alpha, alpha);
        const bool behind = double(picture.depth[i]) > double(mesh[i]) + slack;
        if (alpha < least || behind) open[i] = 1, ++c.open;
    }
    if (c.pixels) c.mean_alpha = sum / double(c.pixels);
    for (std::size_t i = 0; i < open.size(); ++i)
        if (open[i]) c.largest = std::max(c.largest, hole(open, i, picture.width));
    return c;
}

}  // namespace knead
