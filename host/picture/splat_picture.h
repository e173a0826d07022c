// Pictures of clay into which splats are put, each behind and before what it should be.
#pragma once
#include <functional>

#include "cuda/splats/deform.h"
#include "host/files/image.h"
#include "host/splats/raster.h"
#include "render/painter.h"

namespace knead {

// Side by side; all of one height. Where `stop`, asked before every row, says so, there is none.
Image image_of(const std::vector<Picture>& pictures, const std::function<bool()>& stop = {});

// `image` is what the camera sees of all else, `depths` how far that lies (Painter::depths()). Of
// the first splats of the cloud, as many as there are Gaussians are where these are. Given up as
// a SplatFrame is by `stop`: there is then no picture.
Image with_splats(const Image& image, const std::vector<float>& depths, const Camera& camera,
                  const SplatCloud& cloud, const std::vector<Gaussian<double>>& gaussians,
                  const std::function<bool()>& stop = {});

}  // namespace knead
