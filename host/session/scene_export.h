// Writes the surface or the splats of a running scene to a file: the command `export`.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/document/export_plan.h"
#include "host/session/loop.h"
#include "host/splats/cloud.h"

namespace knead {

// What a scene shows, in the simulation's frame. The functions may be slow, and are called at most
// once, by write_export().
struct ShownScene {
    DocumentPtr document;
    Vec3<double> origin{};                         // Scene::origin [m]
    std::map<ObjectId, std::vector<int>> numbers;  // of the objects in the simulator
    std::function<Meshes()> surface;
    std::shared_ptr<const SplatCloud> splats;  // SceneSplats::drawn(); null: there are none
    std::function<std::vector<Gaussian<double>>()> gaussians;  // of the first of them; null: none
};

// Throws OutputError; InputError for splats that the format cannot represent;
// std::invalid_argument if there is nothing to write. Precondition: `plan` is of the scene's
// document.
void write_export(const std::string& file, const ExportPlan& plan, const ShownScene& scene);

// A cloud of the simulation's frame, in the frame of the scene's file, with `scale` units per
// metre, rotated by half a turn about x: axes of clouds point right, down, forward.
SplatCloud splats_for_file(const SplatCloud& cloud, Vec3<double> origin, double scale = 1);

}  // namespace knead
