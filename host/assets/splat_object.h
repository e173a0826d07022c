// Objects of a scene that are photographs: their clouds read, placed, and filled with particles.
#pragma once
#include "host/assets/fill.h"
#include "host/scene/scene.h"

namespace knead {

// The splats of one object of a scene, in the simulation's frame [m]. They are attached to it in
// this order.
struct SplatObject {
    int object = 0;
    SplatCloud cloud;
    std::size_t surface = 0;  // the first are the file's; the others lie inside
    FillReport report;
    std::size_t beyond = 0;  // splats left out because they lay behind a wall
    bool local = false;      // of a scene that stands still: none is attached to anything
};

// Reads the files of the scene's objects of shape `splats`, and gives those objects their size,
// particles and places of splats, for build(). In the order of the objects; none where there is no
// such object. Throws InputError with the object's place for a file that is no cloud or holds no
// object, MemoryError for more than `memory` bytes.
std::vector<SplatObject> load_splats(Scene& scene, std::size_t memory);

// All their splats as one cloud, in the order in which a solver has their Gaussians; or those of
// the scenes that stand still. The degree of the harmonics is the highest of all.
SplatCloud joined(const std::vector<SplatObject>& objects, bool local = false);

}  // namespace knead
