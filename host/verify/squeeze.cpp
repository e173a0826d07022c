#include "host/verify/squeeze.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "host/base/machine.h"

namespace knead {
namespace {

constexpr double tool_radius = 0.15, deep = 0.1, speed = 1, rest = 0.05;  // [m] [m/s] [s]

// Which particle began in which cube of edge `apart` about the middle.
using Index = std::array<int, 3>;
std::map<Index, std::size_t> numbered(const Squeezed& s)
{
    std::map<Index, std::size_t> all;
    for (std::size_t i = 0; i < s.from.size(); ++i) {
        const Place x = (1 / s.apart) * s.from[i];
        all[{int(std::floor(x.x)), int(std::floor(x.y)), int(std::floor(x.z))}] = i;
    }
    return all;
}

// Where `s` took the place X: by the eight particles around it; at the surface, where some are
// missing, by the nearest eight inwards, continued linearly.
std::optional<Place> taken(const Squeezed& s, const std::map<Index, std::size_t>& at, Place X)
{
    const Place x = (1 / s.apart) * X - Place{0.5, 0.5, 0.5};
    Place low{std::floor(x.x), std::floor(x.y), std::floor(x.z)};
    for (int inwards = 0; inwards < 3; ++inwards) {
        const Index base{int(low.x), int(low.y), int(low.z)};
        const Place f = x - low;
        Place sum{};
        bool whole = true;
        for (int k = 0; k < 8 && whole; ++k) {
            const auto found =
                at.find({base[0] + (k & 1), base[1] + (k >> 1 & 1), base[2] + (k >> 2)});
            whole = found != at.end();
            if (!whole) break;
            const double w =
                (k & 1 ? f.x : 1 - f.x) * (k >> 1 & 1 ? f.y : 1 - f.y) * (k >> 2 ? f.z : 1 - f.z);
            sum = sum + w * s.to[found->second];
        }
        if (whole) return sum;
        const auto inward = [](double& a, double from) {
            if (std::fabs(a + 0.5) > 0.6 * from) a += a < -0.5 ? 1 : -1;
        };
        const double far = std::max({std::fabs(low.x), std::fabs(low.y), std::fabs(low.z)});
        inward(low.x, far), inward(low.y, far), inward(low.z, far);
    }
    return {};
}

// The same places of the ball for all, whatever particles they have.
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

::Eigen::Vector3d vector(Place x) { return {x.x, x.y, x.z}; }

}  // namespace

Squeezed followed(const Verification& v, const SqueezeRule& rule, Setup s, Place middle, double end,
                  const std::function<std::vector<Joint<double>>(double)>& at)
{
    if (rule.courant > 0) s.step.courant = rule.courant;
    Squeezed result;
    result.apart = s.lattice.dx / rule.per_axis;
    for (const Particle<double>& q : s.particles) result.from.push_back(q.x - middle);
    const auto solver = rule.in_double ? v.reference(s) : v.solver(s);
    const double begun = wall_seconds();
    result.stats = drive(*solver, 1.0 / 60, end, at, [](double) { return true; });
    result.seconds = wall_seconds() - begun;
    for (const Particle<double>& q : by_id(*solver)) result.to.push_back(q.x - middle);
    return result;
}

BallOfClay ball_of_clay(const SqueezeRule& rule, double friction)
{
    Setup s = between_walls({rule.cells, rule.cells, rule.cells}, 1.0 / rule.cells,
                            ContactMode::separate, friction);
    const Place middle = s.walls.min + Place{0.5, 0.5, 0.5};
    fill(s, plastic(1e5, 0.3, 1000, 1e4), s.walls.min, s.walls.max, rule.per_axis,
         [&](Place x) { return length(x - middle) < squeeze_radius; });
    return {std::move(s), middle};
}

Squeezed squeezed(const Verification& v, const SqueezeRule& rule)
{
    auto [s, middle] = ball_of_clay(rule, 0.3);
    for (int i = 0; i < 2; ++i) add_ball_tool(s, tool_radius, ContactMode::separate, 0.4);
    const auto at = [middle = middle](double t) {
        const double x = squeeze_radius + tool_radius - std::min(speed * t, deep);
        return std::vector{stands_at(middle + Place{-x, 0, 0}), stands_at(middle + Place{x, 0, 0})};
    };
    return followed(v, rule, std::move(s), middle, deep / speed + rest, at);
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

Apart apart(const Squeezed& coarse, const Squeezed& fine)
{
    const auto at_coarse = numbered(coarse), at_fine = numbered(fine);
    std::vector<::Eigen::Vector3d> a, b;
    for (const Place& X : probes()) {
        const auto here = taken(coarse, at_coarse, X), there = taken(fine, at_fine, X);
        if (here && there) a.push_back(vector(*here)), b.push_back(vector(*there));
    }
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

// Coarser and coarser cells against the finest.
void squeeze_part(Verification& v)
{
    const std::vector<int> sizes = v.quick() ? std::vector{16, 24, 48} : std::vector{16, 32, 64};
    std::vector<Squeezed> all;
    for (const int n : sizes) all.push_back(squeezed(v, {n}));
    // Relative to the ball's own moments, which differ a little as particles fill it.
    const auto shape = [](const Squeezed& s) {
        return (1 / trace(gyration(s.from))) * gyration(s.to);
    };
    const auto off = [&](const Squeezed& s) {
        const Sym3<double> best = shape(all.back());
        return std::sqrt(norm_squared(shape(s) + -1.0 * best) / norm_squared(best));
    };
    const std::string advice = "finer cells do not give a better shape here: keep the coarser ones";
    const Apart coarse = apart(all[0], all[2]), middle = apart(all[1], all[2]);
    const std::string names = fmt::format(
        "squeeze, {} against {} cells per m, finest {}: ", sizes[1], sizes[0], sizes[2]);
    const auto ratio = [&](const char* what, double fine, double rough, const char* unit) {
        Check c = at_most(names + what, fine / rough, 0.7, "", advice);
        c.note = fmt::format("{:.3g} and {:.3g}{}", fine, rough, unit);
        v.add(c);
    };
    ratio("moments", off(all[1]), off(all[0]), "");
    ratio("places", 1e3 * middle.rms, 1e3 * coarse.rms, " mm");
    v.add(at_most("squeeze: rigid shift against the finest, over dx",
                  std::max(coarse.shift * sizes[0], middle.shift * sizes[1]), 0.05, "", advice));
    v.add(at_most("squeeze: rigid turn against the finest",
                  std::max(coarse.turn, middle.turn) * 180 / M_PI, 0.5, "degrees", advice));
    v.add(at_most("squeeze: nodes clipped, clay put back, at all sizes",
                  double(all[0].stats.clipped + all[1].stats.clipped + all[2].stats.clipped +
                         all[0].stats.repaired + all[1].stats.repaired + all[2].stats.repaired),
                  0, "", "shorten the substep"));
    release_checks(v);
}

}  // namespace knead
