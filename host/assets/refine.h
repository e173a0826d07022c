// Medial spheres brought to where points of skin lie on their surface. docs/method/hands.md.
#pragma once
#include <vector>

#include "host/assets/skin.h"

namespace knead {

using Spheres = std::vector<Sphere<double>>;

constexpr double smallest_radius = 2e-3;  // of a sphere that is fitted [m]

std::vector<Shape<double>> shapes(const Spheres& spheres, const std::vector<Primitive>& primitives);

// What a point is nearest to.
struct Hold {
    ClosestPoint<double> closest_point;
    int primitive;
};
Hold nearest(const std::vector<Shape<double>>& shapes, Vec3<double> p);

// Calls visit(sphere, share) for the spheres that a closest point depends on.
template <class Visit>
void for_each_share(const Primitive& q, const ClosestPoint<double>& f, Visit&& visit)
{
    const double l[3] = {f.l0, f.l1, f.l2};
    for (int k = 0; k < q.count; ++k)
        if (l[k] > 0) visit(q.sphere[k], l[k]);
}

// How a sphere's centre gets from where it is fitted to where it stands in another pose of the
// hand.
struct Carry {
    Mat3<double> turn;
    Vec3<double> shift;  // [m]
};

// A skin to fit to: its points, and where its pose carries each sphere. No carries: nowhere.
struct FitView {
    std::vector<SkinPoint> points;
    std::vector<Carry> carries;
};

struct FitOptions {
    double pull;     // of a centre to its seed, per point [1]; radii a fifth of that
    double outlier;  // from this distance on [m] outliers count by more than squares; 0: never
};

// Least cost over all centres and radii by damped Gauss-Newton steps [Levenberg-Marquardt]: of the
// distances phi at the views' points, phi^2/2 + phi^6/(6 outlier^4), and of the pull to the seeds.
void refine(Spheres& spheres, const Spheres& seeds, const std::vector<Primitive>& primitives,
            const std::vector<FitView>& views, const FitOptions& options);

}  // namespace knead
