// A scene: objects, tools and their motion, and duration. Read from JSON ("schema":
// "knead.scene/1"; comments allowed; docs/reference/formats.md lists every key, unit and default).
#pragma once
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "cuda/math/vec.h"
#include "cuda/mpm/material_data.h"
#include "host/hands/hands_options.h"
#include "host/scene/captions.h"
#include "host/solver/material_spec.h"
#include "host/solver/setup.h"
#include "host/splats/upkeep.h"
#include "host/surface/mesh.h"

namespace knead {

enum class ShapeKind {
    sphere,
    box,
    cylinder,
    splats,
    ellipsoid,
    rounded_box,
    cone,
    capsule,
    torus,
    text,
    strand,
    mesh
};
enum class UpAxis { x, minus_x, y, minus_y, z, minus_z };

// A photographed object, of shape `splats`: its file and its pose in the scene.
struct SplatsOptions {
    std::string file;
    UpAxis up = UpAxis::minus_y;  // which axis of the file points up
    double size = 0;              // longest extent [m]
    double turn = 0;              // about the vertical, once upright [degrees]
    // Above 0: local clay (host/paging/local_clay.h): only material near hands and at most this
    // deep below the surface [m] is simulated. 0: the object is a solid, simulated as a whole.
    double depth = 0;
};
// Particles of an object of shape `splats`, in the simulation's frame. Made by
// host/assets/splat_object.h; build() adds them to the setup.
struct ObjectParticles {
    std::vector<Vec3<double>> particles;  // [m]
    double volume = 0;                    // of each [m^3]
    std::vector<Vec3<double>> splats;     // their centres [m]
    Vec3<double> middle{};                // centre of the box that contains the object [m]
};

// The mesh of an object of shape `mesh`: its file and how it lies and how large it is in the scene.
struct MeshOptions {
    std::string file;
    UpAxis up = UpAxis::y;  // which axis of the file points up
    double turn = 0;        // about the vertical, once upright [degrees]
    double size = 0;        // longest extent [m]; 0: by `scale`
    double scale = 0;       // of a unit of the file [m]; 0: by `size`
    double hollow = 0;      // thickness of a wall below the surface [m]; 0: solid
};

class Letters;    // letters.h
struct Strand;    // strand.h
class SolidMesh;  // solid_mesh.h

struct Object {
    bool local() const { return shape == ShapeKind::splats && splats.depth > 0; }
    std::string name;
    ShapeKind shape = ShapeKind::sphere;
    Vec3<double> centre{};  // [m]
    // Full extents [m], in the object's frame; the axis of cylinder, cone (apex up), capsule and
    // torus is y. Of a text: 0, the height of a capital, its depth; of a strand and a mesh: 0. Of
    // shape `splats`: in the scene's frame, set on loading; box_of() is the box of any object.
    Vec3<double> size{};
    double rounding = 0;  // of a rounded box: radius of its edges [m]
    std::string text;     // of shape `text`: UTF-8, read along x, seen from +z
    // From the object's frame to the scene's frame; the object turns about its centre.
    Quat<double> rotation{1, 0, 0, 0};
    Vec3<double> velocity{};      // [m/s]
    MaterialSpec stated{};        // the material as the user stated it, before softening
    Material<double> material{};  // simulated; mass and volume are set when particles are made
    double softer = 1;            // factor by which the given stiffness was divided
                                  // (step.soften_beyond)
    int category = 0;
    double per_cell = 8;   // particles per cell of the solver
    SplatsOptions splats;  // of shape `splats`
    std::shared_ptr<const ObjectParticles> given;
    std::shared_ptr<const Letters> letters;  // of `text`; add_letters() sets them
    std::shared_ptr<const Strand> strand;    // of shape `strand`
    MeshOptions mesh;                        // of shape `mesh`
    std::shared_ptr<const SolidMesh> solid;  // of shape `mesh`, once its file is loaded
};

enum class ClockMode { wall, paper };
// All positions are in the simulation's frame: position in the file minus `origin`.
struct Scene {
    std::string name, path;
    Setup setup;            // complete after build(), which adds particles, rig and tools
    Int3 stated_cells{};    // of the domain; setup.lattice may have more: move_in()
    Vec3<double> origin{};  // of the simulation's frame in that of the file [m]; move_in()
    std::vector<Object> objects;
    bool own_pieces = false;  // pieces that were cut or torn off become objects
    HandsOptions hands;
    bool has_hands = false;
    ClockMode clock = ClockMode::wall;
    double frame_rate = 90;      // frames per second of wall time
    int paper_substeps = 5;      // clock "paper": substeps of paper_dt per frame
    double paper_dt = 1e-4;      // [s]
    int most_substeps = 100000;  // limit per frame; a scene that needs more is rejected
    int soften_beyond = 0;       // substeps per frame; stiffer materials are softened; 0: never
    int frames = 0;              // 0: length of the recording, or 1 s without one
    int surface_nodes = 0;       // along the longest axis of the density lattice; 0: twice the
                                 // solver's
    SurfaceOptions surface;
    unsigned seed = 1;
    Vec3<double> eye{1.1, 0.9, 1.6}, target{0.5, 0.4, 0.5};  // camera [m]
    UpkeepOptions upkeep;                                    // of objects of splats
    int picture_every = 0;  // frames between pictures; 0: no pictures
    int picture_width = 960, picture_height = 720;
    std::vector<Caption> captions;  // drawn into the pictures
};

// Materials by name: clay, soft-clay, plasticine, wet-sand, snow, jelly, dough, viscous-liquid.
// Throws InputError that suggests the nearest name.
Material<double> preset(const std::string& name);
const std::vector<std::string>& preset_names();

// Reads a scene and applies `settings` ("path.key=value") in order. Throws InputError.
Scene read_scene(const std::string& path, const std::vector<std::string>& settings = {});
// The same from the text of a file; relative paths in it are resolved against `path`.
Scene parse_scene(const std::string& text, const std::string& path,
                  const std::vector<std::string>& settings = {});

// Simulated time per frame [s]: 1 / frame_rate, or paper_substeps * paper_dt with clock "paper".
// The hands advance by 1 / frame_rate in both cases.
double frame_duration(const Scene& scene);

// Throws InputError for a scene without objects, which may be read and built, but not simulated by
// what needs clay.
void need_objects(const Scene& scene);

// Fills setup.particles, Gaussians, rig and tools from the objects and hands; none of the first two
// without objects. Precondition: objects of shape `splats` are loaded. Throws InputError for an
// object without particles, and MemoryError before allocating if the particles would not fit into
// `memory` bytes.
void build(Scene& scene, std::size_t memory);

}  // namespace knead
