// What a picture shows, as one list of vertices and triangles: clay as meshed, hands as the sampled
// hulls of their medial spheres.
#pragma once
#include <vector>

#include "render/painter.h"

namespace knead {

// One vertex as the graphics card reads it.
struct PaintVertex {
    Vec3<float> place;   // [m]
    Vec3<float> normal;  // about unit
    Vec3<float> colour;  // linear RGB
    float skin;          // 0 clay, 1 hand
    float advance = 0;   // Mesh::advance [m]
};

// Triangles [first, first + count) of Geometry::triangles.
struct Range {
    int first, count;
};

struct Geometry {
    std::vector<PaintVertex> vertices;
    // Clay, then of each hand hulls, skins, and coarser hulls to cast shadows; then unseen clay.
    std::vector<Int3> triangles;
    Range clay;                        // that is seen
    std::vector<Range> seen, casting;  // besides
};

// The hull of a medial primitive: for each direction n of a sphere split `level` times, the
// support point max over i of (c_i . n + r_i), with normal n. Inscribed; exact at its vertices.
// Nothing is added for a primitive that is not finite.
void add_hull(Geometry& geometry, const DrawPrimitive& primitive, int level, Vec3<float> colour,
              float skin = 1);

// A mesh of one colour, `skin` 0 clay to 1 hand. As of gather(): triangles with a vertex that is
// not finite are left out; throws std::invalid_argument for what `name` says cannot be drawn.
void add_mesh(Geometry& geometry, const Mesh& mesh, Vec3<float> colour, float skin,
              const std::string& name);
// The same of clay, in the colour of its category.
void add_clay(Geometry& geometry, const Mesh& mesh);

constexpr Vec3<float> skin_colour{0.74f, 0.46f, 0.35f};  // linear RGB
constexpr int fine_hull = 3, coarse_hull = 2;            // 1280 and 320 triangles a primitive

// Triangles with a vertex that is not finite are left out. Throws std::invalid_argument for a
// triangle that names no vertex, a missing normal, or a primitive not of 1 to 3 spheres.
Geometry gather(const std::vector<Mesh>& meshes, const std::vector<HandLook>& hands,
                const std::vector<Mesh>& unseen = {});

// The same of one hand, behind what is there.
struct HandRanges {
    Range seen, casting;  // they share the skins
};
HandRanges add_hand(Geometry& geometry, const HandLook& hand);

// The ball about all that is seen or casts a shadow, within a cube of half side `reach` about
// `target`, so that one stray vertex does not spoil the shadows. Radius [m], positive.
struct Ball {
    Vec3<float> centre;
    float radius;
};
Ball around(Vec3<float> low, Vec3<float> high, Vec3<float> target, float reach);  // a box
Ball around(const Geometry& geometry, Vec3<float> target, float reach);

}  // namespace knead
