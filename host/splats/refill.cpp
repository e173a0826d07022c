#include "host/splats/refill.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "cuda/splats/footprint.h"
#include "host/base/parallel.h"
#include "host/splats/cells.h"

namespace knead {
namespace {

// In particle spacings.
constexpr double neighbourhood = 2.2;
constexpr double depth_of_sight = 1.5;
constexpr double colour_reach = 4;
constexpr double disc = 0.7, thickness = 0.35;
// Criterion for the surface: minimum distance of a particle from the centroid of its neighbours,
// relative to their radius. Half a spacing below a plane it is 0.17, one and a half below 0.02.
constexpr double lopsided = 0.1;
constexpr float opacity = 0.98f;

// Optical depths are summed in fixed point, so that the sum does not depend on the order.
constexpr double depth_steps = 0x1p32;

struct Place {
    std::uint32_t particle;
    double spacing;          // [m]
    Vec3<double> x, n;       // position of the particle [m]; outward surface normal
    std::int64_t depth = 0;  // optical depth of the covering splats
};

// Finds the particles on the surface.
std::vector<Place> surface_places(const std::vector<Particle<double>>& particles,
                                  const std::vector<double>& spacing, double widest)
{
    std::vector<Vec3<double>> x;
    x.reserve(particles.size());
    for (const Particle<double>& p : particles) x.push_back(p.x);
    const Cells cells(x, neighbourhood * widest);
    const int count = int(particles.size());
    std::vector<Vec3<double>> normal(x.size(), {0, 0, 0});
    parallel_for(count, LoopOptions{.chunk = 256}, [&](int k) {
        const auto i = std::size_t(k);
        const double reach = neighbourhood * spacing[std::size_t(particles[i].object)];
        if (!(reach > 0)) return;
        Vec3<double> sum{};
        double weight = 0;
        cells.each_near(x[i], {reach, reach, reach}, [&](std::uint32_t j) {
            const Vec3<double> d = x[j] - x[i];
            const double w = 1 - dot(d, d) / (reach * reach);
            if (w > 0) sum = sum + w * d, weight += w;
        });
        const double off = length(sum);
        if (off > lopsided * reach * weight) normal[i] = (-1 / off) * sum;
    });
    std::vector<Place> places;
    for (std::size_t i = 0; i < x.size(); ++i)
        if (dot(normal[i], normal[i]) > 0.5)
            places.push_back(
                {std::uint32_t(i), spacing[std::size_t(particles[i].object)], x[i], normal[i]});
    return places;
}

// A splat that may cover places.
struct Cover {
    Vec3<double> x;
    Mat3<double> M;  // half axes, deformed [m]
    double opacity;
};

// Optical depth of the splat along the normal of a place.
std::int64_t depth_over(const Cover& c, const Mat3<double>& inverse, const Place& place)
{
    const Vec3<double> d = place.x - c.x;
    if (std::abs(dot(d, place.n)) > depth_of_sight * place.spacing) return 0;
    const Vec3<double> p = inverse * d, q = inverse * place.n;  // in half axes
    const double along = dot(p, q), across = dot(q, q);
    const double u2 = dot(p, p) - (across > 0 ? along * along / across : 0);
    const double alpha = min(c.opacity * std::exp(-u2 / 2), max_alpha);
    return std::int64_t(-std::log1p(-alpha) * depth_steps);
}

Vec3<double> reach_of(const Cover& c, double widest)
{
    const auto along = [&](double a, double b, double d) {
        return min(3 * std::sqrt(a * a + b * b + d * d), 8 * widest) + depth_of_sight * widest;
    };
    const Mat3<double>& M = c.M;
    return {along(M.a.x, M.b.x, M.c.x), along(M.a.y, M.b.y, M.c.y), along(M.a.z, M.b.z, M.c.z)};
}

// Adds a splat's optical depth to the places around it. A splat without thickness gets a small one.
void add_cover(Cover c, const Cells& cells, double widest, std::vector<Place>& places)
{
    if (!(c.opacity > min_alpha)) return;
    const Ellipsoid<double> e = ellipsoid(symmetric(c.M * transpose(c.M)));
    const double least = 1e-3 * widest;
    const Mat3<double> Q = rotation(e.q);
    const auto scaled = [&](Vec3<double> axis, double s) { return (1 / max(s, least)) * axis; };
    const Mat3<double> inverse = transpose(
        Mat3<double>{scaled(Q.a, e.scale.x), scaled(Q.b, e.scale.y), scaled(Q.c, e.scale.z)});
    cells.each_near(c.x, reach_of(c, widest), [&](std::uint32_t k) {
        const std::int64_t more = depth_over(c, inverse, places[k]);
        std::atomic_ref<std::int64_t>(places[k].depth) += more;
    });
}

// Colour lookup among the existing splats.
class Colours {
  public:
    Colours(const SplatCloud& of, const std::vector<Gaussian<double>>& by, double widest,
            std::size_t objects)
        : cloud(of),
          gaussians(by),
          x(places(by)),
          cells(x, colour_reach * widest / 2),
          mean(objects),
          count(objects, 0)
    {
        for (std::size_t i = 0; i < gaussians.size(); ++i) {
            const auto object = std::size_t(gaussians[i].object);
            mean[object] = mean[object] + colour(i), count[object] += 1;
        }
        for (std::size_t o = 0; o < objects; ++o)
            if (count[o] > 0) mean[o] = (1 / count[o]) * mean[o];
    }

