// Splat clouds with a deformation baked in, for files and for placing objects in a scene.
#pragma once
#include "cuda/splats/deform.h"
#include "host/splats/cloud.h"

namespace knead {

// Applies the Gaussians to the first splats of the cloud: covariance F A F^T [Xie 2024] as half
// axes and a rotation, colours rotated by the rotation of F, opacity unchanged. Throws
// std::invalid_argument for more Gaussians than splats.
SplatCloud deformed(SplatCloud cloud, const std::vector<Gaussian<double>>& gaussians);

// Returns the cloud rotated by the unit quaternion q, scaled by `scale`, above 0, and translated by
// `shift` [m].
SplatCloud placed(const SplatCloud& cloud, Quat<double> q, double scale, Vec3<double> shift);

}  // namespace knead
