// The shape of an object of shape `mesh`: what a closed surface of triangles encloses, as
// distances.
#pragma once
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "cuda/math/box.h"
#include "cuda/math/vec.h"

namespace knead {

struct MadeSolid;

// Lengths in longest extents of the surface, upright and turned. The origin is the centre of its
// box.
//
// A point is inside if its generalised winding number is not 0 [Barill 2018]. The surface may have
// several pieces: those that overlap need the same orientation, separate ones may have any. Holes
// are closed by fans around their middle, so that the number is whole everywhere.
class SolidMesh {
  public:
    // Largest share of the area in holes, but for those inside another piece.
    static constexpr double most_open = 0.05;
    static constexpr std::size_t most_triangles = 10'000'000;

    // `own`: rotation from the file's frame to the object's. Coincident vertices become one;
    // neighbours that are oriented unlike are turned; holes are closed. On failure `solid` is null
    // and `why` says what was found, with its place in the file's frame. Preconditions: finite
    // vertices, valid indices.
    static MadeSolid make(const std::vector<Vec3<double>>& vertices,
                          const std::vector<Int3>& triangles, Quat<double> own);

    // Signed depth, negative outside; a lower bound of its magnitude farther than `exact_within`
    // from the box. About 3 us for 100,000 triangles: see DepthLattice.
    double depth(Vec3<double> at) const;
    // The same of a shell of the thickness `wall` below the surface; 0: no shell, but the whole.
    double depth(Vec3<double> at, double wall) const;
    static constexpr double exact_within = 1.0 / 32;

    bool inside(Vec3<double> at) const;
    // Distance to the surface; `within` if that is less. `nearest`: set to the nearest triangle;
    // before, one to begin with, or -1.
    double distance(Vec3<double> at, double within, int& nearest) const;

    // Of several pieces with more than 10,000 triangles, what overlaps counts twice.
    double volume() const { return volume_; }
    double volume(double wall) const;                  // of a shell within about 1 %
    Vec3<double> size() const { return 2.0 * half_; }  // full extents; the longest is 1
    double file_extent() const { return extent_; }     // the longest, in units of the file
    // Lowest and highest of dot(p, along) over the points p of the surface.
    std::pair<double, double> reach(Vec3<double> along) const;
    std::size_t bytes() const;
    std::size_t closed_holes() const { return holes_; }

  private:
    struct Triangle {
        Vec3<double> a, ab, ac;
    };
    // Of a tree of boxes: a leaf if `count` is not 0. Seen from farther than `far` from `middle`,
    // its triangles are a dipole there.
    struct Node {
        Box3<float> box;
        int first = 0, count = 0;  // triangles of a leaf; else the second child, the first follows
        Vec3<float> middle, dipole;
        float far = 0;
    };

    int add_node(const std::vector<Triangle>& all, std::vector<int>& order, int begin, int end);
    void add_triangles(const std::vector<Int3>& triangles, std::size_t count);
    double winding(Vec3<double> at) const;
    double volume_of_pieces() const;
    double sampled_volume(double wall, int n) const;

    std::vector<Vec3<double>> vertices_;
    std::vector<Triangle> triangles_;  // in the order of the nodes
    std::vector<Node> nodes_;
    Vec3<double> half_{};
    double extent_ = 0, volume_ = 0;
    std::size_t holes_ = 0;
    mutable std::mutex mutex_;
    mutable std::vector<std::pair<double, double>> hollow_;  // walls and their volumes
};

struct MadeSolid {
    std::shared_ptr<const SolidMesh> solid;
    std::string why;
};

// Depths of a solid at the nodes of a lattice, interpolated: for filling with particles, which asks
// for millions. Between nodes that are `spacing` apart, flat surfaces are exact and edges rounded
// by less than a fifth of it. 4 bytes a node.
class DepthLattice {
  public:
    // Lengths as in SolidMesh. `within`: distance from the surface of body or shell up to which
    // depths are exact at the nodes; beyond, their magnitude is a lower bound above `within` less
    // 2 spacings. The spacing is enlarged where there would be more than 2^27 nodes.
    DepthLattice(const SolidMesh& solid, double wall, double spacing, double within);
    double depth(Vec3<double> at) const;

  private:
    struct Known;
    static Known look(const SolidMesh& solid, Vec3<double> at, const Known& from);
    void fill(const SolidMesh& solid, double wall, double within, Int3 first, int cells,
              const Known& from);
    Vec3<double> place(Int3 n) const
    {
        return low_ + spacing_ * Vec3<double>{double(n.x), double(n.y), double(n.z)};
    }
    std::size_t at(Int3 n) const
    {
        return (std::size_t(n.z) * std::size_t(size_.y) + std::size_t(n.y)) * std::size_t(size_.x) +
               std::size_t(n.x);
    }

    Vec3<double> low_{};
    double spacing_ = 0;
    Int3 size_{};  // nodes; whole blocks and one more
    std::vector<float> depths_;
};

}  // namespace knead
