#include "host/verify/squeeze.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace knead {
namespace {

constexpr double tool_radius = 0.15, deep = 0.1, speed = 1, rest = 0.05;  // [m] [m/s] [s]

// Particles indexed by their initial cube of edge `edge` [m].
class Cubes {
  public:
    Cubes(const std::vector<Place>& places, double cube) : all(places), edge(cube)
    {
        for (const Place& x : all) reach = std::max({reach, far(x.x), far(x.y), far(x.z)});
        wide = 2 * reach + 1;
        first.assign(std::size_t(wide) * wide * wide + 1, 0);
        for (const Place& x : all) ++first[index(cube_of(x)) + 1];
        for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
        order.resize(all.size());
        std::vector<std::size_t> next(first.begin(), first.end() - 1);
        for (std::size_t i = 0; i < all.size(); ++i) order[next[index(cube_of(all[i]))]++] = i;
    }
    // Calls visit(i, distance) for particles nearer to x than `near`. Precondition: near <= edge.
    template <class Visit>
    void each(Place x, double near, Visit&& visit) const
    {
        for (int k = 0; k < 27; ++k) {
            const Int3 c = cube_of(x) + Int3{k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
            if (std::max({std::abs(c.x), std::abs(c.y), std::abs(c.z)}) > reach) continue;
            for (std::size_t j = first[index(c)]; j < first[index(c) + 1]; ++j)
                if (const double r = length(all[order[j]] - x); r < near) visit(order[j], r);
        }
    }

  private:
    int far(double x) const { return int(std::fabs(x) / edge) + 1; }
    Int3 cube_of(Place x) const
    {
        return {int(std::floor(x.x / edge)), int(std::floor(x.y / edge)),
                int(std::floor(x.z / edge))};
    }
    std::size_t index(Int3 c) const
    {
        return (std::size_t(c.z + reach) * wide + std::size_t(c.y + reach)) * wide +
               std::size_t(c.x + reach);
    }

    const std::vector<Place>& all;
    double edge;
    int reach = 0;
    std::size_t wide = 0;
    std::vector<std::size_t> first, order;
};

::Eigen::Vector3d vector(Place x) { return {x.x, x.y, x.z}; }

// Final position of the initial point X, by a weighted fit to the particles nearer than `near`.
// Empty if they are too few.
std::optional<Place> taken(const Squeezed& s, const Cubes& cubes, Place X, double near)
{
    ::Eigen::Matrix4d A = ::Eigen::Matrix4d::Zero();
    ::Eigen::Matrix<double, 4, 3> b = ::Eigen::Matrix<double, 4, 3>::Zero();
    int count = 0;
    cubes.each(X, near, [&](std::size_t i, double r) {
        const double share = 1 - r * r / (near * near), w = share * share;
        ::Eigen::Vector4d p;
        p << vector((1 / near) * (s.from[i] - X)), 1;
        A += w * p * p.transpose();
        b += w * p * vector(s.to[i] - X).transpose();
        ++count;
    });
    if (count < 8) return {};
    const ::Eigen::FullPivLU<::Eigen::Matrix4d> solved(A);
    if (solved.rcond() < 1e-4) return {};
    const ::Eigen::Matrix<double, 4, 3> fit = solved.solve(b);
    return X + Place{fit(3, 0), fit(3, 1), fit(3, 2)};
}

// Fixed points of the ball, independent of its particles.
std::vector<Place> probes()
{
    constexpr double step = squeeze_radius / 8;
    std::vector<Place> all;
    for (int z = -8; z < 8; ++z)
        for (int y = -8; y < 8; ++y)
            for (int x = -8; x < 8; ++x) {
                const Place p = step * Place{x + 0.5, y + 0.5, z + 0.5};
                if (length(p) < squeeze_radius) all.push_back(p);
            }
    return all;
}

}  // namespace

Squeezed followed(const Verification& v, const SceneOptions& options, Setup s, Place middle,
                  double end, const std::function<std::vector<Joint<double>>(double)>& at)
{
    Squeezed result;
    result.apart = s.lattice.dx / std::cbrt(options.per_cell);
    for (const Particle<double>& q : s.particles) result.from.push_back(q.x - middle);
    const Driven driven = timed_drive(v, options, std::move(s), 1.0 / 60, end, at, no_look);
    result.stats = driven.stats, result.seconds = driven.seconds, result.inside = driven.inside;
    for (const Particle<double>& q : by_id(*driven.solver)) result.to.push_back(q.x - middle);
    result.at = carried(result);
    return result;
}

BallOfClay ball_of_clay(const SceneOptions& options, double friction)
{
    Setup s = between_walls({options.cells, options.cells, options.cells}, 1.0 / options.cells,
                            ContactMode::separate, friction);
    const Place middle = s.walls.min + Place{0.5, 0.5, 0.5};
    fill_by(s, options, plastic(1e5, 0.3, 1000, 1e4), s.walls.min, s.walls.max,
            [&](Place x) { return squeeze_radius - length(x - middle); });
    return {std::move(s), middle};
}

Squeezed squeezed(const Verification& v, const SceneOptions& options)
{
    auto [s, middle] = ball_of_clay(options, 0.3);
    for (int i = 0; i < 2; ++i) add_ball_tool(s, tool_radius, ContactMode::separate, 0.4);
    const auto at = [middle = middle](double t) {
        const double x = squeeze_radius + tool_radius - std::min(speed * t, deep);
        return std::vector{stands_at(middle + Place{-x, 0, 0}), stands_at(middle + Place{x, 0, 0})};
    };
    return followed(v, options, std::move(s), middle, deep / speed + rest, at);
}

Sym3<double> gyration(const std::vector<Place>& places)
{
    Place mean{};
    Sym3<double> sum{};
    const double share = 1.0 / double(places.size());
    for (const Place& x : places) mean = mean + share * x;
    for (const Place& x : places) sum = sum + share * symmetric(outer(x - mean, x - mean));
    return sum;
}

std::vector<Place> carried(const Squeezed& s)
{
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    const double far = 2.6 * s.apart;  // contains 8 particles even at a stepped face
    const Cubes cubes(s.from, far);
    std::vector<Place> all;
    for (const Place& X : probes()) {
        std::optional<Place> x;
        for (const double near : {1.7 * s.apart, 2.1 * s.apart, far})
            if (!x) x = taken(s, cubes, X, near);
        all.push_back(x.value_or(Place{none, none, none}));
    }
    return all;
}

Apart apart(const std::vector<Place>& coarse, const std::vector<Place>& fine)
{
    std::vector<::Eigen::Vector3d> a, b;
    for (std::size_t i = 0; i < coarse.size(); ++i)
        if (std::isfinite(coarse[i].x + fine[i].x))
            a.push_back(vector(coarse[i])), b.push_back(vector(fine[i]));
    Apart result;
    result.matched = a.size();
    if (a.empty()) return result;
    ::Eigen::Vector3d mean_a = ::Eigen::Vector3d::Zero(), mean_b = mean_a;
    for (std::size_t i = 0; i < a.size(); ++i) mean_a += a[i], mean_b += b[i];
    mean_a /= double(a.size()), mean_b /= double(a.size());
    ::Eigen::Matrix3d H = ::Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < a.size(); ++i) H += (a[i] - mean_a) * (b[i] - mean_b).transpose();
    const ::Eigen::JacobiSVD<::Eigen::Matrix3d> svd(H,
                                                    ::Eigen::ComputeFullU | ::Eigen::ComputeFullV);
    ::Eigen::Vector3d sign(1, 1, (svd.matrixV() * svd.matrixU().transpose()).determinant());
    const ::Eigen::Matrix3d R =
        svd.matrixV() * sign.asDiagonal() * svd.matrixU().transpose();  // [Kabsch 1976]
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += (R * (a[i] - mean_a) - (b[i] - mean_b)).squaredNorm();
    result.rms = std::sqrt(sum / double(a.size()));
    result.shift = (mean_b - mean_a).norm();
    result.turn = std::acos(std::clamp((R.trace() - 1) / 2, -1.0, 1.0));
    return result;
}

