// The splats of a scene that is played: those that follow clay, kept dense, and those that stand
// still where no hand is near.
#pragma once
#include <memory>

#include "host/assets/splat_object.h"
#include "host/session/local_clay.h"
#include "host/session/session.h"

namespace knead {

class SceneSplats {
  public:
    // Of a scene that was built of these objects.
    SceneSplats(const Scene& scene, const std::vector<SplatObject>& objects);
    SceneSplats(const SceneSplats&) = delete;

    bool local() const { return around_hands != nullptr; }
    bool changes() const { return moving.any() || local(); }  // from frame to frame

    // After a frame, which its row hears of: splats are split and added, and where hands come or
    // go, clay. True if clay was brought or taken.
    bool after(const Frame& frame, FrameRow& row, Solver& solver);

    // All of them as of the last refresh(): in the order of the solver's Gaussians, then those that
    // stand still.
    const SplatCloud& drawn() const { return local() ? shown : moving.cloud(); }
    void refresh();

    // For checkpoints, of a scene without local clay.
    const CarriedSplats& state() const { return moving.state(); }
    void set_state(const CarriedSplats& state) { moving.set_state(state); }

  private:
    SplatUpkeep moving;
    std::unique_ptr<LocalClay> around_hands;  // null: no object has a depth
    SplatCloud shown;                         // of a scene with local clay
};

}  // namespace knead
