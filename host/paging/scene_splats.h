// All splats of a running scene: splats that follow clay, kept dense by splitting and adding, and
// frozen splats where no hand is near.
#pragma once
#include <functional>
#include <memory>
#include <span>

#include "host/assets/splat_object.h"
#include "host/paging/local_clay.h"
#include "host/scene/scene.h"

namespace knead {

// Changes of the splats and of local clay in one frame.
struct PagingReport {
    long splats_split = 0, splats_added = 0, splats_waiting = 0;
    long cubes = 0;                              // active after the frame
    long cubes_activated = 0, cubes_frozen = 0;  // activated and frozen by it

    bool clay_changed() const { return cubes_activated + cubes_frozen > 0; }
    bool any() const { return clay_changed() || splats_split + splats_added > 0; }
};

class SceneSplats {
  public:
    // Precondition: `scene` was built of these objects. It must outlive this.
    SceneSplats(const Scene& scene, const std::vector<SplatObject>& objects);
    SceneSplats(const SceneSplats&) = delete;

    bool local() const { return local_clay != nullptr; }
    bool changes() const { return carried.any() || local(); }  // from frame to frame

    // Call after frame `frame`, with the motion of its tools: splits and adds splats where needed,
    // activates and freezes cubes of local clay.
    PagingReport after(int frame, const Motion& motion, EditableSimulator& solver);
    // The same in parts, for callers that plan splats on a thread while frames run. First adopt()
    // the result of a task of upkeep(), unless freezing(). Then activate cubes. Last, after
    // refresh() and only in frames that have activated no cube, begin to freeze cubes: from then on
    // a thread owns the frozen splats.
    void follow_hands(const Motion& motion, PagingReport& report, EditableSimulator& solver);
    void begin_freezing(int frame, const Motion& motion, EditableSimulator& solver);
    // Warm-up: activates cubes and freezes them again, so that memory, graphs and threads exist
    // when hands arrive. `frames` is called in between with a motion of hands that are far away,
    // and must leave the solver unchanged. Afterwards splats and clay are as before, but count as
    // edited: call refresh(). Returns false if there is no local clay.
    bool rehearse(EditableSimulator& solver, const std::function<void(const Motion& away)>& frames);
    bool freezing() const { return local() && local_clay->freezing(); }
    // Waits for the cubes being frozen and removes them from the solver; true if there were any.
    bool finish_freezing(EditableSimulator& solver)
    {
        return freezing() && local_clay->finish_freezing(solver);
    }
    // Asked before the result of a freezing thread is taken, with whether it is ready; if not,
    // taking it waits. Without this function it is taken once it is ready.
    void decide_by(std::function<bool(bool ready)> take)
    {
        if (local()) local_clay->decide_by(std::move(take));
    }
    const SplatUpkeep& upkeep() const { return carried; }
    void adopt(UpkeepPlan plan, PagingReport& report, EditableSimulator& solver);
    // Replaces the tools.
    void set_rig(const Rig& rig);
    // Adds an object of splats whose clay the solver has as `number`, and attaches its splats.
    // Precondition: the object is not local. Throws as EditableSimulator::attach; then nothing has
    // changed.
    void add_object(int number, const SplatObject& object, EditableSimulator& solver);
    // Replaces all splats that follow clay, and the solver's Gaussians: one for each, in this
    // order. Precondition: no local clay. Throws as EditableSimulator::set_gaussians; then nothing
    // has changed.
    void replace(const std::vector<Gaussian<double>>& gaussians, CarriedSplats all,
                 EditableSimulator& solver);
    // Removes objects with their splats. Precondition: none of them is local clay.
    void remove_objects(std::span<const int> numbers, EditableSimulator& solver);
    // Sets the material and the category of an object, in the solver too, softened by the scene's
    // `step.soften_beyond`. Throws std::invalid_argument for an unknown object or an invalid
    // material.
    void set_material(int object, const Material<double>& material, EditableSimulator& solver);

    // All splats as of the last refresh(): in the order of the solver's Gaussians, then the frozen
    // ones.
    const SplatCloud& drawn() const { return local() ? *front : carried.cloud(); }
    std::shared_ptr<const SplatCloud> picture() const;  // drawn(), immutable while held
    void refresh();

    // For checkpoints. set_state() throws std::invalid_argument for an inconsistent state.
    const CarriedSplats& state() const { return carried.state(); }
    LocalState local_state() const { return local() ? local_clay->state() : LocalState{}; }
    void set_state(const CarriedSplats& state, const LocalState& of_local);

  private:
    const Scene& scene;
    SplatUpkeep carried;
    std::unique_ptr<LocalClay> local_clay;    // null: no object has a depth
    std::shared_ptr<SplatCloud> front, back;  // of a scene with local clay
};

}  // namespace knead