// Coarser cells compared with the finest.
void squeeze_part(Verification& v)
{
    const std::vector<int> sizes = v.quick() ? std::vector{16, 24, 48} : std::vector{16, 32, 64};
    std::vector<Squeezed> all;
    all.reserve(sizes.size());
    for (const int n : sizes) all.push_back(squeezed(v, {n}));
    // Relative to the ball's initial moments, which vary slightly with the particle positions.
    const auto shape = [](const Squeezed& s) {
        return (1 / trace(gyration(s.from))) * gyration(s.to);
    };
    const auto shape_distance = [&](const Squeezed& s) {
        const Sym3<double> best = shape(all.back());
        return std::sqrt(norm_squared(shape(s) + -1.0 * best) / norm_squared(best));
    };
    const std::string advice = "finer cells do not give a better shape here: keep the coarser ones";
    const Apart coarse = apart(all[0].at, all[2].at), middle = apart(all[1].at, all[2].at);
    const std::string names = fmt::format(
        "squeeze, {} against {} cells per m, finest {}: ", sizes[1], sizes[0], sizes[2]);
    const auto ratio = [&](const char* what, double fine, double rough, const char* unit) {
        Check c = at_most(names + what, fine / rough, 0.7, "", advice);
        c.note = fmt::format("{:.3g} and {:.3g}{}", fine, rough, unit);
        v.add(c);
    };
    ratio("moments", shape_distance(all[1]), shape_distance(all[0]), "");
    ratio("places", 1e3 * middle.rms, 1e3 * coarse.rms, " mm");
    v.add(at_most("squeeze: rigid shift against the finest, over dx",
                  std::max(coarse.shift * sizes[0], middle.shift * sizes[1]), 0.05, "", advice));
    v.add(at_most("squeeze: rigid turn against the finest",
                  std::max(coarse.turn, middle.turn) * 180 / M_PI, 0.5, "degrees", advice));
    v.add(at_most("squeeze: nodes clipped, clay put back, at all sizes",
                  double(all[0].stats[Count::clipped] + all[1].stats[Count::clipped] +
                         all[2].stats[Count::clipped] + all[0].stats[Count::repaired] +
                         all[1].stats[Count::repaired] + all[2].stats[Count::repaired]),
                  0, "", "shorten the substep"));
    release_checks(v);
}

}  // namespace knead
