#include "host/splats/split.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "cuda/splats/footprint.h"
#include "host/base/parallel.h"

namespace knead {
namespace {

Ellipsoid<double> rest_shape(const SplatCloud& c, std::size_t i)
{
    return {cast<double>(c.rotation[i]), cast<double>(c.scale[i])};
}

// The unit vector that F L stretches most, in the frame in which the splat is a unit sphere, and
// its length after stretching [m].
struct Longest {
    Vec3<double> from;
    double length;
};
Longest longest_axis(const Mat3<double>& M)
{
    const Eigen<double> e = eigen(symmetric(transpose(M) * M));
    const double v[3] = {e.value.x, e.value.y, e.value.z};
    const std::size_t most = v[0] >= v[1] ? (v[0] >= v[2] ? 0 : 2) : (v[1] >= v[2] ? 1 : 2);
    const Vec3<double> axes[3] = {e.axes.a, e.axes.b, e.axes.c};
    return {axes[most], std::sqrt(max(v[most], 0.0))};
}

struct Candidate {
    double beyond;  // length of the splat / its extent
    std::uint32_t index;
};

// The splats to split, with how far they are stretched.
std::vector<Candidate> candidates(const CarriedSplats& splats,
                                  const std::vector<Gaussian<double>>& gaussians,
                                  const SplitOptions& options)
{
    const int count = int(gaussians.size());
    std::vector<float> beyond(gaussians.size(), 0);
    parallel_for(count, [&](int k) {
        const auto i = std::size_t(k);
        const Mat3<double> M = gaussians[i].F * half_axes(rest_shape(splats.cloud, i));
        const double s = longest_axis(M).length, rest = double(splats.extent[i]);
        if (s > options.limit * rest && s > options.smallest && rest > 0 && std::isfinite(s))
            beyond[i] = float(s / rest);
    });
    std::vector<Candidate> all;
    for (std::size_t i = 0; i < beyond.size(); ++i)
        if (beyond[i] > 0) all.push_back({double(beyond[i]), std::uint32_t(i)});
    return all;
}

GaussianSplit split_one(CarriedSplats& splats, std::vector<Gaussian<double>>& gaussians,
                        std::size_t i, const WallOptions& walls)
{
    SplatCloud& c = splats.cloud;
    const Mat3<double> L = half_axes(rest_shape(c, i)), M = gaussians[i].F * L;
    const Vec3<double> u = longest_axis(M).from;
    // L with the axis u of the unit sphere shortened: its covariance is reduced by the covariance
    // of the centres.
    const Vec3<double> Lu = L * u;
    const auto column = [&](Vec3<double> l, double along) {
        return l - ((1 - std::sqrt(pair_variance)) * along) * Lu;
    };
    const Mat3<double> shorter{column(L.a, u.x), column(L.b, u.y), column(L.c, u.z)};
    const Ellipsoid<double> shape = ellipsoid(symmetric(shorter * transpose(shorter)));
    const double apart = std::sqrt(1 - pair_variance);
    const Vec3<double> now = apart * (M * u), rest = apart * Lu;
    const Vec3<double> at_rest = cast<double>(c.centre[i]);

    c.rotation[i] = cast<float>(shape.q), c.scale[i] = cast<float>(shape.scale);
    c.opacity[i] = float(pair_opacity(double(c.opacity[i])));
    c.centre[i] = cast<float>(at_rest - rest);
    append(splats, cast<float>(at_rest + rest), {c.rotation[i], c.scale[i]}, c.opacity[i],
           c.sh.data() + i * std::size_t(harmonics(c.degree)), splats.extent[i]);
    gaussians.push_back(split(gaussians[i], now, walls));
    return {int(i), now};
}

}  // namespace

double summed_depth(double x)
{
    x = clamp(x, 0.0, 1.0);
    if (x > 0.5) {  // reflection formula, where the series converges slowly
        const double mixed = x < 1 ? std::log(x) * std::log(1 - x) : 0;
        return std::numbers::pi * std::numbers::pi / 6 - mixed - summed_depth(1 - x);
    }
    double sum = 0, power = x;
    for (int k = 1; k < 60; ++k, power *= x) sum += power / (double(k) * k);
    return sum;
}

double pair_opacity(double opacity)
{
    const double wanted = summed_depth(opacity) / (2 * std::sqrt(pair_variance));
    double low = 0, high = clamp(opacity, 0.0, 1.0);
    for (int k = 0; k < 40; ++k) {
        const double middle = (low + high) / 2;
        (summed_depth(middle) < wanted ? low : high) = middle;
    }
    return (low + high) / 2;
}

SplitReport split(CarriedSplats& splats, std::vector<Gaussian<double>>& gaussians,
                  const SplitOptions& options, const WallOptions& walls)
{
    if (splats.count() != gaussians.size() || splats.extent.size() != gaussians.size())
        throw std::invalid_argument("split: one splat for each Gaussian is needed");
    std::vector<Candidate> all = candidates(splats, gaussians, options);
    std::stable_sort(all.begin(), all.end(),
                     [](const Candidate& a, const Candidate& b) { return a.beyond > b.beyond; });
    const std::size_t room =
        options.capacity > gaussians.size() ? options.capacity - gaussians.size() : 0;
    const std::size_t count = std::min({all.size(), options.budget, room});
    SplitReport report{{}, all.size() - count};
    for (std::size_t k = 0; k < count; ++k)
        report.splits.push_back(split_one(splats, gaussians, all[k].index, walls));
    return report;
}

}  // namespace knead
