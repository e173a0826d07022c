// The splats of a scene that is played: those that follow clay, kept dense, and those that stand
// still where no hand is near.
#pragma once
#include <functional>
#include <memory>

#include "host/assets/splat_object.h"
#include "host/session/local_clay.h"
#include "host/session/session.h"

namespace knead {

class SceneSplats {
  public:
    // Of a scene that was built of these objects and outlives this.
    SceneSplats(const Scene& scene, const std::vector<SplatObject>& objects);
    SceneSplats(const SceneSplats&) = delete;

    bool local() const { return around_hands != nullptr; }
    bool changes() const { return moving.any() || local(); }  // from frame to frame

    // After a frame, which its row hears of: splats are split and added where that is due, and
    // where hands come or go, clay. True if clay was brought or taken.
    bool after(const Frame& frame, FrameRow& row, Solver& solver);
    // The same for who has splats split and added beside frames: clay, and what came of a task of
    // upkeep(), but not while clay is on its way back, beside frames, too. That begins last, after
    // refresh(): from then on a thread has what stands still.
    bool follow_hands(const Frame& frame, FrameRow& row, Solver& solver);
    void begin_leaving(const Frame& frame, Solver& solver);
    // As if hands had come and gone again before anything moved, so that memory, graphs and threads
    // are there when they come; false where there is no local clay. The splats are as before, and
    // the solver's clay; both have been edited, and drawn() is to be refreshed. `frames` is called
    // with the clay there and with hands that are far away, and must leave the solver as it was.
    bool rehearse(Solver& solver, const std::function<void(const Motion& away)>& frames);
    bool leaving() const { return local() && around_hands->leaving(); }
    // That ends now, which edits the solver; true if some was on its way.
    bool end_leaving(Solver& solver) { return leaving() && around_hands->end_leaving(solver); }
    const SplatUpkeep& upkeep() const { return moving; }
    void adopt(UpkeepPlan plan, FrameRow& row, Solver& solver);
    // The tools are others from now on; so is the material of an object, which the solver is told:
    // softened where the scene asks for that (`step.soften_beyond`).
    void set_rig(const Rig& rig);
    void set_material(int object, const Material<double>& material, Solver& solver);

    // All of them as of the last refresh(): in the order of the solver's Gaussians, then those that
    // stand still.
    const SplatCloud& drawn() const { return local() ? *shown : moving.cloud(); }
    std::shared_ptr<const SplatCloud> picture() const;  // of drawn(), which stays as it is
    void refresh();

    // For checkpoints. Throws std::invalid_argument for a state that is not whole.
    const CarriedSplats& state() const { return moving.state(); }
    LocalState local_state() const { return local() ? around_hands->state() : LocalState{}; }
    void set_state(const CarriedSplats& state, const LocalState& of_local);

  private:
    const Scene& scene;
    SplatUpkeep moving;
    std::unique_ptr<LocalClay> around_hands;    // null: no object has a depth
    std::shared_ptr<SplatCloud> shown, before;  // of a scene with local clay
};

}  // namespace knead
