// Local clay: in a large splat scene only the surroundings of the hands are simulated. Space is
// partitioned into cubes of 2x2x2 blocks of nodes. A cube is activated before a hand touches it: it
// is filled with particles under the scene's surface, and its splats become Gaussians of the
// solver. Once all hands have left, it is frozen again: its splats keep their positions and
// deformation. docs/method/splats.md.
#pragma once
#include <future>
#include <vector>

#include "host/paging/frozen_splats.h"
#include "host/paging/local_state.h"
#include "host/scene/scene.h"
#include "host/splats/upkeep.h"

namespace knead {

struct LocalReport {
    std::size_t cubes = 0, particles = 0, splats = 0;  // active now
    std::size_t activated = 0, frozen = 0;  // cubes activated and cubes frozen in this frame
};

class LocalClay {
  public:
    // Precondition: the scene's objects are loaded and built. `object`: index of the object with
    // local clay (`depth` > 0); `cloud`: its splats. `carried`: the splats of the solver's
    // Gaussians; activated splats are appended to it. Throws std::invalid_argument if the spherical
    // harmonics of `cloud` and `carried` differ in degree.
    LocalClay(const Scene& scene, int object, SplatCloud cloud, SplatUpkeep& carried);

    // Call after frame `frame`. Activates cubes near the positions that the tools reach at the end
    // of the next frame if `motion` continues; every 32 frames freezes the cubes that all tools
    // have left.
    LocalReport after(int frame, const Motion& motion, EditableSimulator& solver);
    // Asynchronous variant: begin_freezing() starts a thread that computes the frozen positions; a
    // later follow() removes the cubes. Call begin_freezing() after write_all() of the same frame,
    // and only if follow() has activated nothing: from then on the thread owns the frozen splats.
    LocalReport follow(const Motion& motion, EditableSimulator& solver);
    void begin_freezing(int frame, const Motion& motion, EditableSimulator& solver);
    // True while cubes are being frozen. Meanwhile the solver's Gaussians must not be edited and
    // clay must not be removed elsewhere.
    bool freezing() const { return evicting.valid(); }
    void decide_by(std::function<bool(bool ready)> by) { take = std::move(by); }
    // Waits for the thread and removes the cubes. Returns whether any were being frozen.
    bool finish_freezing(EditableSimulator& solver) { return finish_freezing(solver, true) > 0; }

    // A motion that holds all joints at the splat nearest to the middle of the domain; empty if
    // there is no splat between the walls.
    Motion motion_at_centre() const;

    // Replaces the tools.
    void set_rig(const Rig& by) { rig = by; }
    // Sets the material of active and future clay. No effect unless `object` is the local clay.
    void set_material(int object, const Material<double>& material, EditableSimulator& solver);

    // The functions below, except set_state(), throw std::logic_error while freezing().
    const LocalState& state() const { return checked_state(); }
    // Restores a state of the same scene. The solver and the moving splats must be restored to the
    // same frame. Throws std::invalid_argument as check() does.
    void set_state(LocalState state);

    // Writes all splats to `all`, reusing its memory: the moving ones in the order of the solver's
    // Gaussians, then the frozen ones.
    void write_all(SplatCloud& all) const;
    const SplatCloud& slots_cloud() const { return checked_state().cloud; }
    // Whether a splat of slots_cloud() is frozen.
    bool is_frozen(std::size_t splat) const { return !checked_state().active[splat]; }

  private:
    using Key = Cubes::Key;

    Boxes boxes_of(const Motion& motion) const;
    std::vector<Key> cubes_near(const Boxes& boxes, double reach) const;
    std::vector<Key> around(const std::vector<Key>& cubes) const;
    void index_splat(std::uint32_t splat);
    void activate(const std::vector<Key>& wanted, const Boxes& boxes, EditableSimulator& solver);
    void attach_splats(EditableSimulator& solver);
    std::vector<Key> cubes_to_activate(const Boxes& boxes) const;
    std::vector<Key> cubes_to_freeze(const Boxes& boxes) const;

    struct EvictResult {
        std::vector<int> objects;
        std::vector<std::uint32_t> slots;  // of splats that are frozen now
        CarriedSplats stay;                // splats that remain active
        std::vector<int> slot_of;          // slots of `stay`
    };
    const LocalState& checked_state() const;
    bool is_freezing(Key cube) const;
    std::size_t begin_freezing(std::vector<Key> cubes, EditableSimulator& solver);
    std::size_t finish_freezing(EditableSimulator& solver, bool now);
    EvictResult compute_frozen(const CarriedSplats& carried_splats, SomeGaussians back,
                               std::vector<int> objects);
    void store_frozen(const SplatCloud& now, std::vector<std::uint32_t> slots,
                      const std::vector<Gaussian<double>>& as);
    int first_stratum(int cube) const;
    std::vector<Vec3<double>> seeds(Int3 cube, int layer, const class CubeHeights& heights,
                                    const class Cells& there) const;
    std::vector<std::vector<Particle<double>>> all_seeds(const std::vector<Key>& cubes,
                                                         const class LocalSurface& surface,
                                                         const Cells& there) const;
    void add_clay(const std::vector<Key>& cubes, std::vector<std::vector<Particle<double>>> found,
                  EditableSimulator& solver);
    bool between_walls(Vec3<double> x) const;

    Rig rig;
    WallOptions walls;
    int ground;  // index of the object with local clay
    Material<double> material;
    double depth, dx, spacing;  // depth of the clay, cell size, particle spacing [m]
    double reach;               // from a tool to the edge of active clay [m]
    double per_cell;
    unsigned seed;

    SplatUpkeep& carried;
    LocalState state_;
    Cubes tiling;
    FrozenSplats frozen;                   // those between the walls
    std::function<bool(bool ready)> take;  // see SceneSplats::decide_by()
    std::vector<Key> freezing_cubes;       // cubes being frozen, in ascending order
    // While valid, the thread owns `frozen` and all of state_ but `clay`.
    std::future<EvictResult> evicting;
};

}  // namespace knead
