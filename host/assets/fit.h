// Fits a medial hand to a skinned mesh by Gauss-Newton on the exact distance. docs/method/hands.md.
#pragma once
#include <iosfwd>
#include <string>

#include "host/assets/refine.h"
#include "host/hands/rig.h"

namespace knead {

// Deviation of a surface from a medial hand: |phi| over points spread evenly on the surface [m].
struct Deviation {
    double mean, p95, worst;
    double bulge;  // maximum distance of the medial hand's surface from the mesh [m]
};

struct FitReport {
    Topology topology;
    Side side;
    Hand open;                          // the mesh's own joints
    std::vector<FittedSphere> spheres;  // for a right hand
    Rig rig;                            // of `side`, bound to `open`
    int cones, slabs;
    Deviation deviation;     // open hand, at 40000 points
    double shift, farthest;  // distance of the centres from their seeds: mean, maximum [m]
    double seconds;
};

struct HandMesh {
    std::string path;
    Side side;
};

// Fits one hand to all meshes, right and left, each in its bind pose. The report covers the first
// mesh: its joints, its deviation. Throws std::runtime_error if a mesh cannot be read.
// Deterministic.
FitReport fit_hand(const std::vector<HandMesh>& meshes, Topology topology);

// Deviation of the skin from the rig when both follow `pose`. `bulge` only on request (slow).
Deviation deviation(const Rig& rig, Side side, const Skin& skin,
                    const std::vector<SkinPoint>& points, const Hand& pose, bool bulge = false);

// Writes host/hands/rig_table.h from the fits of both topologies, the first mesh of each a right
// hand.
void write_rig_table(std::ostream& out, const FitReport& h25, const FitReport& h47);

}  // namespace knead
