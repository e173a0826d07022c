// A triangle mesh, one per category of clay.
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cuda/mpm/lattice.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"

namespace knead {

struct Mesh {
    int category = 0;
    std::vector<Vec3<float>> vertices;  // [m]
    std::vector<Vec3<float>> normals;   // unit, outward; one per vertex
    std::vector<Int3> triangles;        // vertex indices, counter-clockwise seen from outside
    // Per vertex, where SurfaceOptions::moving: how far it has come along its normal since the
    // surface before [m]. Empty: nothing is known of that.
    std::vector<float> advance;
};

enum class Smoothing { none, laplace, taubin };

// How a surface is made from particles.
struct SurfaceOptions {
    Lattice<float> lattice;  // of the density; independent of the simulation's
    float iso = 0.5f;        // share of the rest density where the surface stands
    Smoothing smoothing = Smoothing::taubin;
    int iterations = 5;
    bool moving = false;  // it is told how the surface moves, for who shows it later
};

// The lattice of a density over the box of the simulation's, with so many nodes along its longest
// side; the others have whole blocks.
Lattice<float> surface_lattice(const Lattice<double>& clay, int nodes);

// What is kept of a surface, to tell how the next one moves: densities by category. None: nothing.
struct Field;
struct SurfacePast {
    std::map<int, std::shared_ptr<const Field>> densities;
};

// Particles that no surface shows.
struct SurfaceStats {
    long unusable = 0;  // not finite, or of no material, or of no volume
    long outside = 0;   // too near the lattice's border, or beyond it
};

// One closed mesh per category dense enough to have a surface, by rising category. Density is in
// units of rest density: every particle adds its mass / its material's density / cell volume.
// Throws std::invalid_argument for a rule without meaning, std::runtime_error for a lattice too
// large. The same bits for any number of threads. `past` of the surface before, if any, becomes
// that of this one, where the rule has `moving`.
std::vector<Mesh> surface(const std::vector<Particle<double>>& particles,
                          const std::vector<Material<double>>& materials,
                          const SurfaceOptions& options, SurfaceStats* stats = nullptr,
                          SurfacePast* past = nullptr);

// Volume enclosed [m^3], positive for outward triangles.
double volume(const Mesh& mesh);
// Pieces of the mesh that share no vertex.
int components(const Mesh& mesh);

// Colour of a category, linear RGB, distinct for the first dozen.
Vec3<float> category_colour(int category);

}  // namespace knead
