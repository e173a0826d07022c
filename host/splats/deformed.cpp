#include "host/splats/deformed.h"

#include <stdexcept>
#include <string>

#include "cuda/splats/footprint.h"
#include "host/base/parallel.h"

namespace knead {
namespace {

// Moves splat i to x and deforms it by F; `turn` rotates its colours.
void put(SplatCloud& cloud, std::size_t i, Vec3<double> x, const Mat3<double>& F,
         const Mat3<double>& turn)
{
    const Ellipsoid<double> rest{cast<double>(cloud.rotation[i]), cast<double>(cloud.scale[i])};
    const Mat3<double> L = F * half_axes(rest);
    const Ellipsoid<double> e = ellipsoid(symmetric(L * transpose(L)));
    cloud.centre[i] = cast<float>(x);
    cloud.rotation[i] = cast<float>(e.q);
    cloud.scale[i] = cast<float>(e.scale);
    const int count = harmonics(cloud.degree);
    Vec3<float>* const own = cloud.sh.data() + i * std::size_t(count);
    Vec3<double> turned[harmonics(max_sh_degree)] = {};
    turn_harmonics(
        cloud.degree, turn, [&](int k) { return cast<double>(own[k]); },
        [&](int k, Vec3<double> v) { turned[k] = turned[k] + v; });
    for (int k = 0; k < count; ++k) own[k] = cast<float>(turned[k]);
}

}  // namespace

SplatCloud deformed(SplatCloud cloud, const std::vector<Gaussian<double>>& gaussians)
{
    if (gaussians.size() > cloud.count())
        throw std::invalid_argument(std::to_string(gaussians.size()) + " Gaussians of " +
                                    std::to_string(cloud.count()) + " splats");
    const int count = int(gaussians.size());
    parallel_for(count, [&](int i) {
        const Gaussian<double>& g = gaussians[std::size_t(i)];
        put(cloud, std::size_t(i), g.x, g.F, polar_rotation(g.F));
    });
    return cloud;
}

SplatCloud placed(const SplatCloud& cloud, Quat<double> q, double scale, Vec3<double> shift)
{
    SplatCloud moved = cloud;
    const Mat3<double> Q = rotation(q), F{scale * Q.a, scale * Q.b, scale * Q.c};
    const int count = int(cloud.count());
    parallel_for(count, [&](int i) {
        const Vec3<double> x = cast<double>(cloud.centre[std::size_t(i)]);
        put(moved, std::size_t(i), F * x + shift, F, Q);
    });
    return moved;
}

}  // namespace knead
