// Geometry of a picture as one list of vertices and triangles: meshed clay, and hands as sampled
// hulls of their medial spheres.
#pragma once
#include <vector>

#include "cuda/math/box.h"
#include "render/painter.h"

namespace knead {

// A vertex, in the layout of the GL buffer.
struct PaintVertex {
    Vec3<float> place;   // [m]
    Vec3<float> normal;  // approximately unit
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
    // In order: clay; per hand its hulls, skins, and coarser hulls for shadows; unseen clay.
    std::vector<Int3> triangles;
    Range clay;                        // visible clay
    std::vector<Range> seen, casting;  // further visible and shadow-casting triangles
};

// The hull of a medial primitive: for each direction n of a sphere split `level` times, the support
// point max over i of (c_i . n + r_i), with normal n. Inscribed; exact at its vertices. Adds
// nothing for a primitive that is not finite.
void add_hull(Geometry& geometry, const DrawPrimitive& primitive, int level, Vec3<float> colour,
              float skin = 1);

// Adds a mesh of one colour, `skin` 0 clay to 1 hand. As in gather(), triangles with a vertex that
// is not finite are omitted; throws std::invalid_argument, naming the mesh `name`, if it is
// invalid.
void add_mesh(Geometry& geometry, const Mesh& mesh, Vec3<float> colour, float skin,
              const std::string& name);
// The same for clay, in the colour of its category.
void add_clay(Geometry& geometry, const Mesh& mesh);

constexpr Vec3<float> skin_colour{0.74f, 0.46f, 0.35f};  // linear RGB
constexpr int fine_hull = 3, coarse_hull = 2;            // 1280 and 320 triangles per primitive

// Omits triangles with a vertex that is not finite. Throws std::invalid_argument for an index out
// of range, missing normals, or a primitive not of 1 to 3 spheres.
Geometry gather(const std::vector<Mesh>& meshes, const std::vector<HandLook>& hands,
                const std::vector<Mesh>& unseen = {});

// Appends one hand.
struct HandRanges {
    Range seen, casting;  // both include the skins
};
HandRanges add_hand(Geometry& geometry, const HandLook& hand);

// Bounding ball of all visible or shadow-casting geometry, clipped to a cube of half side `reach`
// [m] around `target`, so that a stray vertex does not spoil the shadows. Radius positive [m].
struct Ball {
    Vec3<float> centre;
    float radius;
};
Ball around(const Box3<float>& box, Vec3<float> target, float reach);
Ball around(const Geometry& geometry, Vec3<float> target, float reach);

}  // namespace knead
