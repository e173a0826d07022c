// Turns a photographed object into clay: finds its solid, fills it with particles, and adds
// interior splats for cuts. docs/method/splats.md.
#pragma once
#include "host/assets/clean.h"
#include "host/assets/interior.h"

namespace knead {

struct FillOptions {
    double cell = 0;      // cell of the solver's lattice, in the cloud's unit [m], more than 0
    double per_cell = 8;  // particles per cell, at least 1
    unsigned seed = 1;
    CleanOptions clean;
    SolidOptions solid;
    double interior_spacing = 0;          // [m]; 0: the particle spacing
    double min_depth_in_half_axes = 2.5;  // minimum depth of an interior splat, in its half axes
    std::size_t max_interior = 200000;    // splats
    std::size_t max_bytes = std::size_t(4) << 30;
};

struct FillReport {
    CleanReport clean;
    double volume = 0;            // of the solid [m^3]
    double unlit = 0;             // volume that no light reaches [m^3]
    double found = 0;             // fraction of `unlit` inside the solid
    double grid_spacing = 0;      // spacing of the solid's grid [m]
    std::size_t thin = 0;         // particles in parts too thin for the grid
    double interior_spacing = 0;  // as used [m]
};

struct FilledObject {
    SplatCloud splats;
    std::size_t surface = 0;  // the first are the file's, cleaned; the others are interior
    std::vector<Vec3<double>> particles;  // [m]
    double particle_volume = 0;           // of each [m^3]
    FillReport report;
};

// Throws std::invalid_argument for options out of range, InputError if no object is found, and
// MemoryError, before allocation, if options.max_bytes would be exceeded. Bitwise equal for any
// number of threads.
FilledObject fill(const SplatCloud& cloud, const FillOptions& options);
// The same for a cloud that was cleaned before, and possibly moved, rotated or scaled since.
FilledObject fill(const SplatCloud& cloud, const CleanCloud& cleaned, const FillOptions& options);

}  // namespace knead