    Vec3<double> at(const Place& place, int object) const
    {
        const double reach = colour_reach * place.spacing, soft = 0.25 * place.spacing;
        Vec3<double> sum{};
        double weight = 0;
        cells.each_near(place.x, {reach, reach, reach}, [&](std::uint32_t j) {
            const Vec3<double> d = x[j] - place.x;
            if (gaussians[j].object != object || dot(d, d) > reach * reach) return;
            const double w = double(cloud.opacity[j]) / (dot(d, d) + soft * soft);
            sum = sum + w * colour(j), weight += w;
        });
        return weight > 0 ? (1 / weight) * sum : mean[std::size_t(object)];
    }

  private:
    static std::vector<Vec3<double>> places(const std::vector<Gaussian<double>>& of)
    {
        std::vector<Vec3<double>> all;
        all.reserve(of.size());
        for (const Gaussian<double>& g : of) all.push_back(g.x);
        return all;
    }
    Vec3<double> colour(std::size_t i) const
    {
        return cast<double>(cloud.sh[i * std::size_t(harmonics(cloud.degree))]);
    }

    const SplatCloud& cloud;
    const std::vector<Gaussian<double>>& gaussians;
    std::vector<Vec3<double>> x;
    Cells cells;
    std::vector<Vec3<double>> mean;
    std::vector<double> count;
};

// A disc below the surface, its short axis along the normal.
Ellipsoid<double> disc_at(const Place& place)
{
    const Vec3<double> side = orthogonal(place.n);
    const Mat3<double> Q{side, cross(place.n, side), place.n};
    const double s = place.spacing;
    return {quaternion(Q), {disc * s, disc * s, thickness * s}};
}

// Accumulates the optical depth of the existing splats at every place.
void cover(const CarriedSplats& splats, const std::vector<Gaussian<double>>& gaussians,
           const Cells& cells, double widest, std::vector<Place>& places)
{
    const int count = int(gaussians.size());
    parallel_for(count, LoopOptions{.chunk = 256}, [&](int k) {
        const auto i = std::size_t(k);
        const Ellipsoid<double> rest{cast<double>(splats.cloud.rotation[i]),
                                     cast<double>(splats.cloud.scale[i])};
        add_cover(
            {gaussians[i].x, gaussians[i].F * half_axes(rest), double(splats.cloud.opacity[i])},
            cells, widest, places);
    });
}

}  // namespace

RefillReport refill(CarriedSplats& splats, std::vector<Gaussian<double>>& gaussians,
                    const std::vector<Particle<double>>& particles,
                    const std::vector<double>& spacing, const RefillOptions& options,
                    const WallOptions& walls)
{
    if (splats.count() != gaussians.size() || splats.extent.size() != gaussians.size())
        throw std::invalid_argument("refill: one splat for each Gaussian is needed");
    double widest = 0;
    for (double s : spacing) widest = max(widest, s);
    RefillReport report;
    if (!(widest > 0) || gaussians.empty()) return report;
    std::vector<Place> places = surface_places(particles, spacing, widest);
    std::vector<Vec3<double>> at;
    at.reserve(places.size());
    for (const Place& p : places) at.push_back(p.x);
    const Cells cells(at, widest);
    cover(splats, gaussians, cells, widest, places);

    const auto enough = std::int64_t(-std::log(options.see_through) * depth_steps);
    std::vector<std::uint32_t> bare;
    for (std::size_t k = 0; k < places.size(); ++k)
        if (places[k].depth < enough) bare.push_back(std::uint32_t(k));
    report.bare = bare.size();
    if (bare.empty()) return report;
    std::stable_sort(bare.begin(), bare.end(), [&](std::uint32_t a, std::uint32_t b) {
        return places[a].depth < places[b].depth;
    });
    const std::vector<Gaussian<double>> before = gaussians;
    const SplatCloud cloud_before = splats.cloud;
    const Colours colours(cloud_before, before, widest, spacing.size());
    std::vector<Vec3<float>> sh(std::size_t(harmonics(splats.cloud.degree)), {0, 0, 0});
    for (const std::uint32_t k : bare) {
        const Place& place = places[k];
        if (place.depth >= enough) continue;  // covered by new neighbours
        if (report.added.size() == options.budget || gaussians.size() >= options.capacity) {
            ++report.waiting;
            continue;
        }
        const Particle<double>& p = particles[place.particle];
        const Ellipsoid<double> shape = disc_at(place);
        const Vec3<double> way = ((0.5 - thickness) * place.spacing) * place.n;
        const Gaussian<double> g = gaussian_beside(p, way, walls);
        sh[0] = cast<float>(colours.at(place, p.object));
        append(splats, cast<float>(g.x), {cast<float>(shape.q), cast<float>(shape.scale)}, opacity,
               sh.data(), float(disc * place.spacing));
        gaussians.push_back(g);
        add_cover({g.x, half_axes(shape), double(opacity)}, cells, widest, places);
        report.added.push_back({int(place.particle), way});
    }
    return report;
}

}  // namespace knead
