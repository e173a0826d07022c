// Walls: the inner faces of the simulation box, and the mirror nodes across them.
#pragma once
#include <cmath>

#include "cuda/contact/contact.h"
#include "cuda/math/box.h"
#include "cuda/mpm/lattice.h"

namespace knead {

// Simulation box, given by its six inner faces in the simulation's frame. At least two nodes lie
// beyond each face, so that no stencil leaves the lattice.
struct WallOptions {
    Vec3<double> min, max;  // [m]
    ContactMode mode;
    double friction;  // Coulomb [1]
};

template <class R>
HD Vec3<R> put_between(const WallOptions& walls, Vec3<R> x)
{
    return nearest({cast<R>(walls.min), cast<R>(walls.max)}, x);
}

// The walls as the stages use them. Nodes on and behind a face are constrained; the others are
// free.
template <class R>
struct Walls {
    Vec3<R> min, max;            // [m]
    Vec3<R> deep_min, deep_max;  // the deepest that a particle gets in a substep (19) [m]
    Int3 first, free;            // the first free node, and their number, along each axis
    ContactMode mode;
    Int3 low_face, high_face;  // layers of nodes that faces lie on; or no_node
    R friction;
    int face_places;  // nodes per layer with a Sliding record, see sliding.h
};

constexpr int no_node = -(1 << 30);  // far from every node

// Mirror boundary: if a face lies on a layer of nodes, the node one step before it and the node one
// step behind it are mirror nodes of each other. `mirror_offset` is the offset from node n to its
// mirror node: 2 or -2 along the axis of each such face, 0 along the others. If n is behind faces,
// only those faces count.
struct AcrossFaces {
    Int3 mirror_offset;
    bool behind;
};
template <class R>
HD AcrossFaces across_faces(Int3 n, const Walls<R>& walls)
{
    const Int3 low = n - walls.low_face, high = n - walls.high_face;
    const auto from = [=](int side) {  // -1: behind, 1: before
        const auto axis = [=](int past_low, int past_high) {
            return past_low == side ? -2 * side : past_high == -side ? 2 * side : 0;
        };
        return Int3{axis(low.x, high.x), axis(low.y, high.y), axis(low.z, high.z)};
    };
    const Int3 back = from(-1), onwards = from(1);
    const bool behind = !(back == Int3{});
    return {behind ? back : onwards, behind};
}

// True if node n is more than one step before every wall.
template <class R>
HD bool clear_of(Int3 n, const Walls<R>& walls)
{
    const auto clear = [](int at, int free) { return unsigned(at - 1) < unsigned(free - 2); };
    const Int3 at = n - walls.first, free = walls.free;
    return clear(at.x, free.x) && clear(at.y, free.y) && clear(at.z, free.z);
}

// How node n is updated: together with its mirror nodes at `mirror_offset`; or not by itself
// (`is_mirror`), because it is the mirror node of a node that holds mass and is updated with that.
// mass(offset) returns the mass of node n + offset, as summed; updates do not change it.
struct MirrorSet {
    bool is_mirror;
    Int3 mirror_offset;
};
template <class R, class Mass>
HD MirrorSet mirror_set(Int3 n, const Walls<R>& walls, Mass&& mass)
{
    if (clear_of(n, walls)) return {};
    const AcrossFaces across = across_faces(n, walls);
    // Evaluated before a face as well: there the mirror node is needed next, and this issues its
    // loads (walls.cuh).
    const bool holds = mass(across.mirror_offset) > 0;
    return {across.behind && holds, across.behind ? Int3{} : across.mirror_offset};
}

// The k-th of node n and its mirror nodes; k = 0 is n itself. k has one bit per axis with a nonzero
// `mirror_offset`.
HD Int3 mirror_node(Int3 n, Int3 mirror_offset, int k)
{
    const auto axis = [&k](int step) {
        if (!step) return 0;
        const int taken = k & 1;
        k >>= 1;
        return taken * step;
    };
    const int x = axis(mirror_offset.x), y = axis(mirror_offset.y);
    return n + Int3{x, y, axis(mirror_offset.z)};
}
HD int mirror_count(Int3 mirror_offset)
{
    return 1 << ((mirror_offset.x != 0) + (mirror_offset.y != 0) + (mirror_offset.z != 0));
}

// The nodes along an axis that faces at `min` and `max` [m] constrain: all up to `below` and all
// from `above` on. A face within `face_rounding` of a node counts as lying on it.
struct HeldNodes {
    int below, above;
};
constexpr double face_rounding = 1e-4;  // cells
inline HeldNodes held_nodes(double min, double max, double dx)
{
    return {int(std::floor(min / dx + face_rounding)), int(std::ceil(max / dx - face_rounding))};
}

// The largest penetration of a particle at a face in one substep [cells], where the first
// constrained node lies `behind` cells behind the face: the weight of the free nodes (1), which
// move at most one cell (3).
inline double sinking(double behind)
{
    const double x = behind < 0.5 ? 0.5 + behind : 1.5 - behind;
    return (behind < 0.5 ? x * x / 2 : 1 - x * x / 2) + 0.001;  // plus rounding
}

// Node layers at a wall that keep Sliding records: the layer before the face, the layer on the face
// (or the first one behind it), and the layer after that. Returns the number of records per layer
// of one face; 0 if friction does not depend on pressure, or if the index would exceed 32 bits.
constexpr int sliding_layers = 3;
inline int sliding_places_of_face(Int3 size, const WallOptions& options)
{
    const auto area = [](int a, int b) { return double(a) * b; };
    const double most =
        std::fmax(std::fmax(area(size.x, size.y), area(size.y, size.z)), area(size.z, size.x));
    const bool few = 3.0 * 6 * sliding_layers * most < 2147483648.0;  // in three velocity fields
    return few && options.mode == ContactMode::separate && options.friction > 0 ? int(most) : 0;
}
HD int sliding_places(int of_face) { return 6 * sliding_layers * of_face; }
template <class R>
HD int sliding_places(const Walls<R>& walls)
{
    return sliding_places(walls.face_places);
}
inline int sliding_places(Int3 size, const WallOptions& options)
{
    return sliding_places(sliding_places_of_face(size, options));
}

template <class R, class L>
Walls<R> walls_on(const Lattice<L>& lattice, const WallOptions& options)
{
    Walls<R> w{};
    w.min = cast<R>(options.min), w.max = cast<R>(options.max);
    w.mode = options.mode, w.friction = R(options.friction);
    w.face_places = sliding_places_of_face(lattice.size, options);
    const double dx = double(lattice.dx);
    const auto axis = [dx](double low, double high, R& deep_low, R& deep_high, int& first,
                           int& free, int& low_face, int& high_face) {
        const HeldNodes held = held_nodes(low, high, dx);
        const double behind_low = low / dx - held.below, behind_high = held.above - high / dx;
        deep_low = R(low - dx * sinking(behind_low));
        deep_high = R(high + dx * sinking(behind_high));
        first = held.below + 1, free = held.above - first;
        const bool apart = free > 1;  // else a node would have two mirror nodes along one axis
        const auto on_node = [=](double behind) { return apart && behind < face_rounding; };
        low_face = on_node(behind_low) ? held.below : no_node;
        high_face = on_node(behind_high) ? held.above : no_node;
    };
    const Vec3<double>&a = options.min, &b = options.max;
    axis(a.x, b.x, w.deep_min.x, w.deep_max.x, w.first.x, w.free.x, w.low_face.x, w.high_face.x);
    axis(a.y, b.y, w.deep_min.y, w.deep_max.y, w.first.y, w.free.y, w.low_face.y, w.high_face.y);
    axis(a.z, b.z, w.deep_min.z, w.deep_max.z, w.first.z, w.free.z, w.low_face.z, w.high_face.z);
    return w;
}

// Whether x lies between the faces up to rounding: positions of particles at rest on a face are
// stored as float.
inline bool between(const WallOptions& options, Vec3<double> x, double dx)
{
    const auto inside = [dx](double at, double low, double high) {
        const auto rounding = [dx](double face) { return 1e-6 * std::fmax(dx, std::fabs(face)); };
        return at >= low - rounding(low) && at <= high + rounding(high);
    };
    return inside(x.x, options.min.x, options.max.x) && inside(x.y, options.min.y, options.max.y) &&
           inside(x.z, options.min.z, options.max.z);
}

// Whether at least 2 nodes of the lattice lie beyond each face, and free nodes between the faces.
template <class L>
bool has_room(const Lattice<L>& lattice, const WallOptions& options)
{
    const Walls<double> w = walls_on<double>(lattice, options);
    const auto fits = [](int first, int free, int size) {
        return first >= 3 && free > 0 && first + free <= size - 3;
    };
    const Int3 n = lattice.size;
    return fits(w.first.x, w.free.x, n.x) && fits(w.first.y, w.free.y, n.y) &&
           fits(w.first.z, w.free.z, n.z);
}

// Faces at `nodes` nodes from the ends of the lattice.
template <class L>
WallOptions walls_inside(const Lattice<L>& lattice, int nodes, ContactMode mode, double friction)
{
    const double dx = double(lattice.dx);
    const Int3 n = lattice.size - Int3{nodes + 1, nodes + 1, nodes + 1};
    return {{dx * nodes, dx * nodes, dx * nodes}, {dx * n.x, dx * n.y, dx * n.z}, mode, friction};
}

}  // namespace knead
