// Keeps the splats of a solver's Gaussians dense while clay is shaped: between frames, on the host,
// through the solver's edits. docs/splats.md.
#pragma once
#include "host/solver/solver.h"
#include "host/splats/refill.h"
#include "host/splats/split.h"

namespace knead {

struct UpkeepRule {
    bool splits = false, refills = false;
    int every = 5;             // frames from one time to the next
    std::size_t capacity = 0;  // splats in all; 0: three times as many as there were
    SplitRule split;
    RefillRule refill;

    bool any() const { return splits || refills; }
};

struct UpkeepReport {
    std::size_t split = 0, added = 0;  // splats that became two, and that were added
    std::size_t waiting = 0;           // for budget or capacity
};

class SplatUpkeep {
  public:
    // Of the splats of a solver's Gaussians, in their order.
    SplatUpkeep(const UpkeepRule& rule, SplatCloud cloud);

    const SplatCloud& cloud() const { return splats.cloud; }
    const CarriedSplats& state() const { return splats; }
    void set_state(CarriedSplats state) { splats = std::move(state); }
    CarriedSplats& state() { return splats; }  // of who brings Gaussians and takes them away
    // There may come so many more, which the default of the capacity is to hear of.
    void expect(std::size_t more);
    // From this object on none gets new splats: where all but one side of the clay is out of sight.
    void refill_below(int object) { refilled = object; }
    bool any() const { return rule.any() && splats.count() > 0; }

    // After the frame of that number, with no frame under way: where it is due, splats are split
    // and added. The clay does not hear of it. Throws std::logic_error where the solver takes no
    // edits.
    UpkeepReport after(int frame, Solver& solver);

  private:
    UpkeepRule rule;
    CarriedSplats splats;
    int refilled = 0x7fffffff;
};

}  // namespace knead
