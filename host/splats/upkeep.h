// Keeps the splats of a solver's Gaussians dense while clay is shaped: on the host, through the
// solver's edits, between frames or beside them. docs/method/splats.md.
#pragma once
#include <memory>

#include "host/solver/solver.h"
#include "host/splats/refill.h"
#include "host/splats/split.h"

namespace knead {

struct UpkeepOptions {
    bool splits = false, refills = false;
    int every = 5;             // frames from one time to the next
    std::size_t capacity = 0;  // splats in all; 0: three times as many as there were
    SplitOptions split;
    RefillOptions refill;

    bool any() const { return splits || refills; }
};

struct UpkeepReport {
    std::size_t split = 0, added = 0;  // splats that became two, and that were added
    std::size_t waiting = 0;           // for budget or capacity
};

// What upkeep comes to, for the splats that it began with.
struct UpkeepPlan {
    std::shared_ptr<CarriedSplats> splats;  // as they will be
    GaussianEdits edits;
    std::size_t waiting = 0;
};

// What is to be looked at: a copy that any thread may follow.
struct UpkeepTask {
    UpkeepOptions options;
    std::shared_ptr<const CarriedSplats> splats;
    int refilled = 0;  // objects below

    // Of a solver's particles and Gaussians, and its rules.
    UpkeepPlan plan(const SnapshotData& held, const Setup& rules) const;
};

class SplatUpkeep {
  public:
    // Of the splats of a solver's Gaussians, in their order.
    SplatUpkeep(const UpkeepOptions& options, SplatCloud cloud);

    const SplatCloud& cloud() const { return splats->cloud; }
    const CarriedSplats& state() const { return *splats; }
    std::shared_ptr<const CarriedSplats> shared() const { return splats; }
    void set_state(CarriedSplats state);
    // Of who brings Gaussians, `more` at once, and takes them away. What a task or a picture holds
    // stays as it is.
    CarriedSplats& change(std::size_t more = 0);
    // There may come so many more, which the default of the capacity is to hear of.
    void expect(std::size_t more);
    // From this object on none gets new splats: where all but one side of the clay is out of sight.
    void refill_below(int object) { refilled = object; }
    bool any() const { return options.any() && splats->count() > 0; }
    bool due(int frame) const { return any() && frame % options.every == 0; }

    // After the frame of that number, with no frame under way: where it is due, splats are split
    // and added. The clay does not hear of it. Throws std::logic_error where the solver takes no
    // edits.
    UpkeepReport after(int frame, Solver& solver);
    // The same in two halves, between which frames may pass, but no other edits.
    UpkeepTask task() const { return {options, splats, refilled}; }
    UpkeepReport adopt(UpkeepPlan plan, Solver& solver);

  private:
    UpkeepOptions options;
    std::shared_ptr<CarriedSplats> splats, spare;
    int refilled = 0x7fffffff;
};

}  // namespace knead
