// Fits a medial hand to a skinned mesh by Gauss-Newton on the exact distance. docs/hands.md.
#pragma once
#include <iosfwd>
#include <string>

#include "host/rig.h"
#include "host/skin.h"

namespace knead {

using Spheres = std::vector<Sphere<double>>;

// Least squares of the distance at the points over all centres and radii, by Gauss-Newton. Centres
// are pulled to where they start: `pull` per point, radii a fifth of that. By the envelope theorem
// d(phi)/d(centre) = -share n and d(phi)/d(radius) = -share, a sphere's share being its foot
// weight.
void refine(Spheres& spheres, const std::vector<Primitive>& primitives,
            const std::vector<SkinPoint>& points, double pull);

// How far a surface lies from a medial hand: |phi| over points spread evenly on the surface [m].
struct Deviation {
    double mean, p95, worst;
    double bulge;  // farthest that the medial hand's surface strays from the mesh [m]
};

struct FitReport {
    Topology topology;
    Side side;
    Hand open;                          // the mesh's own joints
    std::vector<FittedSphere> spheres;  // as of a right hand
    Rig rig;                            // of `side`, bound to `open`
    int cones, slabs;
    Deviation deviation;     // open hand, at 40000 points
    double shift, farthest;  // of the centres from their seeds: mean, greatest [m]
    double seconds;
};

// Throws std::runtime_error where the mesh cannot be read. Deterministic.
FitReport fit_hand(const std::string& path, Topology topology, Side side);

// How far the skin lies from the rig when both follow `pose`. `bulge` only if asked for (slow).
Deviation deviation(const Rig& rig, Side side, const Skin& skin,
                    const std::vector<SkinPoint>& points, const Hand& pose, bool bulge = false);

// host/rig_table.h, from the fits of both topologies to one right hand.
void write_rig_table(std::ostream& out, const FitReport& h25, const FitReport& h47);

}  // namespace knead
