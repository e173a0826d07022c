// The splats of a scene that is played: those that follow clay, kept dense, and those that stand
// still where no hand is near.
#pragma once
#include <functional>
#include <memory>

#include "host/assets/splat_object.h"
#include "host/paging/local_clay.h"
#include "host/scene/scene.h"

namespace knead {

// What a frame changed of the splats and of local clay.
struct PagingReport {
    long splats_split = 0, splats_added = 0, splats_waiting = 0;
    long cubes = 0;                              // that are clay after the frame
    long cubes_taken = 0, cubes_given_back = 0;  // activated and frozen by it

    bool clay_changed() const { return cubes_taken + cubes_given_back > 0; }
    bool any() const { return clay_changed() || splats_split + splats_added > 0; }
};

class SceneSplats {
  public:
    // Of a scene that was built of these objects and outlives this.
    SceneSplats(const Scene& scene, const std::vector<SplatObject>& objects);
    SceneSplats(const SceneSplats&) = delete;

    bool local() const { return around_hands != nullptr; }
    bool changes() const { return moving.any() || local(); }  // from frame to frame

    // Call after the frame of that number, with the motion of its tools: splits and adds splats
    // where needed, activates and freezes cubes of local clay.
    PagingReport after(int frame, const Motion& motion, Solver& solver);
    // The same in parts, for callers that plan splats on a thread beside the frames: first adopt()
    // what a task of upkeep() planned, unless leaving(); then activate cubes; last, after refresh()
    // and only in frames that activated none, begin to freeze others: from then on a thread owns
    // the frozen splats.
    void follow_hands(const Motion& motion, PagingReport& report, Solver& solver);
    void begin_leaving(int frame, const Motion& motion, Solver& solver);
    // As if hands had come and gone again before anything moved, so that memory, graphs and threads
    // are there when they come; false where there is no local clay. The splats are as before, and
    // the solver's clay; both have been edited, and drawn() is to be refreshed. `frames` is called
    // with the clay there and with hands that are far away, and must leave the solver as it was.
    bool rehearse(Solver& solver, const std::function<void(const Motion& away)>& frames);
    bool leaving() const { return local() && around_hands->leaving(); }
    // That ends now, which edits the solver; true if some was on its way.
    bool end_leaving(Solver& solver) { return leaving() && around_hands->end_leaving(solver); }
    const SplatUpkeep& upkeep() const { return moving; }
    void adopt(UpkeepPlan plan, PagingReport& report, Solver& solver);
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
