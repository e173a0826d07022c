// Height of a point over a surface that is given by splats alone.
#pragma once
#include <array>
#include <optional>
#include <vector>

#include "host/paging/cubes.h"
#include "host/splats/cells.h"

namespace knead {

struct SurfacePatch {
    Vec3<double> x, n;  // mean of its splats [m], outward unit normal
    double count;       // of its splats
};
// Groups splats with these centres [m] and unit normals by cells of this edge [m], one patch per
// cell.
std::vector<SurfacePatch> surface_patches(const std::vector<Vec3<double>>& centres,
                                          const std::vector<Vec3<double>>& normals, double edge);

class LocalSurface {
  public:
    // `depth`: largest depth below the surface that is evaluated [m]. `width`: distance by which
    // the surface extends tangentially beyond a patch, twice a patch's edge [m].
    LocalSurface(const std::vector<SurfacePatch>& patches, double depth, double width);
    LocalSurface(const LocalSurface&) = delete;

    // Signed height [m], negative inside: mean over the planes of the patches that are at most
    // `width` farther than the nearest. Empty if no patch is near enough.
    std::optional<double> height(Vec3<double> at) const;

  private:
    double nearest_squared(Vec3<double> at) const;

    std::vector<SurfacePatch> patches;
    std::vector<Vec3<double>> middles;  // of the patches [m]
    double far, wide;
    std::optional<Cells> cells;
};

// Heights in a cube. Far from the surface many patches are about as near as the nearest and a
// height is expensive. Therefore heights are evaluated at the corners of `parts`^3 cells and
// interpolated linearly. They are evaluated exactly within 0.35 cells of the surface, and where a
// corner has no height and the other corners are not far above the surface.
class CubeHeights {
  public:
    static constexpr int parts = 4, corners = parts + 1;  // along an edge
    using Corners = std::array<std::optional<double>, corners * corners * corners>;

    // For each of these cubes of that edge [m]. Shared corners are evaluated once, in parallel.
    static std::vector<CubeHeights> of(const LocalSurface& surface,
                                       const std::vector<Cubes::Key>& cubes, double edge);
    std::optional<double> height(Vec3<double> at) const;  // of a point in the cube [m]

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
    Int3 first;   // index of the first corner in all of space
    double step;  // between corners [m]
    Corners heights;
};

}  // namespace knead
