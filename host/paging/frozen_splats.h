// Frozen splats, indexed by cube, and the surface patches fitted to them. The patches of a cube are
// computed when a hand comes near and cached until its splats change. Splats of activated clay
// remain in the index at their positions before activation: clay that hands have not reached yet
// is seeded under the original surface.
#pragma once
#include <unordered_map>
#include <vector>

#include "cuda/math/box.h"
#include "host/paging/local_surface.h"
#include "host/paging/patches.h"
#include "host/splats/cloud.h"

namespace knead {

using Boxes = std::vector<Box3<double>>;  // [m]

class FrozenSplats {
  public:
    FrozenSplats(const Cubes& by, double cell) : cubes(by), dx(cell) {}

    // `slot`: index of a splat in the cloud. `x`: its centre [m].
    void clear() { all.clear(); }
    void put(std::uint32_t slot, Vec3<double> x);
    // Slots that were not put are ignored. Precondition: `cloud` holds the positions of put().
    void remove(std::vector<std::uint32_t> slots, const SplatCloud& cloud);
    // Call when splats move within a cube: invalidates its patches.
    void touch(Cubes::Key cube);
    // Slots of the splats in a cube; in ascending order after fit_patches().
    const std::vector<std::uint32_t>& in(Cubes::Key cube) const;

    // Fits the patches of these cubes where they are out of date. Fills `normal`, by slot, where it
    // is zero: perpendicular to the plane fitted to the neighbouring centres, towards the nearest
    // of the boxes `hands`, because hands come from outside.
    void fit_patches(const std::vector<Cubes::Key>& at, const SplatCloud& cloud,
                     std::vector<Vec3<float>>& normal, const Boxes& hands);
    // The patches of these cubes. Precondition: fit_patches() has been called for them.
    std::vector<SurfacePatch> surface(const std::vector<Cubes::Key>& at) const;

  private:
    struct Cube {
        std::vector<std::uint32_t> slots;
        std::vector<Patch> patches;
        std::vector<SurfacePatch> surface;
        bool known = false;
    };
    std::vector<Cube*> there(const std::vector<Cubes::Key>& at);

    Cubes cubes;
    double dx;
    std::unordered_map<Cubes::Key, Cube> all;
};

}  // namespace knead
