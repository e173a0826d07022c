// Photographed objects of a scene: reads their clouds, places them, and fills them with particles.
#pragma once
#include <string>
#include <vector>

#include "host/assets/fill.h"
#include "host/scene/scene.h"

namespace knead {

// The splats of one object of a scene, in the simulation's frame [m], in the order in which they
// are attached to it.
struct SplatObject {
    int object = 0;
    SplatCloud cloud;
    std::size_t surface = 0;  // number of file splats, which come first; the others are interior
    FillReport report;
    std::size_t beyond = 0;              // splats dropped because they lie beyond a wall
    bool local = false;                  // local clay: none is attached initially
    std::size_t dropped = 0;             // splats of the file that cannot be drawn
    std::vector<std::string> remarks{};  // of the reading (host/files/splat_file.h)
};

// Reads the files of the scene's objects of shape `splats`, and sets the objects' size, particles
// and splat positions for build(). Returns them in object order; empty if there are none. Throws
// InputError with the object's place for a file that is not a cloud or contains no object,
// MemoryError for more than `memory` bytes.
std::vector<SplatObject> load_splats(Scene& scene, std::size_t memory);

// Concatenates the objects' splats into one cloud, in the order of the solver's Gaussians; if
// `local`, only the splats of local clay. The cloud's degree is the maximum of all.
SplatCloud joined(const std::vector<SplatObject>& objects, bool local = false);

}  // namespace knead
