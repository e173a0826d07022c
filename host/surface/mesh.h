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
    // Per vertex, if SurfaceOptions::moving: displacement along its normal since the previous
    // surface [m]. Empty: unknown.
    std::vector<float> advance;
    std::vector<Vec3<float>> colours;  // per vertex, linear RGB; empty: that of its category
};

enum class Smoothing { none, laplace, taubin };

// Options for the surface of particles.
struct SurfaceOptions {
    Lattice<float> lattice;  // of the density; independent of the solver's lattice
    float iso = 0.5f;        // isovalue, as a fraction of the rest density
    Smoothing smoothing = Smoothing::taubin;
    int iterations = 5;
    bool moving = false;  // compute Mesh::advance
};

// Density lattice over the box of the solver's lattice, with `nodes` nodes along its longest side;
// the others are rounded to whole blocks.
Lattice<float> surface_lattice(const Lattice<double>& clay, int nodes);

// Densities of a surface by category, from which the next one computes Mesh::advance. Empty:
// unknown.
struct Field;
struct SurfaceHistory {
    std::map<int, std::shared_ptr<const Field>> densities;
};

// Particles that are not part of any surface.
struct SurfaceStats {
    long unusable = 0;  // non-finite, without material, or without volume
    long outside = 0;   // too close to the border of the lattice, or beyond it
};

// One closed mesh per category dense enough to have a surface, in ascending order. Density is in
// units of rest density: every particle adds its mass / its material's density / cell volume.
// Throws std::invalid_argument for invalid options, std::runtime_error for a lattice that is too
// large. Bitwise equal for any number of threads. If options.moving, `past` holds the densities of
// the previous surface, or is empty, and is set to the densities of this surface.
std::vector<Mesh> surface(const std::vector<Particle<double>>& particles,
                          const std::vector<Material<double>>& materials,
                          const SurfaceOptions& options, SurfaceStats* stats = nullptr,
                          SurfaceHistory* past = nullptr);

// Enclosed volume [m^3], positive for outward triangles.
double volume(const Mesh& mesh);
// Number of connected components.
int components(const Mesh& mesh);

// Colour of a category, linear RGB, distinct for the first dozen.
Vec3<float> category_colour(int category);
Vec3<double> category_srgb(int category);  // the same in sRGB, 0 to 1

void move_by(std::vector<Mesh>& meshes, Vec3<double> by);  // [m]

}  // namespace knead
