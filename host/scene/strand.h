// Clay from a nozzle: a section that was extruded along a path.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "cuda/math/vec.h"
#include "host/scene/glyphs.h"

namespace knead {

enum class SectionKind { circle, square, star, outline };

struct StrandPoint {
    Vec3<double> at{};    // [m]
    Vec3<double> axis{};  // of the nozzle, of any length; 0: along the path
};
struct Strand {
    SectionKind section = SectionKind::circle;
    // Of the circle, side of the square, or longest extent of the star (of five points) or the
    // outline [m].
    double diameter = 0;
    std::vector<Point2> outline;    // of section `outline`: a closed polygon, in any unit
    std::vector<StrandPoint> path;  // in the object's frame; source_begin begins it at 0
    bool open = false;              // the nozzle has not ended it
};

constexpr std::size_t most_outline_points = 1000, most_strand_points = 100000;
constexpr double most_strand_extent = 1000;   // of each coordinate of a path [m]
constexpr int most_strand_diameters = 10000;  // length of a path

bool equal(const Strand& a, const Strand& b);  // to the bit

// What is wrong with it, by the key of scenes; empty: valid.
struct StrandFault {
    std::string key, expected, found;
};
std::optional<StrandFault> fault_of(const Strand& strand);

// Clay leaves the nozzle as fast as the nozzle moves, so that it comes to rest where it is laid.
// The section faces along the nozzle's axis where that is within 45 degrees of the motion,
// otherwise along the motion. It turns by at most one radian per diameter of the path, but is never
// more than 60 degrees from the motion. Particles are laid in layers. Each has the volume h^3; all
// together have that of the section's area times the length of the path along its normal.
//
// Places of the particles that the path lays behind the point `from` of it, which is at least 1 and
// less than the number of its points, in the object's frame, layer after layer. The layers up to
// each point do not depend on later points. Throws std::invalid_argument for a section of more than
// a million particles.
std::vector<Vec3<double>> laid(const Strand& strand, double h, std::size_t from = 1);
double laid_volume(const Strand& strand);  // of the whole path [m^3]

double reach_of(const Strand& strand);  // largest distance of the section from its path [m]
// Distance of a place from the path, in the object's frame [m].
double distance_from(const Strand& strand, Vec3<double> x);

}  // namespace knead
