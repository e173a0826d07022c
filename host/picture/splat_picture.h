// Composites splats into pictures of clay by depth.
#pragma once
#include <functional>

#include "cuda/splats/deform.h"
#include "host/files/image.h"
#include "host/splats/raster.h"
#include "render/painter.h"

namespace knead {

// Concatenates pictures of one height side by side. `stop`: called before every row; true aborts
// and returns an empty image.
Image image_of(const std::vector<Picture>& pictures, const std::function<bool()>& stop = {});

// `image`: the scene without splats; `depths`: its Painter::depths(). The i-th Gaussian moves the
// i-th splat of the cloud. `stop` aborts as in SplatFrame and gives an empty image.
Image with_splats(const Image& image, const std::vector<float>& depths, const Camera& camera,
                  const SplatCloud& cloud, const std::vector<Gaussian<double>>& gaussians,
                  const std::function<bool()>& stop = {});

}  // namespace knead
