// A surface's mesh as it was, kept on the device while the next one is made, and copied on from
// there, e.g. to where a renderer reads it. How much of it there is stays on the device.
#pragma once
#include "cuda/surface/surface.cuh"

namespace knead::gpu {

// How large it is, and the box about its vertices: each side a float by its bits, so changed that
// whole numbers are in the order of the floats. Without room for all of it, it is empty; `needed`
// is what it would have.
struct MeshInfo {
    unsigned vertices, triangles;
    int low[3], high[3];
    Amounts needed;
    Faults faults;  // of the surface
};
HD int ordered(int bits) { return bits >= 0 ? bits : bits ^ 0x7fffffff; }  // and back

// With room for all of it.
struct MeshPlace {
    Int3* triangles;
    float4 *places, *normals;  // (x, 1) [m], (unit, advance [m])
    DrawCommand* draws;        // per category
    MeshInfo* facts;
};

// From the surface, with its facts.
void keep_mesh(const SurfaceView& view, const MeshPlace& to, int processors, cudaStream_t stream);
// To another place; `to.facts` is not written.
void copy_mesh(const MeshPlace& from, const MeshPlace& to, int categories, int processors,
               cudaStream_t stream);

}  // namespace knead::gpu
