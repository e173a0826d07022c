// The walls of the box that the clay lives in.
#pragma once
#include <cmath>

#include "cuda/contact/contact.h"
#include "cuda/mpm/lattice.h"

namespace knead {

// The box the clay lives in, by its six inner faces, in the simulation's frame. Two nodes at least
// stand beyond each face, so that no stencil leaves the lattice.
struct WallRule {
    Vec3<double> min, max;  // [m]
    ContactMode mode;
    double friction;  // Coulomb [1]
};

// The same as the stages see it. Nodes on and behind a face are held; the others are free.
template <class R>
struct Walls {
    Vec3<R> min, max;            // [m]
    Vec3<R> deep_min, deep_max;  // farther no node lets a particle sink in a substep (19) [m]
    Int3 first, free;            // the first free node, and how many there are along each axis
    ContactMode mode;
    R friction;
};

// Where along an axis nodes are held, for faces at `min` and `max` [m]: to `below` and from `above`
// on. A face that is off a node by no more than what its decimals leave out stands on it.
struct HeldNodes {
    int below, above;
};
inline HeldNodes held_nodes(double min, double max, double dx)
{
    constexpr double rounding = 1e-4;  // cells
    return {int(std::floor(min / dx + rounding)), int(std::ceil(max / dx - rounding))};
}

// How far a particle at a face sinks in a substep at most [cells], where the first held node lies
// `behind` it [cells]: the weight of the free nodes (1), which move by a cell at most (3).
inline double sinking(double behind)
{
    const double x = behind < 0.5 ? 0.5 + behind : 1.5 - behind;
    return (behind < 0.5 ? x * x / 2 : 1 - x * x / 2) + 0.001;  // and what rounding may add
}

template <class R, class L>
Walls<R> walls_on(const Lattice<L>& lattice, const WallRule& rule)
{
    Walls<R> w{};
    w.min = cast<R>(rule.min), w.max = cast<R>(rule.max);
    w.mode = rule.mode, w.friction = R(rule.friction);
    const double dx = double(lattice.dx);
    const auto axis = [dx](double low, double high, R& deep_low, R& deep_high, int& first,
                           int& free) {
        const HeldNodes held = held_nodes(low, high, dx);
        deep_low = R(low - dx * sinking(low / dx - held.below));
        deep_high = R(high + dx * sinking(held.above - high / dx));
        first = held.below + 1, free = held.above - first;
    };
    const Vec3<double>&a = rule.min, &b = rule.max;
    axis(a.x, b.x, w.deep_min.x, w.deep_max.x, w.first.x, w.free.x);
    axis(a.y, b.y, w.deep_min.y, w.deep_max.y, w.first.y, w.free.y);
    axis(a.z, b.z, w.deep_min.z, w.deep_max.z, w.first.z, w.free.z);
    return w;
}

// Whether x lies between the faces, but for rounding: clay that rests on a face has its place in
// float.
inline bool between(const WallRule& rule, Vec3<double> x, double dx)
{
    const auto inside = [dx](double at, double low, double high) {
        const auto rounding = [dx](double face) { return 1e-6 * std::fmax(dx, std::fabs(face)); };
        return at >= low - rounding(low) && at <= high + rounding(high);
    };
    return inside(x.x, rule.min.x, rule.max.x) && inside(x.y, rule.min.y, rule.max.y) &&
           inside(x.z, rule.min.z, rule.max.z);
}

// Whether there are 2 nodes of the lattice beyond each face, and free ones between them.
template <class L>
bool has_room(const Lattice<L>& lattice, const WallRule& rule)
{
    const Walls<double> w = walls_on<double>(lattice, rule);
    const auto fits = [](int first, int free, int size) {
        return first >= 3 && free > 0 && first + free <= size - 3;
    };
    const Int3 n = lattice.size;
    return fits(w.first.x, w.free.x, n.x) && fits(w.first.y, w.free.y, n.y) &&
           fits(w.first.z, w.free.z, n.z);
}

// Faces so many nodes inside the lattice.
template <class L>
WallRule walls_inside(const Lattice<L>& lattice, int nodes, ContactMode mode, double friction)
{
    const double dx = double(lattice.dx);
    const Int3 n = lattice.size - Int3{nodes + 1, nodes + 1, nodes + 1};
    return {{dx * nodes, dx * nodes, dx * nodes}, {dx * n.x, dx * n.y, dx * n.z}, mode, friction};
}

}  // namespace knead
