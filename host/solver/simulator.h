// Interface of a simulator, common to all back ends: constructed from a Setup, then advanced frame
// by frame. What can be edited and saved is an EditableSimulator (editable_simulator.h).
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cuda/contact/contact.h"
#include "cuda/contact/skinning.h"
#include "cuda/math/box.h"
#include "host/solver/counters.h"
#include "host/solver/frame_stats.h"
#include "host/solver/setup.h"

namespace knead {

// Joints of the rig at the start and the end of a frame, in the simulation's coordinates and scale.
struct Motion {
    std::vector<Joint<double>> from, to;  // at least as many each as the rig's spheres index
    std::vector<char> active{};           // per tool; missing entries: active
    // Per tool, factor of its radii; missing entries: 1. A tool that appears inside clay at full
    // size would throw it: grow it over some tenths of a second.
    std::vector<float> size{};
    // Per tool, scale relative to the rig in this frame; missing entries: 1. Precondition:
    // positive.
    std::vector<Stretch<float>> stretch{};

    Stretch<float> stretch_of(std::size_t tool) const
    {
        return tool < stretch.size() ? stretch[tool] : Stretch<float>{};
    }
};

// Progress of a frame between two substeps.
struct FrameProgress {
    int substeps = 0;
    double reached = 0, duration = 0;  // [s]: simulated so far; of the whole frame
};
// Called on the thread that advances or collects; return true to end the frame early. CPU: called
// after every substep but the last of a frame. GPU: called every 20 ms of a frame that takes more
// than 30 ms; the frame ends a few substeps later, and a frame submitted behind it is cut at its
// start.
using StopCheck = std::function<bool(const FrameProgress&)>;

// Wall time of one stage over one frame [s]; the names are those of the profiler ranges.
struct StageTime {
    std::string name;
    double seconds;
};

namespace gpu {
struct Clay;            // cuda/surface/surface.cuh: device pointers of a simulator's particles
struct MovedGaussians;  // cuda/splats/deform.cuh: and of its Gaussians
}  // namespace gpu

// Costs of the stages of the last frame.
class StageProfile {
  public:
    virtual ~StageProfile() = default;
    virtual const std::vector<StageTime>& times() const = 0;
    // Hardware counters of the GPU per stage. Empty if unsupported; throws std::runtime_error if
    // they cannot be read.
    virtual std::vector<StageWork> counts() const { return {}; }
};

class EditableSimulator;

class Simulator {
  public:
    virtual ~Simulator() = default;
    // Simulates `duration` [s] with the tools moving along `motion`.
    virtual FrameStats advance(const Motion& motion, double duration) = 0;
    // Asynchronous variant of advance(): a frame can be submitted while the previous one is being
    // computed. At most two frames are in flight; meanwhile call only submit() and collect().
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

    // Replaces the check of all later frames; an empty function removes it.
    void set_stop_check(StopCheck check) { stop_check = std::move(check); }

    // Bounds the next submitted frame: if it is not complete after `most` substeps, it ends there,
    // as cut, in the state of a frame that a StopCheck has ended there. 0: no bound. Later frames
    // are unbounded and whole, also one submitted behind it.
    void set_substep_bound(int most) { next_bound = most; }

    // This simulator, if it can be edited and saved, else null.
    virtual EditableSimulator* editable() { return nullptr; }
    const EditableSimulator* editable() const { return const_cast<Simulator*>(this)->editable(); }

    // Version of the state; incremented by each frame with substeps, edit and restore. Equal
    // versions: nothing to redraw.
    virtual long version() const { return 0; }
    virtual std::size_t particle_count() const { return particles().size(); }
    // The particles in unspecified order (deterministic for equal runs).
    virtual std::vector<Particle<double>> particles() const = 0;
    // In the order of attachment.
    virtual std::vector<Gaussian<double>> gaussians() const { return {}; }
    // Positions of the particles in a box [m], in unspecified order.
    virtual std::vector<Vec3<double>> places(const Box3<double>& box) const;
    // Depth [m] of every particle inside a tool at the end of the last frame; others are omitted.
    virtual std::vector<double> penetration() const = 0;
    // Velocity [m/s] that (8) interpolated from the lattice for each particle in the last substep,
    // in the order of particles(). Differs from Particle::v for particles found in a tool (19):
    // their v is the exit velocity, which the clay around damps before it moves anything. Empty if
    // no tool was active; equal to Particle::v after an edit or a profile.
    virtual std::vector<Vec3<double>> velocities() const { return {}; }
    // Device pointers of the particles, for building the surface; null on the CPU.
    virtual const gpu::Clay* clay() const { return nullptr; }
    // Device pointers of the Gaussians, for drawing; null on the CPU.
    virtual const gpu::MovedGaussians* moved_gaussians() const { return nullptr; }
    // Null if stages are not measured.
    virtual const StageProfile* profile() const { return nullptr; }
    virtual std::size_t memory() const = 0;  // [bytes]
    virtual std::string name() const = 0;    // "cpu float, ...", "cuda: NVIDIA H200"

  protected:
    bool has_stop_check() const { return bool(stop_check); }
    // Call once at the start of each frame: its bound, or 0.
    int take_substep_bound() { return std::exchange(next_bound, 0); }
    // Call after each substep. Returns whether the frame ends here and records it in `stats`.
    bool ends_here(double reached, double duration, FrameStats& stats, int bound = 0) const
    {
        stats.cut = (bound > 0 && stats.substeps >= bound) ||
                    (stop_check && stop_check({stats.substeps, reached, duration}));
        if (stats.cut) stats.reached = reached;
        return stats.cut;
    }

  private:
    StopCheck stop_check;
    int next_bound = 0;
    std::vector<FrameStats> done;
};

// Empty if they are not measured.
inline std::vector<StageTime> stage_times(const Simulator& simulator)
{
    const StageProfile* profile = simulator.profile();
    return profile ? profile->times() : std::vector<StageTime>{};
}

}  // namespace knead
