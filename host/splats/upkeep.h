// Upkeep of the splats attached to a solver's Gaussians: splits and adds splats as clay is shaped.
// Runs on the host, between frames or concurrently, through the solver's edits.
// docs/method/splats.md.
#pragma once
#include <memory>

#include "host/solver/editable_simulator.h"
#include "host/splats/refill.h"
#include "host/splats/split.h"

namespace knead {

struct UpkeepOptions {
    bool splits = false, refills = false;
    int every = 5;             // interval in frames
    std::size_t capacity = 0;  // total splats; 0: three times the initial number
    SplitOptions split;
    RefillOptions refill;

    bool any() const { return splits || refills; }
};

struct UpkeepReport {
    std::size_t split = 0, added = 0;  // splats that were split, and splats that were added
    std::size_t waiting = 0;           // not split or added for lack of budget or capacity
};

// Result of upkeep. Indices refer to the splats of its task.
struct UpkeepPlan {
    std::shared_ptr<CarriedSplats> splats;  // after the edits
    GaussianEdits edits;
    std::size_t waiting = 0;
};

// Input of upkeep: a copy, which any thread may process.
struct UpkeepTask {
    UpkeepOptions options;
    std::shared_ptr<const CarriedSplats> splats;
    int refilled = 0;  // only objects below this index are refilled

    // From a solver's particles and Gaussians, and its scene.
    UpkeepPlan plan(const SnapshotData& held, const SimulationConfig& rules) const;
};

class SplatUpkeep {
  public:
    // `cloud`: the splats of a solver's Gaussians, in their order.
    SplatUpkeep(const UpkeepOptions& options, SplatCloud cloud);

    const SplatCloud& cloud() const { return splats->cloud; }
    const CarriedSplats& state() const { return *splats; }
    std::shared_ptr<const CarriedSplats> shared() const { return splats; }
    void set_state(CarriedSplats state);
    // Mutable access to the state, for callers that add up to `more` Gaussians or remove some
    // through the solver themselves. Copy on write: copies held by tasks and pictures do not
    // change.
    CarriedSplats& change(std::size_t more = 0);
    // Raises the default capacity as if there were `more` further initial splats.
    void raise_capacity(std::size_t more);
    // Disables refilling for this object and all after it: objects whose clay is visible from one
    // side only.
    void refill_below(int object) { refilled = object; }
    bool any() const { return options.any() && splats->count() > 0; }
    bool due(int frame) const { return any() && frame % options.every == 0; }

    // Call after frame `frame`, with no frame in progress. If due, splits and adds splats; the clay
    // is not affected. Throws std::logic_error if the solver is not editable.
    UpkeepReport after(int frame, EditableSimulator& solver);
    // Asynchronous variant: between task() and adopt() frames may run, but no other edits.
    UpkeepTask task() const { return {options, splats, refilled}; }
    UpkeepReport adopt(UpkeepPlan plan, EditableSimulator& solver);

  private:
    UpkeepOptions options;
    std::shared_ptr<CarriedSplats> splats, spare;
    int refilled = 0x7fffffff;
};

}  // namespace knead
