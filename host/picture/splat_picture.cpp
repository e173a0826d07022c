#include "host/picture/splat_picture.h"

#include <cmath>

#include "host/splats/cancellable_for.h"
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

Image image_of(const std::vector<Picture>& pictures, const std::function<bool()>& stop)
{
    Image image;
    for (const Picture& p : pictures) image.width += p.width, image.height = p.height;
    const std::size_t row = std::size_t(3) * std::size_t(image.width);
    image.rgb.reserve(row * std::size_t(image.height));
    const auto byte = [](float c) { return std::uint8_t(std::lround(255 * clamp(c, 0.0f, 1.0f))); };
    for (int y = 0; y < image.height; ++y) {
        if (stop && stop()) return {};
        image.rgb.resize(row * std::size_t(y + 1));
        std::uint8_t* to = image.rgb.data() + row * std::size_t(y);
        for (const Picture& p : pictures)
            for (int x = 0; x < p.width; ++x) {
                const Vec3<float> c =
                    p.colour[std::size_t(y) * std::size_t(p.width) + std::size_t(x)];
                for (const float of : {c.x, c.y, c.z}) *to++ = byte(of);
            }
    }
    return image;
}

Image with_splats(const Image& image, const std::vector<float>& depths, const Camera& camera,
                  const SplatCloud& cloud, const std::vector<Gaussian<double>>& gaussians,
                  const std::function<bool()>& stop)
{
    SplatFrame frame;
    frame.stop = stop;
    frame.eyes = {eye_of(camera)};
    frame.options.antialiased = cloud.antialiased;
    Backdrop behind;
    const auto copy_pixel = [&](std::size_t i) {
        const std::uint8_t* const rgb = image.rgb.data() + 3 * i;
        behind.colour[i] = (1 / 255.0f) * Vec3<float>{float(rgb[0]), float(rgb[1]), float(rgb[2])};
        behind.depth[i] = min(depths[i], 0.1f * no_depth);  // below no_depth: keeps floor
    };
    const auto move = [&](std::size_t i) {
        const Gaussian<double>& g = gaussians[i];
        frame.moved_centre.push_back(cast<float>(g.x));
        frame.moved_F.push_back({cast<float>(g.F.a), cast<float>(g.F.b), cast<float>(g.F.c)});
    };
    if (!resize_unless_stopped(behind.colour, depths.size(), frame) ||
        !resize_unless_stopped(behind.depth, depths.size(), frame) ||
        !for_each_unless_stopped(depths.size(), frame, copy_pixel) ||
        !for_each_unless_stopped(gaussians.size(), frame, move))
        return {};
    frame.behind = {std::move(behind)};
    return image_of(cpu_raster(cloud, frame), stop);
}

}  // namespace knead
