// A scene: what is simulated, with which tools, moved how, for how long. Read from JSON
// ("schema": "knead.scene/1"; comments allowed; docs/reference/formats.md names every key, unit and
// default).
#pragma once
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "cuda/mpm/material_data.h"
#include "host/hands/hands_options.h"
#include "host/scene/captions.h"
#include "host/solver/solver.h"
#include "host/splats/upkeep.h"
#include "host/surface/mesh.h"

namespace knead {

enum class ShapeKind { sphere, box, cylinder, splats };
enum class UpAxis { x, minus_x, y, minus_y, z, minus_z };

// A photographed object, of shape `splats`: its file, and how it stands in the scene.
struct SplatsOptions {
    std::string file;
    UpAxis up = UpAxis::minus_y;  // which axis of the file points up
    double size = 0;              // longest extent [m]
    double turn = 0;              // about the vertical, once upright [degrees]
    // Above 0: a scene that stands still. Where hands are, what lies up to so far [m] under its
    // surface is clay (host/paging/local_clay.h). 0: a solid, clay as a whole.
    double depth = 0;
};
// What such an object is made of, where build() puts it: host/assets/splat_object.h finds it.
struct ObjectParticles {
    std::vector<Vec3<double>> particles;  // [m]
    double volume = 0;                    // of each [m^3]
    std::vector<Vec3<double>> splats;     // their centres [m]
};

struct Object {
    bool local() const { return shape == ShapeKind::splats && splats.depth > 0; }
    std::string name;
    ShapeKind shape = ShapeKind::sphere;
    Vec3<double> centre{};        // [m]
    Vec3<double> size{};          // full extents [m]; a cylinder stands on y
    Vec3<double> velocity{};      // [m/s]
    Material<double> material{};  // mass and volume are filled in when particles are made
    double softer = 1;            // so many times as it was given (step.soften_beyond)
    std::string preset;           // name of the material, as given
    int category = 0;
    double per_cell = 8;   // particles per cell
    SplatsOptions splats;  // of shape `splats`; centre and size are known once it is loaded
    std::shared_ptr<const ObjectParticles> given;
};

enum class ClockMode { wall, paper };
// Every place in it is in the simulation's frame: the one in the file, less `origin`.
struct Scene {
    std::string name, path;
    Setup setup;            // all but particles, rig and tools, until build() is called
    Vec3<double> origin{};  // of the simulation's frame in that of the file [m]; move_in()
    std::vector<Object> objects;
    HandsOptions hands;
    bool has_hands = false;
    ClockMode clock = ClockMode::wall;
    double frame_rate = 90;      // frames per second of wall time
    int paper_substeps = 5;      // clock "paper": substeps of paper_dt a frame
    double paper_dt = 1e-4;      // [s]
    int most_substeps = 100000;  // of a frame; a scene that asks for more is refused
    int soften_beyond = 0;       // substeps a frame; stiffer materials are made softer; 0: none is
    int frames = 0;              // 0: as long as the recording, or 1 s
    int surface_nodes = 0;       // of the density lattice's longest axis; 0: twice the lattice's
    SurfaceOptions surface;
    unsigned seed = 1;
    Vec3<double> eye{1.1, 0.9, 1.6}, target{0.5, 0.4, 0.5};  // camera [m]
    UpkeepOptions upkeep;                                    // of objects of splats
    int picture_every = 0;  // frames from picture to picture; 0: none
    int picture_width = 960, picture_height = 720;
    std::vector<Caption> captions;  // in its pictures
};

// Presets by name: clay, soft-clay, plasticine, wet-sand, snow, jelly, dough, viscous-liquid.
// Throws InputError naming the nearest one.
Material<double> preset(const std::string& name);
const std::vector<std::string>& preset_names();

// Reads a scene and applies `settings` ("path.key=value") in order. Throws InputError.
Scene read_scene(const std::string& path, const std::vector<std::string>& settings = {});
// The same of the file's text; the files that it names are looked for beside `path`.
Scene parse_scene(const std::string& text, const std::string& path,
                  const std::vector<std::string>& settings = {});

// Simulated per frame [s]. Clock "paper": the hands cover a displayed frame's path in less of it.
double frame_duration(const Scene& scene);

// Fills setup.particles, Gaussians, rig and tools from the objects and hands. Objects of shape
// `splats` must have been loaded. Throws InputError for an empty scene, or where the particles
// would not fit into `memory` bytes (said before allocating).
void build(Scene& scene, std::size_t memory);

}  // namespace knead
