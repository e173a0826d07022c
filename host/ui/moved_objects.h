// What moving objects with a mouse and with hands have in common: whether it can be done, and how
// they are shown meanwhile.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "host/picture/outline.h"
#include "host/ui/panel_model.h"

namespace knead {

// Why the objects cannot be moved; "": they can.
std::string why_not_moved(const LiveState& state, const DocumentPtr& document,
                          const std::vector<ObjectId>& objects);

struct ObjectPreview {
    Mesh mesh;              // of the surface, and the corners of its box
    Vec3<double> centre{};  // of mass
};
struct ObjectPreviews {
    std::vector<ObjectPreview> objects;
    std::vector<Mesh> others;  // surfaces of all other clay
};
// Of the surfaces as they are. `thick`: width of lines [m].
ObjectPreviews object_previews(const std::vector<Mesh>& surfaces, const Document& document,
                               const ObjectPlaces& places, const std::vector<ObjectId>& objects,
                               double thick);
// At another place: `at` moves a point, given the object's centre of mass.
HandLook preview_look(const ObjectPreview& of,
                      const std::function<Vec3<double>(Vec3<double> x, Vec3<double> own)>& at,
                      const Quat<double>& turn);

}  // namespace knead
