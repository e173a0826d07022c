// State of a scene without its clay, as an immutable value. Commands (command.h) make new documents
// of it; the particles of the clay are in the solver. docs/method/document.md.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/scene/scene.h"
#include "host/scene/strand.h"
#include "host/solver/material_spec.h"

namespace knead {

// Of an object; 0: none. A scene's file's objects have 1, 2, ... in its order, again after reset
// and open. Objects added later have rising numbers, which are not reused for added objects in a
// session.
struct ObjectId {
    std::uint32_t value = 0;
    auto operator<=>(const ObjectId&) const = default;
};

// Where an object's clay came from. The clay itself is in the solver.
struct ObjectSource {
    ShapeKind shape = ShapeKind::sphere;
    Vec3<double> size{};      // as in Object [m]; of splats and meshes: 0
    Vec3<double> velocity{};  // of new clay [m/s]
    double per_cell = 8;      // particles per cell
    SplatsOptions splats;     // of shape `splats`
    double rounding = 0;      // of a rounded box [m]
    std::string text{};       // of shape `text`; its outline is that of the system's font
    std::shared_ptr<const Strand> strand{};  // of shape `strand`
    MeshOptions mesh{};                      // of shape `mesh`
};

// All poses are in the frame of the scene's file.
struct SceneObject {
    ObjectId id;
    std::string name;         // a label: several objects may have the same
    int category = 0;         // 0 to 255; a surface is made per category
    MaterialSpec material{};  // as stated; its name is that of the preset
    RigidMotion<double> pose{{1, 0, 0, 0}, {0, 0, 0}};  // from the object's frame [m]
    ObjectSource source;
    // Every command on it is refused, except SetFlags and the end of Carry.
    bool locked = false;
    bool hidden = false;  // its category is not drawn if all objects of the category are hidden
    std::optional<Vec3<double>> colour{};  // sRGB, 0 to 1; none: that of its category
};

struct SceneSettings {
    Vec3<double> gravity{};  // [m/s^2]
    WallOptions walls{};     // in the frame of the scene's file [m]
    BodyContact contact{};   // of objects of unlike category
    int cells = 0;           // of the lattice, along its longest axis
    int surface_nodes = 0;   // along the longest axis of the surface's lattice
};

struct HandSettings {
    std::string held[side_count];  // "": the bare hand; else a tool's name
    bool present[side_count] = {true, true};
    double zoom = 1;    // simulation metres per real metre
    Vec3<double> at{};  // of the tracker's origin in the frame of the scene's file [m]
};

// Objects, settings and hands are shared between copies by pointer; a copy copies pointers only.
struct Document {
    std::vector<std::shared_ptr<const SceneObject>> objects;  // in the order of their ids
    std::shared_ptr<const SceneSettings> scene = std::make_shared<const SceneSettings>();
    std::shared_ptr<const HandSettings> hands = std::make_shared<const HandSettings>();

    const SceneObject* find(ObjectId id) const;  // nullptr: there is none
    std::vector<int> hidden_categories() const;  // those whose objects are all hidden
};
using DocumentPtr = std::shared_ptr<const Document>;

// Full extents in the object's own frame [m]; of shape `splats`, and of a mesh that has not been
// loaded: 0.
Vec3<double> own_extents(const SceneObject& object);

// Whether a nozzle lays its clay, or that of any object.
inline bool is_open(const SceneObject& object)
{
    return object.source.strand && object.source.strand->open;
}
bool has_nozzle(const Document& document);

bool has_velocity(const Document& document);  // new clay of an object has one

constexpr int most_objects = 256;
constexpr std::uint32_t highest_id = 0x7fffffff;
constexpr int fewest_surface_nodes = 8, most_surface_nodes = 1024;

// To the bit: 0 and -0 differ.
bool equal(Vec3<double> a, Vec3<double> b);
bool equal(const MaterialSpec& a, const MaterialSpec& b);
bool equal(const SceneObject& a, const SceneObject& b);
bool equal(const SceneSettings& a, const SceneSettings& b);
bool equal(const HandSettings& a, const HandSettings& b);
bool equal(const Document& a, const Document& b);
std::uint64_t hash(const Document& document);  // of document_text() (document_text.h)

// The document of a scene as read, or built: its objects have the ids 1, 2, ... in their order.
Document document_of(const Scene& scene);
// `scene` with the objects, gravity, walls, surface and hands of the document, not built yet. The
// lattice is unchanged. Throws InputError where the scene reader would.
Scene scene_of(Scene scene, const Document& document);

// An object as scenes and documents write it.
SceneObject scene_object(const Object& object, ObjectId id);
Object object_of(const SceneObject& object);

// The hands of a scene with the settings of a document. `origin`: Scene::origin [m].
HandsOptions hands_with(HandsOptions hands, const HandSettings& settings, Vec3<double> origin);
HandSettings settings_of(const HandsOptions& hands, Vec3<double> origin);

}  // namespace knead
