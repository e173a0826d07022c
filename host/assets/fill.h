// A photographed object becomes clay: its solid is found, filled with particles, and given splats
// inside, which a cut shows. docs/method/splats.md.
#pragma once
#include "host/assets/clean.h"
#include "host/assets/interior.h"

namespace knead {

struct FillOptions {
    double cell = 0;      // of the solver's lattice, in the cloud's unit [m], more than 0
    double per_cell = 8;  // particles, at least 1
    unsigned seed = 1;
    CleanOptions clean;
    SolidOptions solid;
    double interior_spacing = 0;        // [m]; 0: that of the particles
    double bury = 2.5;                  // half axes of an inner splat, under the surface
    std::size_t max_interior = 200000;  // splats
    std::size_t max_bytes = std::size_t(4) << 30;
};

struct FillReport {
    CleanReport clean;
    double volume = 0;            // of the solid [m^3]
    double unlit = 0;             // of what no light reaches [m^3], and
    double found = 0;             // the share of it that is in the solid
    double grid_spacing = 0;      // that the solid was found on [m]
    std::size_t thin = 0;         // particles of parts too thin for the grid
    double interior_spacing = 0;  // as used [m]
};

struct FilledObject {
    SplatCloud splats;
    std::size_t surface = 0;  // the first are the file's, cleaned; the others lie inside
    std::vector<Vec3<double>> particles;  // [m]
    double particle_volume = 0;           // of each [m^3]
    FillReport report;
};

// Throws std::invalid_argument for a rule out of range, InputError where there is no object to
// find, MemoryError, before taking it, for more memory than the rule's. The same bits for any
// number of threads.
FilledObject fill(const SplatCloud& cloud, const FillOptions& options);
// The same of a cloud that was cleaned before; moved, turned and scaled since it may have been.
FilledObject fill(const SplatCloud& cloud, const CleanCloud& cleaned, const FillOptions& options);

}  // namespace knead
