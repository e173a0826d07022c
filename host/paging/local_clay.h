// A large scene of splats stands still, and is clay only where hands are. Space is divided into
// cubes of two blocks of nodes; those that a hand comes near get particles under the scene's
// surface and their splats become Gaussians of the solver, before the hand touches them. Cubes that
// all hands have left give their splats back, where they are and as they were deformed by then.
// docs/method/splats.md.
#pragma once
#include <future>
#include <vector>

#include "host/paging/frozen_splats.h"
#include "host/paging/local_state.h"
#include "host/scene/scene.h"
#include "host/splats/upkeep.h"

namespace knead {

struct LocalReport {
    std::size_t cubes = 0, particles = 0, splats = 0;  // that are clay now
    std::size_t taken = 0, given_back = 0;             // cubes, in this frame
};

class LocalClay {
  public:
    // Of a scene whose objects were loaded and built: `object` is the one with a `depth`, `cloud`
    // its splats. `moving` are the splats of the solver's Gaussians; what becomes clay joins them.
    LocalClay(const Scene& scene, int object, SplatCloud cloud, SplatUpkeep& moving);

    // After the frame of that number: clay for where the tools will be at the end of the next one,
    // if they go on as in `motion`; back with what they have left, now and then.
    LocalReport after(int frame, const Motion& motion, Solver& solver);
    // The same in two halves, for who does not wait for what goes back: a thread finds out where it
    // stands, and it goes after a later frame. The thread has what stands still from the second
    // half on: after all that is to be shown of this frame, and not in one in which clay came.
    LocalReport follow(const Motion& motion, Solver& solver);
    void begin_leaving(int frame, const Motion& motion, Solver& solver);
    // Some clay is on its way back: no one else may edit the solver's Gaussians or remove clay.
    bool leaving() const { return evicting.valid(); }
    // It goes back now. True if some was on its way.
    bool end_leaving(Solver& solver) { return end_leaving(solver, true) > 0; }

    // All joints amid what stands, at one of its splats; none where nothing may become clay.
    Motion over_ground() const;

    // The tools are others from now on.
    void set_rig(const Rig& by) { rig = by; }
    // If the object is the one that stands still: its clay is of this material from now on.
    void set_material(int object, const Material<double>& material, Solver& solver);

    // What follows, but for set_state(), throws std::logic_error while clay is on its way back.
    const LocalState& state() const { return settled(); }
    // Of the same scene. The solver and the splats that move must be those of then, too. Throws as
    // check().
    void set_state(LocalState state);

    // Those that move, in the order of the solver's Gaussians, then those that stand still: all of
    // the cloud, whose memory may serve.
    void show(SplatCloud& all) const;
    const SplatCloud& still() const { return settled().cloud; }
    bool stands(std::size_t splat) const { return !settled().active[splat]; }  // one of still()

  private:
    using Key = Cubes::Key;

    Boxes boxes_of(const Motion& motion) const;
    std::vector<Key> cubes_near(const Boxes& boxes, double reach) const;
    std::vector<Key> around(const std::vector<Key>& cubes) const;
    void put(std::uint32_t splat);
    void take(const std::vector<Key>& wanted, const Boxes& boxes, Solver& solver);
    void take_splats(Solver& solver);
    std::vector<Key> wanted_for(const Boxes& boxes) const;
    std::vector<Key> left_by(const Boxes& boxes) const;

    struct EvictResult {
        std::vector<int> objects;
        std::vector<std::uint32_t> slots;  // of splats that stand again
        CarriedSplats stay;                // that move still
        std::vector<int> slot_of;          // theirs
    };
    const LocalState& settled() const;
    bool leaves(Key cube) const;
    std::size_t begin_leaving(std::vector<Key> cubes, Solver& solver);
    std::size_t end_leaving(Solver& solver, bool now);
    EvictResult settle(const CarriedSplats& carried, SomeGaussians back, std::vector<int> objects);
    void put_at(const SplatCloud& now, std::vector<std::uint32_t> slots,
                const std::vector<Gaussian<double>>& as);
    int first_stratum(int cube) const;
    std::vector<Vec3<double>> seeds(Int3 cube, int layer, const class CubeHeights& heights,
                                    const class Cells& there) const;
    std::vector<std::vector<Particle<double>>> all_seeds(const std::vector<Key>& cubes,
                                                         const class LocalSurface& surface,
                                                         const Cells& there) const;
    void add_clay(const std::vector<Key>& cubes, std::vector<std::vector<Particle<double>>> found,
                  Solver& solver);
    bool between_walls(Vec3<double> x) const;

    Rig rig;
    WallOptions walls;
    int ground;  // object that stands
    Material<double> material;
    double depth, dx, spacing;  // of the clay, cells, particles [m]
    double reach;               // from a tool to what moves [m]
    double per_cell;
    unsigned seed;

    SplatUpkeep& moving;
    LocalState state_;
    Cubes tiling;
    FrozenSplats standing;  // slots between the walls
    std::vector<Key> on_way_back;
    // The thread has state_, but for `clay`, and `standing`.
    std::future<EvictResult> evicting;
};

}  // namespace knead
