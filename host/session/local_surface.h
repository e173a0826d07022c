// How deep a place lies under a surface that only splats tell of.
#pragma once
#include <optional>
#include <vector>

#include "host/splats/cells.h"

namespace knead {

struct SurfacePatch {
    Vec3<double> x, n;  // middle [m], outward unit normal
    double count;       // of its splats
};
// Of splats at these places with these normals, by cells of this edge [m].
std::vector<SurfacePatch> surface_patches(const std::vector<Vec3<double>>& centres,
                                          const std::vector<Vec3<double>>& normals, double edge);

class LocalSurface {
  public:
    // `depth` [m] is how far below the surface a place may lie, `width` [m] how far from a splat
    // the surface goes on along it, twice a patch's edge.
    LocalSurface(const std::vector<SurfacePatch>& patches, double depth, double width);
    LocalSurface(const LocalSurface&) = delete;

    // Height over the planes of the patches that are about as near as the nearest [m], below 0
    // inside; nothing where none is near enough.
    std::optional<double> height(Vec3<double> at) const;

  private:
    double nearest_squared(Vec3<double> at) const;

    std::vector<SurfacePatch> patches;
    std::vector<Vec3<double>> middles;  // of them
    double far, wide;
    std::optional<Cells> cells;
};

// The heights in a cube. Far from the surface many patches are about as near as the nearest, so
// that heights are found at a few corners, and are linear between them; within half a part of the
// surface, and where a corner has none, they are as they are.
class CubeHeights {
  public:
    static constexpr int parts = 4, corners = parts + 1;  // along an edge
    static constexpr int count = corners * corners * corners;

    CubeHeights(const LocalSurface& of, Vec3<double> at, double edge)
        : surface(of), low(at), step(edge / parts), heights(count)
    {
    }
    // Before height(): of each corner, in any order, by any threads.
    void find(int corner);
    std::optional<double> height(Vec3<double> at) const;  // of a place in the cube

  private:
    const LocalSurface& surface;
    Vec3<double> low;
    double step;  // [m]
    std::vector<std::optional<double>> heights;
};

}  // namespace knead
