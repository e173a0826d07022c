// The simulator behind one face, whatever it runs on: set up once, then advanced frame by frame.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "cuda/contact/contact.h"
#include "cuda/contact/skinning.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"
#include "cuda/mpm/sleep.h"
#include "cuda/mpm/time_step.h"
#include "cuda/mpm/walls.h"
#include "host/solver/counters.h"
#include "host/solver/rig.h"

namespace knead {

// How long a substep may be.  (22)
struct StepRule {
    double fixed = 0;       // [s]; 0: as stability asks
    double courant = 0.4;   // dt <= courant * dx / (c + |v|)
    double tool = 0.5;      // dt <= tool * min(r, dx) / |v of a tool|
    double largest = 1e-2;  // [s]
};

struct Setup {
    Lattice<double> lattice{};
    Walls<double> walls{};
    Vec3<double> gravity{};                   // [m/s^2]
    std::vector<Material<double>> materials;  // one per object
    std::vector<Particle<double>> particles;
    Rig rig;  // all tools; Primitive::tool indexes `tools`
    std::vector<Tool<double>> tools;
    StepRule step;
    bool grid_contact = true;  // the grid feels the tools
    int passes = 2;            // of particle projection a substep; 0: none
    Rest<double> rest{};       // which clay need not move
    bool deterministic = false;
    int threads = 0;  // CPU: 0 = all
};

// The joints that the rig hangs on at the two ends of a frame, in the simulation's frame and size.
struct Motion {
    std::vector<Joint<double>> from, to;  // as many each as the rig's spheres name, or more
    std::vector<char> active;             // per tool; tools beyond its end are active
};

extern const char* const limit_names[int(Limit::count)];

// What one frame did.
struct FrameStats {
    int substeps = 0;
    double dt_min = 0, dt_max = 0;                 // [s]
    long limits[int(Limit::count)] = {};           // substeps cut by each limit
    long yielded = 0, projected = 0;               // particle-substeps
    long clipped = 0, confined = 0, repaired = 0;  // guards: nodes slowed, particles put back
    double found_depth = 0;                        // deepest before projection [m]
    long active_blocks = 0;                        // of the last substep
    long moved = 0;  // particle-substeps: less than their product where clay was still
    long woken = 0;  // blocks of still clay that were pushed
};

// Wall time of a stage over one frame [s]; names are those of the profiler ranges.
struct StageTime {
    std::string name;
    double seconds;
};

namespace gpu {
struct Clay;  // cuda/surface/surface.cuh: where a solver keeps its particles on the device
}

class Solver {
  public:
    virtual ~Solver() = default;
    // Simulates `duration` [s] with the tools moving along `motion`.
    virtual FrameStats advance(const Motion& motion, double duration) = 0;
    // The same in two halves, so that a frame may be handed over while the one before it is still
    // being computed. At most two are under way; nothing else is asked meanwhile.
    virtual void submit(const Motion& motion, double duration)
    {
        done.push_back(advance(motion, duration));
    }
    virtual FrameStats collect()
    {
        const FrameStats first = done.at(0);
        done.erase(done.begin());
        return first;
    }
    // The particles in no particular order (deterministic for equal runs).
    virtual std::vector<Particle<double>> particles() const = 0;
    // Depth [m] of every particle inside a tool at the end of the last frame; 0 entries left out.
    virtual std::vector<double> penetration() const = 0;
    virtual const std::vector<StageTime>& stage_times() const = 0;
    // What a GPU's counters say of the stages of the last frame. Empty where there are none; throws
    // std::runtime_error where they cannot be read.
    virtual std::vector<StageWork> stage_counts() const { return {}; }
    // Where the particles are on the device, for its surface; null where they are not on one.
    virtual const gpu::Clay* clay() const { return nullptr; }
    virtual std::size_t memory() const = 0;  // bytes held
    virtual std::string name() const = 0;    // "cpu float, ...", "cuda: NVIDIA H200"

  private:
    std::vector<FrameStats> done;
};

// In float. In double there is the Reference (host/solver/reference.h).
std::unique_ptr<Solver> cpu_solver(const Setup& setup);
// Throws std::runtime_error where there is no device. Declared always; without CUDA it only throws.
std::unique_ptr<Solver> gpu_solver(const Setup& setup, int device);
bool gpu_present();
// How often the host has waited for a device so far.
long gpu_waits();

}  // namespace knead
