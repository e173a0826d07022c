#include "host/ui/moved_objects.h"

#include <utility>

#include "host/document/reduce.h"
#include "host/ui/session_line.h"

namespace knead {

std::string why_not_moved(const LiveState& state, const DocumentPtr& document,
                          const std::vector<ObjectId>& objects)
{
    const std::vector<ObjectRef> refs(objects.begin(), objects.end());
    const Command moves = MoveObjects{refs, Vec3<double>{1e-3, 0, 0}, {}, {}};
    if (std::string why = why_not(moves, state); !why.empty()) return why;
    IdSource unused;
    const auto result = reduce(document, moves, unused);
    const Refusal* const refusal = std::get_if<Refusal>(&result);
    return refusal ? refusal->text() : std::string();
}

ObjectPreviews object_previews(const std::vector<Mesh>& surfaces, const Document& document,
                               const ObjectPlaces& places, const std::vector<ObjectId>& objects,
                               double thick)
{
    ObjectPreviews made;
    PartedMeshes around = parted(surfaces, document, places, objects);
    for (const ObjectId id : objects) {
        const ObjectPlace* const one = places.find(id);
        if (!one) continue;
        std::vector<Mesh> own;
        if (objects.size() == 1)
            own = std::exchange(around.some, {});
        else
            own = parted(around.some, document, places, {id}).some;
        // The object of splats has no surface; the box is seen around a preview inside the clay.
        own.push_back(box_corners({one->box.low, one->box.high}, thick));
        for (Mesh& mesh : own) made.objects.push_back({std::move(mesh), one->centre});
    }
    made.others = std::move(around.others);
    return made;
}

HandLook preview_look(const ObjectPreview& of,
                      const std::function<Vec3<double>(Vec3<double> x, Vec3<double> own)>& at,
                      const Quat<double>& turn)
{
    Mesh mesh = of.mesh;
    const Quat<float> q = cast<float>(turn);
    for (Vec3<float>& x : mesh.vertices) x = cast<float>(at(cast<double>(x), of.centre));
    for (Vec3<float>& n : mesh.normals) n = rotate(q, n);
    return mark_look(std::move(mesh), chosen_colour, 0.5f);
}

}  // namespace knead
