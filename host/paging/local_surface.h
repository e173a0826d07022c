// How deep a place lies under a surface that only splats tell of.
#pragma once
#include <array>
#include <optional>
#include <vector>

#include "host/paging/cubes.h"
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
// that heights are found at a few corners, and are linear between them; within a third of a part of
// the surface, and where a corner has none, they are as they are, but far above.
class CubeHeights {
  public:
    static constexpr int parts = 4, corners = parts + 1;  // along an edge
    using Corners = std::array<std::optional<double>, corners * corners * corners>;

    // Of each of these cubes of that edge [m]. What they share is found once, by many threads.
    static std::vector<CubeHeights> of(const LocalSurface& surface,
                                       const std::vector<Cubes::Key>& cubes, double edge);
    std::optional<double> height(Vec3<double> at) const;  // of a place in the cube

  private:
    CubeHeights(const LocalSurface& of, Int3 cube, double edge)
        : surface(&of), first(parts * cube), step(edge / parts)
    {
    }
    static Int3 corner(int k)
    {
        return {k % corners, k / corners % corners, k / corners / corners};
    }

    const LocalSurface* surface;
    Int3 first;   // of the corners of all of space
    double step;  // [m]
    Corners heights;
};

}  // namespace knead
