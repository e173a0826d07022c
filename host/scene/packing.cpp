#include "host/scene/packing.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "cuda/mpm/stencil.h"
#include "cuda/surface/density.h"
#include "host/base/parallel.h"
#include "host/scene/strata.h"

namespace knead {
namespace {

using Size = std::ptrdiff_t;
using Values = std::vector<float>;
using Points = std::vector<Vec3<double>>;

constexpr int layers = 2;       // whole layers below the surface that are moved
constexpr int iterations = 12;  // of packing
constexpr double rate = 6, inertia = 0.6, max_move = 0.2;  // the last in strata
constexpr Int3 one{1, 1, 1};
constexpr Vec3<double> half{0.5, 0.5, 0.5};

Vec3<double> real(Int3 n) { return {double(n.x), double(n.y), double(n.z)}; }

// One node at the centre of every stratum, and a margin of empty nodes wider than any kernel.
// Positions are in strata from the first node.
struct StrataBox {
    double h;
    Int3 low, size;
    Size stride[3];

    StrataBox(const Packing& p, int margin)
        : h(p.h),
          low(p.low - margin * one),
          size(p.high - p.low + 2 * margin * one),
          stride{1, size.x, Size(size.x) * size.y}
    {
    }
    Size count() const { return stride[2] * size.z; }
    Size at(Int3 n) const { return n.x + n.y * stride[1] + n.z * stride[2]; }
    Vec3<double> metres(Vec3<double> place) const { return h * (place + real(low) + half); }
    Vec3<double> place(Vec3<double> metres) const { return (1 / h) * metres - real(low) - half; }
    // Calls visit(n) for all nodes at least `rim` layers from the border, layer by layer.
    template <class Visit>
    void each(int rim, Visit&& visit) const
    {
        parallel_for(size.z - 2 * rim, LoopOptions{.chunk = 1}, [&](int layer) {
            for (int y = rim; y < size.y - rim; ++y)
                for (int x = rim; x < size.x - rim; ++x) visit(Int3{x, y, rim + layer});
        });
    }
};

// Moves a point that lies outside by less than h to just inside.
Vec3<double> put_inside(const Depth& depth, Vec3<double> x, double h)
{
    const double d = depth(x), step = 1e-3 * h;
    if (d >= 0) return x;
    const auto slope = [&](Vec3<double> along) {
        return (depth(x + step * along) - depth(x - step * along)) / (2 * step);
    };
    const Vec3<double> g{slope({1, 0, 0}), slope({0, 1, 0}), slope({0, 0, 1})};
    return x + ((step - d) / max(dot(g, g), 1e-6)) * g;
}

// The part of a stratum inside the shape.
struct Part {
    double share = 0;       // fraction of the stratum's volume
    Vec3<double> centre{};  // centre of mass [m]
};

Part part_of(const Depth& depth, Int3 s, double h)
{
    constexpr int n = 4;
    constexpr double half_diagonal = 0.8660254037844387;
    const auto at = [&](Vec3<double> place) { return h * (real(s) + place); };
    const double middle = depth(at(half));
    if (middle <= -half_diagonal * h) return {};
    bool whole = middle > 0;
    for (int c = 0; c < 8 && whole && middle < half_diagonal * h; ++c)
        whole = depth(at(real({c & 1, c >> 1 & 1, c >> 2}))) >= 0;
    if (whole) return {1, at(half)};
    double sum = 0;
    Vec3<double> moment{};
    for (int k = 0; k < n * n * n; ++k) {
        const Vec3<double> x = at((1.0 / n) * (real({k % n, k / n % n, k / (n * n)}) + half));
        const double share = clamp(0.5 + n / h * depth(x), 0.0, 1.0);
        sum += share, moment = moment + share * x;
    }
    if (sum == 0) return {};
    return {sum / (n * n * n), (1 / sum) * moment};
}

// Threshold in [0, 1), with low discrepancy among neighbours: selects which of equally cut strata
// hold a particle. The sequence R_3 [Roberts 2018], by position.
double threshold(Int3 s, double offset)
{
    constexpr double g = 1.2207440846057596;  // g^4 = g + 1
    const double t = offset + s.x / g + s.y / (g * g) + s.z / (g * g * g);
    return t - std::floor(t);
}

// A stratum cut by the surface, and its candidate particle.
struct Cut {
    Int3 node;
    double share;
    double excess;           // inside fraction minus threshold; -1: no position
    Vec3<double> x, centre;  // particle and centre of mass of the inside part [m]
};

// Computes the inside fraction of every stratum. Returns the cut strata, in order.
std::vector<Cut> measure(const Packing& p, const Depth& depth, const StrataBox& box, Values& shares)
{
    const double offset = strata::hashed(p.seed, p.object, {}).x;
    std::vector<std::vector<Cut>> by_layer(std::size_t(box.size.z));
    box.each(0, [&](Int3 n) {
        const Int3 s = box.low + n;
        const Part part = part_of(depth, s, p.h);
        shares[std::size_t(box.at(n))] = float(part.share);
        if (part.share == 0 || float(part.share) == 1) return;
        const Vec3<double> jitter =
            stratum_place(p.seed, p.object, s, p.h, p.per_cell) - p.h * (real(s) + half);
        const Vec3<double> x = put_inside(depth, part.centre + jitter, p.h);
        const double excess = depth(x) >= 0 ? part.share - threshold(s, offset) : -1;
        by_layer[std::size_t(n.z)].push_back({n, part.share, excess, x, part.centre});
    });
    std::vector<Cut> all;
    for (const std::vector<Cut>& layer : by_layer)
        all.insert(all.end(), layer.begin(), layer.end());
    return all;
}

// Selects cut strata, as many as their total volume fills: those with the largest excess over their
// threshold. Returned in order.
std::vector<Cut> chosen(const std::vector<Cut>& cuts)
{
    double volume = 0;
    std::vector<double> excess;
    for (const Cut& c : cuts) volume += c.share, excess.push_back(c.excess);
    const auto wanted = Size(std::lround(volume));
    double limit = -1;
    if (wanted < Size(cuts.size())) {
        std::nth_element(excess.begin(), excess.begin() + wanted, excess.end(), std::greater<>());
        limit = excess[std::size_t(wanted)];
    }
    std::vector<Cut> some;
    for (const Cut& c : cuts)
        if (c.excess > limit) some.push_back(c);
    return some;
}

// Adds particles of volume 1 or `share` to the density. They are grouped by the layer of their
// stencil's first node, so that layers are summed in parallel and each in a fixed order.
void deposit_all(const StrataBox& box, const Points& places, const Values& share, Values& density)
{
    constexpr int slab = 4;
    std::vector<std::vector<int>> by_layer(std::size_t(box.size.z));
    for (std::size_t i = 0; i < places.size(); ++i)
        by_layer[std::size_t(base_node(places[i], 1.0).z)].push_back(int(i));
    parallel_for((box.size.z + slab - 1) / slab, LoopOptions{.chunk = 1}, [&](int k) {
        const int low = k * slab;
        for (int z = max(low - 2, 0); z < min(low + slab, box.size.z); ++z)
            for (const int i : by_layer[std::size_t(z)]) {
                const Stencil<double> s = stencil(places[std::size_t(i)], 1.0);
                float* const base = density.data() + box.at(s.base);
                const double whole = share.empty() ? 1 : double(share[std::size_t(i)]);
                deposit(s, whole, [&](Int3 step, double part) {
                    if (z + step.z >= low && z + step.z < low + slab)
                        base[box.at(step)] += float(part);
                });
            }
    });
}

// Smooths by passes of the surface's binomial kernel along every axis.
void smooth(const StrataBox& box, int passes, Values& values, Values& other)
{
    for (int pass = 0; pass < passes; ++pass)
        for (const Size along : box.stride) {
            const float* const from = values.data();
            float* const to = other.data();
            box.each(1, [&](Int3 n) {
                const Size i = box.at(n);
                to[i] = smoothed<float>([&](int step) { return from[i + step * along]; });
            });
            values.swap(other);
        }
}

// Replaces every value by the minimum within `layers` nodes: below 1 near the surface.
Values lowered(const StrataBox& box, Values values)
{
    Values other(values.size());
    for (const Size along : box.stride) {
        box.each(layers, [&](Int3 n) {
            const float* const v = values.data() + box.at(n);
            float low = v[0];
            for (int k = 1; k <= layers; ++k) low = min(low, min(v[-k * along], v[k * along]));
            other[std::size_t(box.at(n))] = low;
        });
        values.swap(other);
    }
    return values;
}

// Gradient descent of the particles on the squared difference of two densities: the density of
// `still` and the particles, and the density of the shape. A particle that would leave the shape is
// not moved.
void pack(const StrataBox& box, const Depth& depth, const Values& still, const Values& shape,
          int passes, Points& places, Values& other)
{
    Values density;
    Points velocity(places.size());
    for (int k = 0; k < iterations; ++k) {
        density = still;
        deposit_all(box, places, {}, density);
        smooth(box, passes, density, other);
        for (std::size_t i = 0; i < density.size(); ++i) density[i] -= shape[i];
        smooth(box, passes, density, other);
        parallel_for(places.size(), [&](std::size_t i) {
            Vec3<double> slope{}, &v = velocity[i];
            const Stencil<double> s = stencil(places[i], 1.0);
            for_each_node(s, 1.0, [&](Int3 step, double w, Vec3<double> d) {
                slope = slope + 4 * w * double(density[std::size_t(box.at(s.base + step))]) * d;
            });
            v = inertia * v - rate * slope;
            v = min(1.0, max_move / max(length(v), 1e-30)) * v;
            const Vec3<double> moved = places[i] + v;
            if (depth(box.metres(moved)) >= 0)
                places[i] = moved;
            else
                v = {};
        });
    }
}

// Target density: one particle at the centre of every whole stratum, and the inside fraction of
// each cut stratum at its centre of mass. A shape made of whole strata needs no packing.
Values shape_density(const StrataBox& box, const std::vector<Cut>& cuts, const Values& shares)
{
    Points places;
    Values share, density(shares.size());
    for (int z = 0; z < box.size.z; ++z)
        for (int y = 0; y < box.size.y; ++y)
            for (int x = 0; x < box.size.x; ++x)
                if (shares[std::size_t(box.at({x, y, z}))] == 1)
                    places.push_back(real({x, y, z})), share.push_back(1);
    for (const Cut& c : cuts)
        places.push_back(box.place(c.centre)), share.push_back(float(c.share));
    deposit_all(box, places, share, density);
    return density;
}

// Particles in the order of their strata, and flags of those that are moved.
struct Seeds {
    Points places;
    std::vector<char> moves;
};

Seeds seeded(const Packing& p, const StrataBox& box, const std::vector<Cut>& cuts,
             const Values& shares)
{
    const Values near = lowered(box, shares);
    Seeds seeds;
    auto cut = cuts.begin();
    for (int z = 0; z < box.size.z; ++z)
        for (int y = 0; y < box.size.y; ++y)
            for (int x = 0; x < box.size.x; ++x) {
                const Int3 n{x, y, z};
                const auto i = std::size_t(box.at(n));
                const bool chosen = cut != cuts.end() && box.at(cut->node) == box.at(n);
                if (!chosen && shares[i] < 1) continue;
                const Vec3<double> at =
                    chosen ? (cut++)->x
                           : stratum_place(p.seed, p.object, box.low + n, p.h, p.per_cell);
                seeds.places.push_back(box.place(at));
                seeds.moves.push_back(near[i] < 1);
            }
    return seeds;
}

}  // namespace

std::vector<Vec3<double>> packed(const Packing& p, const Depth& depth)
{
    const int passes = smoothing_passes(1.0, 1.0), margin = passes + 3;
    const StrataBox box(p, margin);
    Values shares(std::size_t(box.count()));
    const std::vector<Cut> cuts = measure(p, depth, box, shares);
    const Seeds seeds = seeded(p, box, chosen(cuts), shares);
    Points moving, still;
    for (std::size_t i = 0; i < seeds.places.size(); ++i)
        (seeds.moves[i] ? moving : still).push_back(seeds.places[i]);
    Values shape = shape_density(box, cuts, shares), at_rest(shape.size()), &other = shares;
    std::fill(other.begin(), other.end(), 0.0f);
    smooth(box, passes, shape, other);
    deposit_all(box, still, {}, at_rest);
    pack(box, depth, at_rest, shape, passes, moving, other);
    Points all;
    auto moved = moving.begin();
    for (std::size_t i = 0; i < seeds.places.size(); ++i)
        all.push_back(box.metres(seeds.moves[i] ? *moved++ : seeds.places[i]));
    return all;
}

}  // namespace knead
