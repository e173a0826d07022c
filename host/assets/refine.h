// Refines medial spheres so that points of the skin lie on their surface. docs/method/hands.md.
#pragma once
#include <vector>

#include "host/assets/skin.h"

namespace knead {

using Spheres = std::vector<Sphere<double>>;

constexpr double smallest_radius = 2e-3;  // of a fitted sphere [m]

std::vector<Shape<double>> shapes(const Spheres& spheres, const std::vector<Primitive>& primitives);

// The closest point of the medial hand, and its primitive.
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

// Rigid transform of a sphere's centre from the fitted pose to another pose of the hand.
struct SphereMotion {
    Mat3<double> turn;
    Vec3<double> shift;  // [m]
};

// A skin to fit: its points, and the transform of each sphere to its pose. No transforms: the
// fitted pose.
struct FitView {
    std::vector<SkinPoint> points;
    std::vector<SphereMotion> carries;
};

struct FitOptions {
    double pull;     // stiffness of the pull to the seed, per point [1]; radii: a fifth
    double outlier;  // distance above which outliers weigh more [m]; 0: never
};

// Minimises the cost over all centres and radii by damped Gauss-Newton steps [Levenberg-Marquardt]:
// phi^2/2 + phi^6/(6 outlier^4) over the distances phi of the views' points, plus the pull to the
// seeds.
void refine(Spheres& spheres, const Spheres& seeds, const std::vector<Primitive>& primitives,
            const std::vector<FitView>& views, const FitOptions& options);

}  // namespace knead
