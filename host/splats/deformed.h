// Clouds of splats after a deformation, as clouds that need none: for files, and for what places an
// object in a scene.
#pragma once
#include "cuda/splats/deform.h"
#include "host/splats/cloud.h"

namespace knead {

// The cloud with its first splats where the Gaussians are: covariance F A F^T [Xie 2024] as half
// axes and a rotation, colours turned by the rotation of F, opacity as it was. Throws
// std::invalid_argument for more Gaussians than splats.
SplatCloud deformed(SplatCloud cloud, const std::vector<Gaussian<double>>& gaussians);

// The cloud turned by the unit quaternion q, made so many times as large, above 0, and shifted [m].
SplatCloud placed(const SplatCloud& cloud, Quat<double> q, double scale, Vec3<double> shift);

}  // namespace knead
