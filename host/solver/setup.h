// What a simulator is constructed from: configuration, initial state and execution options.
#pragma once
#include <vector>

#include "cuda/contact/contact.h"
#include "cuda/mpm/body_contact.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"
#include "cuda/mpm/sleep.h"
#include "cuda/mpm/time_step.h"
#include "cuda/mpm/walls.h"
#include "cuda/splats/deform.h"
#include "host/solver/rig.h"

namespace knead {

// Limits of the substep length dt.  (22)
struct StepOptions {
    double fixed = 0;       // [s]; 0: chosen by stability
    double courant = 0.97;  // dt <= courant * stability limit of a single particle
    double tool = 0.5;      // dt <= tool * min(r, dx) / |v of a tool|
    double largest = 1e-2;  // [s]
};

// The model: everything that decides the result besides the initial state. Edits change it.
struct SimulationConfig {
    Lattice<double> lattice{};
    WallOptions walls{};
    Vec3<double> gravity{};                   // [m/s^2]
    std::vector<Material<double>> materials;  // one per object
    Rig rig;                                  // of all tools; Primitive::tool indexes `tools`
    std::vector<Tool<double>> tools;
    StepOptions step;
    bool grid_contact = true;  // apply tool contact to grid velocities
    int passes = 1;            // projection passes per substep; 0: no particle projection
    Rest<double> rest{};       // sleeping: which clay is not moved
    BodyContact contact{};     // of objects of unlike category
    bool cuts = false;  // particles carry labels of a cut (cut.h), even if no tool is a blade now
};

struct InitialState {
    std::vector<Particle<double>> particles;
    std::vector<Gaussian<double>> gaussians;  // attached to the objects' clay
};

// How the computation runs; without effect on the model.
struct ExecutionOptions {
    bool deterministic = false;  // equal runs give equal bits; always so on a CPU
    int threads = 0;             // CPU; 0: all
};

struct Setup : SimulationConfig, InitialState, ExecutionOptions {};

}  // namespace knead
