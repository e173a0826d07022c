// knead render: pictures of files of splats.
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
#include "host/cli/verbs.h"
#include "host/files/image.h"
#include "host/files/splat_file.h"
#include "host/session/device.h"
#include "host/splats/generate.h"
#include "host/splats/gpu_raster.h"

namespace knead {
namespace {

using V = Vec3<double>;
constexpr double eyes_apart = 0.064;  // [m]
constexpr int max_side = 8192;        // pixels

[[noreturn]] void refuse(const std::string& option, const std::string& expected,
                         const std::string& found)
{
    throw UsageError(option + ": expected " + expected + ", found \"" + found.substr(0, 60) + "\"");
}

// Numbers with commas between them.
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

// All files in one cloud, of the highest degree among them.
SplatCloud read_all(const std::vector<std::string>& files, bool quiet)
{
    std::vector<SplatCloud> clouds;
    SplatCloud all;
    for (const std::string& file : files) {
        SplatFile read = read_splats(file);
        if (read.repairs.dropped() && !quiet)
            fmt::print(stderr, "{}: {} splats left out that cannot be drawn\n", file,
                       read.repairs.dropped());
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

// Where most of the cloud is: the median of each axis, and how far nine of ten are from there.
struct Ball {
    V centre;
    double radius;
};
Ball most_of(const SplatCloud& cloud)
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

struct Path {
    V from, to, up;
    double tangent;
    Size size;
    bool stereo;

    // Turned about the line upwards through what is looked at.
    std::vector<Eye<float>> eyes(double angle) const
    {
        const V away = rotate(turn_about(up, angle), from - to), head = to + away;
        const Eye<float> one = eye_looking(head, to, tangent, size.width, size.height, up);
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

Path path_of(const RenderOptions& o, const SplatCloud& cloud)
{
    const Ball ball = most_of(cloud);
    Path path;
    path.size = parse_size(o.size), path.up = parse_up(o.up), path.stereo = o.stereo;
    path.tangent = std::tan(o.field * std::numbers::pi / 360);
    path.to = o.at.empty() ? ball.centre : triple("--at", o.at);
    if (!o.eye.empty()) {
        path.from = triple("--eye", o.eye);
    } else {
        // Before it and a little above, as far as its height and its width need.
        const double h = path.tangent * std::min(1.0, double(path.size.height) / path.size.width);
        const V level = orthogonal(path.up),
                front = std::fabs(path.up.z) > 0.5 ? level : V{0, 0, -1};
        path.from = path.to + 1.5 * ball.radius / std::sin(std::atan(h)) *
                                  (std::cos(0.25) * front + std::sin(0.25) * path.up);
    }
    if (!(length(path.from - path.to) > 1e-9)) throw UsageError("--eye: it is where it looks at");
    return path;
}

// Side by side.
Image image_of(const std::vector<Picture>& pictures)
{
    Image image{0, pictures.at(0).height, {}};
    for (const Picture& p : pictures) image.width += p.width;
    const auto byte = [](float c) {
        return std::uint8_t(std::lround(255 * std::clamp(c, 0.0f, 1.0f)));
    };
    for (int y = 0; y < image.height; ++y)
        for (const Picture& p : pictures)
            for (int x = 0; x < p.width; ++x) {
                const Vec3<float> c =
                    p.colour[std::size_t(y) * std::size_t(p.width) + std::size_t(x)];
                image.rgb.insert(image.rgb.end(), {byte(c.x), byte(c.y), byte(c.z)});
            }
    return image;
}

// OUT, or for a frame of an orbit OUT with its number before the ending.
std::string name_of(const RenderOptions& o, int frame)
{
    if (o.orbit == 0) return o.out;
    std::filesystem::path path = o.out;
    path.replace_filename(path.stem().string() + fmt::format("_{:04}.png", frame));
    return path.string();
}

}  // namespace

int render_verb(const RenderOptions& o)
{
    if (ending(o.out) != ".png")
        throw UsageError("--out: expected a file ending in .png, found \"" + o.out + "\"");
    const Device device = resolved(parse_device(o.device));
    SplatCloud cloud = read_all(o.files, o.quiet);
    sort_by_place(cloud);
    const Path path = path_of(o, cloud);
    SplatFrame frame;
    frame.rule.antialiased = cloud.antialiased;
    if (!o.background.empty()) frame.background = cast<float>(triple("--background", o.background));
    const int frames = std::max(o.orbit, 1);
    for (int k = 0; k < frames; ++k) prepare_file(name_of(o, k), o.overwrite);
    std::unique_ptr<GpuRaster> gpu;
    if (device.kind == DeviceKind::cuda) gpu = std::make_unique<GpuRaster>(cloud, 0, device.index);
    watch_interrupts();
    for (int k = 0; k < frames && !interrupted(); ++k) {
        frame.eyes = path.eyes(2 * std::numbers::pi * k / frames);
        const std::string file = name_of(o, k);
        write_png(file,
                  image_of(gpu                                     ? gpu->pictures(frame)
                           : device.kind == DeviceKind::cpu_double ? exact_raster(cloud, frame)
                                                                   : cpu_raster(cloud, frame)));
        if (!o.quiet) std::printf("%s\n", file.c_str());
    }
    return interrupted() ? 128 + interrupted() : int(exit_ok);
}

}  // namespace knead
