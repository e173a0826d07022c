#include "host/assets/refine.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace knead {

std::vector<Shape<double>> shapes(const Spheres& s, const std::vector<Primitive>& primitives)
{
    std::vector<Shape<double>> out;
    out.reserve(primitives.size());
    for (const Primitive& q : primitives)
        out.push_back(shape(q.count, s[q.sphere[0]], s[q.sphere[1]], s[q.sphere[2]]));
    return out;
}

Hold nearest(const std::vector<Shape<double>>& all, Vec3<double> p)
{
    Hold best{{1e30, {0, 1, 0}, 1, 0, 0}, 0};
    for (std::size_t i = 0; i < all.size(); ++i) {
        const ClosestPoint<double> f = closest_point(all[i], p);
        if (f.phi < best.closest_point.phi) best = {f, int(i)};
    }
    return best;
}

namespace {

constexpr int max_rounds = 60;
constexpr double little = 1e-6;       // relative decrease of the cost at which iteration ends
constexpr double radius_freedom = 5;  // a radius is pulled less than a centre by this factor

// The spheres in the pose of a view.
Spheres seen(const Spheres& s, const FitView& view)
{
    Spheres out = s;
    for (std::size_t i = 0; i < view.carries.size(); ++i)
        out[i].c = view.carries[i].turn * s[i].c + view.carries[i].shift;
    return out;
}

// The cost of a fit, with its negative gradient and Gauss-Newton matrix over centres and radii.
struct Cost {
    double value;
    ::Eigen::MatrixXd curvature;
    ::Eigen::VectorXd descent;
};

// Adds the distance at one point of a view. By the envelope theorem d(phi)/d(centre) = -share n and
// d(phi)/d(radius) = -share, where share is the weight of the sphere at that point.
void add(Cost& cost, const Hold& h, const Primitive& q, const FitView& view, double outlier)
{
    const double phi = h.closest_point.phi, far = outlier > 0 ? std::pow(phi / outlier, 4) : 0;
    const auto slope = [&](int i) {
        const auto& n = h.closest_point.n;
        const Vec3<double> g =
            view.carries.empty() ? n : transpose(view.carries[std::size_t(i)].turn) * n;
        return ::Eigen::Vector4d(-g.x, -g.y, -g.z, -1);
    };
    cost.value += phi * phi * (0.5 + far / 6);
    for_each_share(q, h.closest_point, [&](int i, double li) {
        const ::Eigen::Vector4d gi = li * slope(i);
        cost.descent.segment<4>(4 * i) -= (1 + far) * phi * gi;
        for_each_share(q, h.closest_point, [&](int j, double lj) {
            cost.curvature.block<4, 4>(4 * i, 4 * j) +=
                (1 + 5 * far) * lj * gi * slope(j).transpose();
        });
    });
}

Cost cost_of(const Spheres& s, const Spheres& start, const std::vector<Primitive>& primitives,
             const std::vector<FitView>& views, const FitOptions& options)
{
    const int n = int(s.size());
    Cost cost{0, ::Eigen::MatrixXd::Zero(4 * n, 4 * n), ::Eigen::VectorXd::Zero(4 * n)};
    double points = 0;
    for (const FitView& view : views) {
        const auto all = shapes(seen(s, view), primitives);
        for (const SkinPoint& point : view.points) {
            const Hold h = nearest(all, point.p);
            add(cost, h, primitives[std::size_t(h.primitive)], view, options.outlier);
        }
        points += double(view.points.size());
    }
    const double pull = options.pull * points / n;
    const ::Eigen::Vector4d pulls(pull, pull, pull, pull / radius_freedom);
    for (int i = 0; i < n; ++i) {
        const Vec3<double> back = start[i].c - s[i].c;
        const ::Eigen::Vector4d away(back.x, back.y, back.z, start[i].r - s[i].r);
        cost.value += away.dot(pulls.cwiseProduct(away)) / 2;
        cost.curvature.diagonal().segment<4>(4 * i) += pulls;
        cost.descent.segment<4>(4 * i) += pulls.cwiseProduct(away);
    }
    return cost;
}

Spheres moved(const Spheres& s, const ::Eigen::VectorXd& step)
{
    Spheres out = s;
    for (int i = 0; i < int(s.size()); ++i) {
        out[i].c = s[i].c + Vec3<double>{step[4 * i], step[4 * i + 1], step[4 * i + 2]};
        out[i].r = std::max(smallest_radius, s[i].r + step[4 * i + 3]);
    }
    return out;
}

}  // namespace

void refine(Spheres& s, const Spheres& start, const std::vector<Primitive>& primitives,
            const std::vector<FitView>& views, const FitOptions& options)
{
    Cost cost = cost_of(s, start, primitives, views, options);
    const double unit_damping = cost.curvature.trace() / double(cost.descent.size());
    double damping = 1e-3;
    for (int round = 0; round < max_rounds && damping < 1e6; ++round) {
        ::Eigen::MatrixXd damped = cost.curvature;
        damped.diagonal().array() += damping * unit_damping;
        const Spheres next = moved(s, damped.ldlt().solve(cost.descent));
        const Cost then = cost_of(next, start, primitives, views, options);
        damping *= then.value < cost.value ? 0.25 : 4;
        if (!(then.value < cost.value)) continue;
        const bool last = cost.value - then.value < little * cost.value;
        s = next, cost = then;
        if (last) break;
    }
}

}  // namespace knead
