// knead render: pictures and videos of splat files; videos of the pictures of a run.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <sstream>

#include "host/base/errors.h"
#include "host/base/interrupt.h"
#include "host/base/outputs.h"
#include "host/base/paths.h"
#include "host/base/print.h"
#include "host/cli/camera_path.h"
#include "host/cli/verbs.h"
#include "host/files/image.h"
#include "host/files/splat_file.h"
#include "host/files/video.h"
#include "host/picture/frame_writer.h"
#include "host/picture/splat_picture.h"
#include "host/session/backend.h"
#include "host/splats/generate.h"
#include "host/splats/gpu_raster.h"

namespace knead {
namespace {

using V = Vec3<double>;
constexpr double eyes_apart = 0.064;  // [m]
constexpr int max_side = 8192;        // pixels
constexpr double max_frames = 1e5;    // of a path

[[noreturn]] void refuse(const std::string& option, const std::string& expected,
                         const std::string& found)
{
    throw UsageError(option + ": expected " + expected + ", found \"" + found.substr(0, 60) + "\"");
}

// Parses three comma-separated numbers.
V triple(const std::string& option, const std::string& text)
{
    double x[3];
    const char *at = text.data(), *const end = at + text.size();
    for (int k = 0; k < 3; ++k) {
        const auto [after, problem] = std::from_chars(at, end, x[k]);
        const bool last = k == 2;
        if (problem != std::errc() || !(std::fabs(x[k]) < 1e6) ||
            (last ? after != end : after == end || *after != ','))
            refuse(option, "three numbers with commas between them", text);
        at = after + 1;
    }
    return {x[0], x[1], x[2]};
}

struct Size {
    int width, height;
};
Size parse_size(const std::string& text)
{
    Size s{};
    const char* const end = text.data() + text.size();
    const auto [cross, problem] = std::from_chars(text.data(), end, s.width);
    if (problem == std::errc() && cross != end && *cross == 'x') {
        const auto [after, second] = std::from_chars(cross + 1, end, s.height);
        if (second == std::errc() && after == end && std::min(s.width, s.height) > 0 &&
            std::max(s.width, s.height) <= max_side)
            return s;
    }
    refuse("--size", fmt::format("WIDTHxHEIGHT of at most {} pixels a side", max_side), text);
}

V parse_up(const std::string& text)
{
    const double sign = text.starts_with('-') ? -1 : 1;
    const std::string axis = sign < 0 ? text.substr(1) : text;
    if (axis == "x") return {sign, 0, 0};
    if (axis == "y") return {0, sign, 0};
    if (axis == "z") return {0, 0, sign};
    refuse("--up", "x, y, z, -x, -y or -z", text);
}

// Merges all files into one cloud, with the highest degree of spherical harmonics among them.
SplatCloud read_all(const std::vector<std::string>& files, bool quiet)
{
    std::vector<SplatCloud> clouds;
    SplatCloud all;
    for (const std::string& file : files) {
        SplatFile read = read_splats(file);
        if (!quiet)
            for (const std::string& remark : remarks(read))
                fmt::print(stderr, "{}: {}\n", file, remark);
        all.degree = std::max(all.degree, read.cloud.degree);
        all.antialiased |= read.cloud.antialiased;
        clouds.push_back(std::move(read.cloud));
    }
    const auto append = [](auto& to, const auto& from) {
        to.insert(to.end(), from.begin(), from.end());
    };
    for (const SplatCloud& c : clouds) {
        append(all.centre, c.centre), append(all.rotation, c.rotation);
        append(all.scale, c.scale), append(all.opacity, c.opacity);
        const auto has = std::size_t(harmonics(c.degree)), row = std::size_t(harmonics(all.degree));
        for (std::size_t i = 0; i < c.count(); ++i)
            for (std::size_t k = 0; k < row; ++k)
                all.sh.push_back(k < has ? c.sh[i * has + k] : Vec3<float>{0, 0, 0});
    }
    return all;
}

// Extent of the cloud: median of each axis, and the distance from it that contains nine of ten
// splats.
struct Sphere {
    V centre;
    double radius;
};
Sphere most_of(const SplatCloud& cloud)
{
    std::vector<float> numbers(cloud.count());
    const auto at_share = [&](double share) {
        const auto n = std::size_t(share * double(numbers.size() - 1));
        std::nth_element(numbers.begin(), numbers.begin() + long(n), numbers.end());
        return numbers[n];
    };
    const auto median = [&](auto&& axis) {
        for (std::size_t i = 0; i < cloud.count(); ++i) numbers[i] = axis(cloud.centre[i]);
        return at_share(0.5);
    };
    const Vec3<float> centre{median([](Vec3<float> x) { return x.x; }),
                             median([](Vec3<float> x) { return x.y; }),
                             median([](Vec3<float> x) { return x.z; })};
    for (std::size_t i = 0; i < cloud.count(); ++i) numbers[i] = length(cloud.centre[i] - centre);
    return {cast<double>(centre), std::max(double(at_share(0.9)), 1e-6)};
}

// Camera of each frame.
struct Path {
    V from, to, up;
    double tangent;
    Size size;
    bool stereo;
    int frames = 1;
    double rate = 30;             // frames a second
    std::vector<CameraKey> keys;  // empty: orbit about the `up` axis through `to`

