#include "host/session/splat_picture.h"

#include <cmath>

#include "host/splats/generate.h"

namespace knead {
namespace {

Eye<float> eye_of(const Camera& camera)
{
    const double wide = std::tan(double(camera.field) / 2) * camera.width / camera.height;
    return eye_looking(cast<double>(camera.eye), cast<double>(camera.target), wide, camera.width,
                       camera.height, {0, 1, 0});
}

}  // namespace

Image with_splats(const Image& image, const std::vector<float>& depths, const Camera& camera,
                  const SplatCloud& cloud, const std::vector<Gaussian<double>>& gaussians)
{
    SplatFrame frame;
    frame.eyes = {eye_of(camera)};
    frame.rule.antialiased = cloud.antialiased;
    Backdrop behind;
    behind.colour.resize(depths.size()), behind.depth.resize(depths.size());
    for (std::size_t i = 0; i < depths.size(); ++i) {
        const std::uint8_t* const rgb = image.rgb.data() + 3 * i;
        behind.colour[i] = (1 / 255.0f) * Vec3<float>{float(rgb[0]), float(rgb[1]), float(rgb[2])};
        behind.depth[i] = min(depths[i], 0.1f * no_depth);  // the floor's colours count, too
    }
    frame.behind = {std::move(behind)};
    for (const Gaussian<double>& g : gaussians) {
        frame.moved_centre.push_back(cast<float>(g.x));
        frame.moved_F.push_back({cast<float>(g.F.a), cast<float>(g.F.b), cast<float>(g.F.c)});
    }
    const Picture picture = cpu_raster(cloud, frame).front();
    Image whole = image;
    for (std::size_t i = 0; i < picture.pixels(); ++i) {
        const Vec3<float> c = picture.colour[i];
        const float rgb[3] = {c.x, c.y, c.z};
        for (std::size_t k = 0; k < 3; ++k)
            whole.rgb[3 * i + k] = std::uint8_t(std::lround(255 * clamp(rgb[k], 0.0f, 1.0f)));
    }
    return whole;
}

}  // namespace knead
