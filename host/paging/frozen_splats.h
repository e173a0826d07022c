// The splats of a large scene by the cubes that they lie in, and what they tell of its surface:
// patches of them, found once for each cube that a hand comes near, until its splats change. Splats
// that have become clay are told of as they were: what hands have not reached yet lies under the
// surface of then.
#pragma once
#include <unordered_map>
#include <vector>

#include "host/paging/local_surface.h"
#include "host/paging/patches.h"
#include "host/splats/cloud.h"

namespace knead {

using Boxes = std::vector<std::pair<Vec3<double>, Vec3<double>>>;  // corners [m]

class FrozenSplats {
  public:
    FrozenSplats(const Cubes& by, double cell) : cubes(by), dx(cell) {}

    // Splats by their slots in a cloud.
    void clear() { all.clear(); }
    void put(std::uint32_t slot, Vec3<double> x);
    // Those of these slots that were put, before they move.
    void remove(std::vector<std::uint32_t> slots, const SplatCloud& cloud);
    // Some of this cube's move and stay in it.
    void touch(Cubes::Key cube);
    // Those in a cube; in rising order once look() was asked for it.
    const std::vector<std::uint32_t>& in(Cubes::Key cube) const;

    // Finds what the splats of these cubes tell. `normal`, by slot: of those that have none,
    // across the plane through the centres around, towards the nearest of the boxes: hands come
    // from outside.
    void look(const std::vector<Cubes::Key>& at, const SplatCloud& cloud,
              std::vector<Vec3<float>>& normal, const Boxes& hands);
    // Of cubes that were looked at.
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
