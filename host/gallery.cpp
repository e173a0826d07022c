#include "gallery.h"

#include <fmt/format.h>

#include <filesystem>

#include "failure.h"

namespace knead {

std::vector<Blob> blobs_of(const Setup& setup, const std::vector<Joint<double>>& joints,
                           const std::vector<char>& active)
{
    std::vector<Blob> blobs;
    if (joints.empty()) return blobs;
    const auto pose = [&](int j) {
        const Joint<double>& at = joints[std::size_t(j)];
        return Joint<float>{cast<float>(at.q), cast<float>(at.p)};
    };
    for (const Primitive& p : setup.rig.primitives) {
        if (std::size_t(p.tool) < active.size() && !active[std::size_t(p.tool)]) continue;
        Blob blob{};
        blob.count = p.count;
        for (int k = 0; k < 3; ++k) {
            const Binding<float>& b = setup.rig.spheres[std::size_t(p.sphere[k])];
            blob.sphere[k] = {centre(b, pose), {}, {}, b.radius, 0};
        }
        blobs.push_back(blob);
    }
    return blobs;
}

Gallery::Gallery(const Scene& of, std::string where, std::string video_file, double per_second)
    : scene(of),
      folder(std::move(where)),
      video_path(std::move(video_file)),
      rate(per_second),
      painter(Painter::open())
{
    if (!folder.empty()) std::filesystem::create_directories(folder);
    if (!video_path.empty())
        video = Video::open(video_path, scene.picture_width, scene.picture_height, rate);
}

void Gallery::add(const View& view)
{
    Camera camera;
    camera.eye = cast<float>(scene.eye);
    camera.target = cast<float>(scene.target);
    camera.width = scene.picture_width;
    camera.height = scene.picture_height;
    const float floor = float(scene.setup.lattice.dx * scene.setup.walls.margin);
    const Image image =
        painter->paint(view.meshes, blobs_of(scene.setup, view.joints, view.active), camera, floor);
    try {
        if (!folder.empty())
            write_png(
                (std::filesystem::path(folder) / fmt::format("frame_{:05}.png", view.row.frame))
                    .string(),
                image);
        if (video) video->add(image);
    } catch (const std::runtime_error& e) {
        throw OutputError(e.what());
    }
    ++pictures;
}

void Gallery::close()
{
    try {
        if (video) video->close();
    } catch (const std::runtime_error& e) {
        throw OutputError(e.what());
    }
    video.reset();
}

}  // namespace knead