    View view(int frame) const
    {
        if (!keys.empty()) return view_at(keys, keys.front().time + frame / rate);
        const double angle = 2 * std::numbers::pi * frame / frames;
        return {to + rotate(turn_about(up, angle), from - to), to};
    }

    std::vector<Eye<float>> eyes(int frame) const
    {
        const auto [head, at] = view(frame);
        const Eye<float> one = eye_looking(head, at, tangent, size.width, size.height, up);
        if (!stereo) return {one};
        const V right = rotation(cast<double>(one.rotation)).a;
        std::vector<Eye<float>> two;
        for (const double side : {-0.5, 0.5}) {
            two.push_back(one);
            two.back().position = cast<float>(head + side * eyes_apart * right);
        }
        return two;
    }
};

void read_keys(const RenderOptions& o, Path& path)
{
    if (o.path.empty()) return;
    path.keys = read_camera_path(o.path);
    const double frames = (path.keys.back().time - path.keys.front().time) * path.rate;
    if (!(frames < max_frames))
        throw UsageError(
            fmt::format("--path: {:.0f} frames; at most {} are made", frames, max_frames));
    path.frames = int(std::floor(frames + 1e-6)) + 1;
}

Path path_of(const RenderOptions& o, const SplatCloud& cloud)
{
    const Sphere ball = most_of(cloud);
    Path path;
    path.size = parse_size(o.size), path.up = parse_up(o.up), path.stereo = o.stereo;
    path.tangent = std::tan(o.field * std::numbers::pi / 360);
    path.to = o.at.empty() ? ball.centre : triple("--at", o.at);
    path.frames = std::max(o.orbit, 1), path.rate = o.rate;
    if (!o.eye.empty()) {
        path.from = triple("--eye", o.eye);
    } else {
        // In front of it and slightly above, far enough to show its height and width.
        const double h = path.tangent * std::min(1.0, double(path.size.height) / path.size.width);
        const V level = orthogonal(path.up),
                front = std::fabs(path.up.z) > 0.5 ? level : V{0, 0, -1};
        path.from = path.to + 1.5 * ball.radius / std::sin(std::atan(h)) *
                                  (std::cos(0.25) * front + std::sin(0.25) * path.up);
    }
    if (!(length(path.from - path.to) > 1e-9))
        throw UsageError("--eye: expected another point than --at");
    read_keys(o, path);
    return path;
}

// OUT; for several frames, OUT with the number before the extension.
std::string name_of(const RenderOptions& o, int frame)
{
    if (o.orbit == 0 && o.path.empty()) return o.out;
    std::filesystem::path path = o.out;
    path.replace_filename(path.stem().string() + fmt::format("_{:04}.png", frame));
    return path.string();
}

void check_options(const RenderOptions& o)
{
    if (o.out.empty() && o.video.empty())
        throw UsageError("knead render needs --out PICTURE.png, --video FILE, or both");
    if (!o.out.empty() && ending(o.out) != ".png")
        throw UsageError("--out: expected a file ending in .png, found \"" + o.out + "\"");
    const std::vector<std::string> forms{".mp4", ".mkv", ".webm", ".mov", ".avi"};
    if (!o.video.empty() && std::find(forms.begin(), forms.end(), ending(o.video)) == forms.end())
        throw UsageError(
            "--video: expected a file ending in .mp4, .mkv, .webm, .mov or .avi, "
            "found \"" +
            o.video + "\"");
    if (!o.path.empty() && (o.orbit > 0 || !o.eye.empty() || !o.at.empty()))
        throw UsageError("--path: cannot be combined with --orbit, --eye and --at");
}

// Opened before drawing: an unwritable video fails at once.
std::unique_ptr<Video> video_of(const RenderOptions& o, int width, int height)
{
    if (o.video.empty()) return nullptr;
    prepare_file(o.video, o.overwrite);
    return Video::open(o.video, width, height, o.rate);
}

// Encodes the pictures of a run, in order, as a video at --rate.
int run_video(const RenderOptions& o)
{
    if (!o.out.empty() || !o.path.empty() || o.orbit > 0 || o.stereo || o.foveate > 0)
        throw UsageError(o.files[0] + ": pictures of a run can only be encoded as a --video");
    const std::vector<std::string> pictures = pictures_in(o.files[0]);
    if (pictures.empty())
        throw InputError(o.files[0] +
                         ": expected the folder of a run with pictures, or files of splats");
    const Image first = read_png(pictures[0]);
    const std::unique_ptr<Video> video = video_of(o, first.width, first.height);
    watch_interrupts();
    for (const std::string& file : pictures) {
        if (interrupted()) break;
        const Image image = read_png(file);
        if (image.width != first.width || image.height != first.height)
            throw InputError(fmt::format("{}: {} x {} pixels, but {} has {} x {}", file,
                                         image.width, image.height, pictures[0], first.width,
                                         first.height));
        video->add(image);
    }
    video->close();
    if (!o.quiet) print(o.video + "\n");
    return interrupted() ? 128 + interrupted() : int(exit_ok);
}

// Locks the folder of a set of pictures against other processes.
FolderLock prepare_pictures(const RenderOptions& o, int frames)
{
    if (o.out.empty()) return {};
    FolderLock lock;
    const std::filesystem::path out = o.out, folder = out.parent_path();
    std::error_code unknown;  // a missing folder is reported when the first picture is written
    if (frames > 1 && (folder.empty() || std::filesystem::is_directory(folder, unknown)))
        lock = FolderLock(folder.string(), out.stem().string());
    for (int k = 0; k < frames; ++k) prepare_file(name_of(o, k), o.overwrite);
    return lock;
}

// Draws the frames and writes each immediately.
void draw_frames(const RenderOptions& o, const Path& path, const SplatCloud& cloud,
                 SplatFrame& frame, Device device, Video* video)
{
    std::unique_ptr<GpuRaster> gpu;
    if (device.kind == DeviceKind::cuda) gpu = std::make_unique<GpuRaster>(cloud, 0, device.index);
    frame.stop = [] { return interrupted() != 0; };
    for (int k = 0; k < path.frames && !interrupted(); ++k) {
        frame.eyes = path.eyes(k);
        if (o.foveate > 0) frame.fovea.assign(frame.eyes.size(), fovea_of(o.foveate));
        const Image image =
            image_of(gpu                                     ? gpu->pictures(frame)
                     : device.kind == DeviceKind::cpu_double ? exact_raster(cloud, frame)
                                                             : cpu_raster(cloud, frame),
                     frame.stop);
        if (interrupted()) break;
        if (video) video->add(image);
        if (o.out.empty()) continue;
        if (!write_png(name_of(o, k), image, frame.stop)) break;
        if (!o.quiet) print(name_of(o, k) + "\n");
    }
    if (!video) return;
    video->close();
    if (!o.quiet) print(o.video + "\n");
}

}  // namespace

int render_verb(const RenderOptions& o)
{
    check_options(o);
    std::error_code nobody_asks;
    if (o.files.size() == 1 && std::filesystem::is_directory(o.files[0], nobody_asks) &&
        !is_sog_folder(o.files[0]))
        return run_video(o);
    if (!o.video.empty() && o.orbit == 0 && o.path.empty())
        throw UsageError("--video: of splats it needs --orbit FRAMES or --path FILE");
    const Device device = resolved(parse_device(o.device));
    if (o.foveate > 0 && device.kind == DeviceKind::cpu_double)
        throw UsageError("--foveate: not available with cpu:double, which draws every pixel");
    SplatCloud cloud = read_all(o.files, o.quiet);
    sort_by_place(cloud);
    const Path path = path_of(o, cloud);
    SplatFrame frame;
    frame.options.antialiased = cloud.antialiased;
    if (!o.background.empty()) frame.background = cast<float>(triple("--background", o.background));
    const FolderLock lock = prepare_pictures(o, path.frames);
    const std::unique_ptr<Video> video =
        video_of(o, path.size.width * (path.stereo ? 2 : 1), path.size.height);
    watch_interrupts();
    draw_frames(o, path, cloud, frame, device, video.get());
    return interrupted() ? 128 + interrupted() : int(exit_ok);
}

}  // namespace knead
