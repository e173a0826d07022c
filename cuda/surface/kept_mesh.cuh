// Copy of a surface's mesh on the device, kept while the next one is made, and copied from there,
// e.g. to where a renderer reads it. Its size stays on the device.
#pragma once
#include "cuda/surface/surface.cuh"

namespace knead::gpu {

// Size and bounding box of the mesh: bounds are bits of floats, in the encoding of ordered(). If
// the mesh does not fit, it is empty, and `needed` is the required size.
struct MeshInfo {
    unsigned vertices, triangles;
    int low[3], high[3];
    Amounts needed;
    SurfaceErrors errors;  // of the surface
};
HD int ordered(int bits) { return bits >= 0 ? bits : bits ^ 0x7fffffff; }  // its own inverse

// Memory for a mesh.
struct MeshPlace {
    Int3* triangles;
    float4 *places, *normals;  // (x, 1) [m], (unit, advance [m])
    DrawCommand* draws;        // per category
    MeshInfo* facts;
};

// Copies the surface's mesh, with its facts.
void keep_mesh(const SurfaceView& view, const MeshPlace& to, int processors, cudaStream_t stream);
// Copies the mesh to another place; does not write `to.facts`.
void copy_mesh(const MeshPlace& from, const MeshPlace& to, int categories, int processors,
               cudaStream_t stream);

}  // namespace knead::gpu
