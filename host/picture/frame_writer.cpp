#include "host/picture/frame_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <new>
#include <stdexcept>

#include "host/base/errors.h"
#include "host/base/outputs.h"
#include "host/picture/caption.h"
#include "host/picture/live_look.h"
#include "host/picture/splat_picture.h"

namespace knead {
namespace fs = std::filesystem;
namespace {

bool among(const std::vector<int>& all, int one)
{
    return std::find(all.begin(), all.end(), one) != all.end();
}

bool is_picture_name(const std::string& name)
{
    constexpr std::string_view before = "frame_", after = ".png";
    if (!name.starts_with(before) || !name.ends_with(after)) return false;
    const std::string number =
        name.substr(before.size(), name.size() - before.size() - after.size());
    return number.size() <= 9 &&
           std::all_of(number.begin(), number.end(),
                       [](unsigned char c) { return std::isdigit(c); }) &&
           !number.empty() && picture_name(std::stoi(number)) == name;
}

}  // namespace

std::string picture_name(int frame) { return fmt::format("frame_{:05}.png", frame); }

std::vector<std::string> pictures_in(const std::string& run)
{
    std::error_code problem;
    std::vector<std::string> names;
    const fs::path folder = fs::path(run) / "pictures";
    for (fs::directory_iterator at(folder, problem), end; !problem && at != end;
         at.increment(problem))
        if (is_picture_name(at->path().filename().string())) names.push_back(at->path().string());
    std::sort(names.begin(), names.end(), [](const std::string& a, const std::string& b) {
        return a.size() != b.size() ? a.size() < b.size() : a < b;  // numbers beyond five digits
    });
    return names;
}

void remove_partial_pictures(const std::string& folder)
{
    std::error_code problem;
    if (fs::is_directory(folder, problem)) remove_partials(folder, is_picture_name);
}

void remove_pictures(const std::string& folder)
{
    std::error_code problem;
    if (!fs::is_directory(folder, problem)) return;
    remove_partials(folder, is_picture_name);
    std::vector<fs::path> old;
    for (fs::directory_iterator at(folder, problem), end; !problem && at != end;
         at.increment(problem))
        if (is_picture_name(at->path().filename().string()) &&
            fs::is_regular_file(at->symlink_status(problem)))
            old.push_back(at->path());
    for (const fs::path& picture : old)
        if (!problem) fs::remove(picture, problem);
    if (problem)
        throw OutputError(folder + ": its old pictures cannot be removed: " + problem.message());
}

namespace {

// Captions are projected by the camera; those behind it are left out.
void write_captions(const std::vector<Caption>& captions, const Camera& camera, Image& image)
{
    const Vec3<float> gaze = camera.target - camera.eye, forward = (1 / length(gaze)) * gaze;
    const Vec3<float> side = cross(forward, Vec3<float>{0, 1, 0});
    const Vec3<float> right =
        length(side) > 1e-6f ? (1 / length(side)) * side : Vec3<float>{1, 0, 0};
    const Vec3<float> up = cross(right, forward);
    const float scale = float(image.height) / 2 / std::tan(camera.field / 2);
    for (const Caption& caption : captions) {
        const Vec3<float> d = cast<float>(caption.at) - camera.eye;
        const float depth = dot(d, forward);
        if (depth < 1e-3f) continue;
        write_text(image, caption.text, double(image.width) / 2 + scale * dot(d, right) / depth,
                   double(image.height) / 2 - scale * dot(d, up) / depth,
                   std::max(7.0, image.height / 45.0));
    }
}

}  // namespace

FrameWriter::FrameWriter(const Scene& of, std::string where, std::string video_file,
                         double per_second)
    : scene(of),
      folder(std::move(where)),
      video_path(std::move(video_file)),
      rate(per_second),
      painter(Painter::open())
{
    const int most = painter->largest_side();
    if (std::max(scene.picture_width, scene.picture_height) > most)
        throw std::runtime_error(
            fmt::format("pictures of {} x {} pixels; at most {} a side can be drawn on {}",
                        scene.picture_width, scene.picture_height, most, painter->name()));
    std::error_code problem;
    if (!folder.empty()) fs::create_directories(folder, problem);
    if (problem) throw OutputError(folder + ": cannot be made: " + problem.message());
    if (!video_path.empty())
        video = Video::open(video_path, scene.picture_width, scene.picture_height, rate);
}

void FrameWriter::add(const FrameResult& frame, const std::vector<Mesh>& meshes,
                      const SplatCloud& splats, const std::vector<Gaussian<double>>& gaussians,
                      const Document* document, const ObjectPlaces* places)
{
    const std::vector<int> hidden = document ? document->hidden_categories() : std::vector<int>(),
                           of_splats =
                               document ? splat_categories(*document) : splat_categories(scene);
    // Splats are drawn together: all, unless all their objects are hidden.
    const bool shows_splats =
        of_splats.empty() ||
        std::ranges::any_of(of_splats, [&](int category) { return !among(hidden, category); });
    Camera camera;
    camera.eye = cast<float>(scene.eye);
    camera.target = cast<float>(scene.target);
    camera.width = scene.picture_width;
    camera.height = scene.picture_height;
    const float floor = float(scene.setup.walls.min.y);
    std::vector<Mesh> seen, unseen;
    const ClayColours colours = document ? clay_colours(*document, &meshes, places) : ClayColours{};
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        const int category = meshes[i].category;
        if (among(hidden, category)) continue;
        Mesh& m = (among(of_splats, category) ? unseen : seen).emplace_back(meshes[i]);
        if (i < colours.of_vertices.size() && !colours.of_vertices[i].empty())
            m.colours = colours.of_vertices[i];
        else if (const auto own = colours.of_category.find(category);
                 own != colours.of_category.end())
            m.colours.assign(m.vertices.size(), own->second);
    }
    std::vector<HandLook> hands;
    if (scene.has_hands) hands = hand_looks(scene.hands, frame.motion);
    Image image;
    try {
        image = painter->paint(seen, hands, camera, floor, unseen);
        if (splats.count() > 0 && shows_splats)
            image = with_splats(image, painter->depths(), camera, splats, gaussians, give_up);
        if (give_up && give_up()) throw PictureError("given up");
        write_captions(scene.captions, camera, image);
    } catch (const std::bad_alloc&) {
        throw PictureError("out of memory");
    } catch (const std::invalid_argument& e) {
        throw PictureError(e.what());
    }
    bool whole = true;
    try {
        const std::string file = (fs::path(folder) / picture_name(frame.number)).string();
        if (!folder.empty()) whole = write_png(file, image, give_up);
        if (whole && video) video->add(image);
    } catch (const std::runtime_error& e) {
        throw OutputError(e.what());
    }
    if (!whole) throw PictureError("given up");
    ++pictures;
}

void FrameWriter::close()
{
    try {
        if (video) video->close();
    } catch (const std::runtime_error& e) {
        throw OutputError(e.what());
    }
    video.reset();
}

}  // namespace knead
