// What commands do to the clay of objects: copy, true rescale with resampling, partition. Functions
// of particles only: no simulator, no document. In double.
#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "cuda/math/box.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"
#include "host/solver/piece_count.h"

namespace knead {

// The clay of one object of the simulator; all its particles have the mass and volume of
// `material`.
struct PartClay {
    Material<double> material{};
    std::vector<Particle<double>> particles;
};

// Rescaled clay is resampled outside this range of particles per cell.
constexpr double fewest_per_cell = 4, most_per_cell = 16;

Box3<double> box_of(const std::vector<PartClay>& parts);
Vec3<double> centre_of_mass(const std::vector<PartClay>& parts);
void displace(std::vector<PartClay>& parts, Vec3<double> by);  // [m]

// Binary logarithm of the factor by which resampling changes the particle count of clay with so
// many particles per cell at rest: 0 within the range, else such that the count comes near 8.
int doublings(double per_cell);
// Particles of this clay per cell at rest, scaled by `factor`.
inline double per_cell_of(const Material<double>& m, double factor, double dx)
{
    return dx * dx * dx / (factor * factor * factor * m.volume);
}

// The clay scaled about `centre`, and resampled. Velocities stay, their gradients are divided by
// the factor; strains, hardening and labels stay. Resampling keeps mass, volume, centre of mass,
// momentum and angular momentum.
PartClay scaled(PartClay clay, Vec3<double> centre, double factor, double dx);
// Replaces each particle by 2^times: halves it along x, y, z in turn, each half a quarter of the
// spacing from the centre.
PartClay refined(PartClay clay, int times, double dx);
// Merges groups of 2^times neighbouring particles with equal labels; sizes differ if the count is
// not a multiple. Stress: the group's mean; if the material has no such state, the mean strain.
PartClay coarsened(PartClay clay, int times, double dx);

// Elastic strain with this Kirchhoff stress [Pa]. `guess`: returned if there is none.
Sym3<double> strain_of(const Sym3<double>& stress, const Material<double>& m, double k,
                       const Sym3<double>& guess);

// 0: before the plane, on the side that `normal` points to; 1: behind it.
inline int side_of(Vec3<double> x, Vec3<double> point, Vec3<double> normal)
{
    return dot(x - point, normal) >= 0 ? 0 : 1;
}

// Points nearer to other clay, `there`, than `distance` [m]: their place is taken.
class NearPlaces {
  public:
    NearPlaces(const std::vector<Vec3<double>>& there, double distance) : edge(distance)
    {
        for (const Vec3<double>& x : there) cells[key(cell(x))].push_back(x);
    }
    bool taken(Vec3<double> x) const
    {
        const Int3 c = cell(x);
        for (int k = -1; k <= 1; ++k)
            for (int j = -1; j <= 1; ++j)
                for (int i = -1; i <= 1; ++i) {
                    const auto found = cells.find(key(c + Int3{i, j, k}));
                    if (found == cells.end()) continue;
                    for (const Vec3<double>& y : found->second)
                        if (length(x - y) < edge) return true;
                }
        return false;
    }

  private:
    Int3 cell(Vec3<double> x) const
    {
        return {int(std::floor(x.x / edge)), int(std::floor(x.y / edge)),
                int(std::floor(x.z / edge))};
    }
    static std::int64_t key(Int3 c) { return (std::int64_t(c.x) * 2097152 + c.y) * 2097152 + c.z; }
    double edge;
    std::unordered_map<std::int64_t, std::vector<Vec3<double>>> cells;
};

// The nearest of some points; of equally near ones the first.
class NearestPoint {
  public:
    explicit NearestPoint(std::vector<Vec3<double>> points);
    // Index and distance [m]. Precondition: there is a point.
    struct Found {
        int index;
        double distance;
    };
    Found operator()(Vec3<double> x) const;

  private:
    void arrange(std::size_t from, std::size_t to, int axis);
    void search(std::size_t from, std::size_t to, int axis, Vec3<double> x, Found& best) const;

    std::vector<Vec3<double>> points;
    std::vector<int> order;
};

// Number of the connected piece of each particle of all parts, in order; the largest piece is 0.
// Cells with more than a quarter of their volume filled are connected if they touch and do not
// carry opposite labels (pieces.h). Pieces of fewer than fewest_particles_in_part particles, and
// the particles in other cells, belong to the nearest piece.
struct Pieces {
    int count = 0;
    std::vector<int> of_particle;
};
Pieces connected_pieces(const std::vector<PartClay>& parts, const Lattice<double>& lattice);

}  // namespace knead
