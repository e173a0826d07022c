// The rasteriser on the CPU: project all splats, sort once, list by tile, blend.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "host/base/parallel.h"
#include "host/splats/cancellable_for.h"
#include "host/splats/prepared.h"

namespace knead {
namespace {

constexpr int tile = hidden_tile;

struct SeenSplat {
    Footprint<float> shape;
    Vec3<float> colour;
};

// The splats visible to any eye, in sorted order, with their footprint for each eye.
struct Sorted {
    std::vector<std::uint32_t> keys;
    std::vector<int> order;
    std::vector<std::vector<Footprint<float>>> seen;  // per eye, per splat of the cloud
    std::vector<std::vector<char>> visible;
};

// Returns false, like all functions below, if the frame was stopped.
bool sort_seen(const SplatCloud& cloud, const SplatFrame& frame, Sorted& s)
{
    const std::size_t count = cloud.count(), eyes = frame.eyes.size();
    const Vec3<float> middle = cast<float>(middle_of(frame));
    std::vector<Pinhole<float>> cameras;
    for (const Eye<float>& e : frame.eyes) cameras.push_back(pinhole(e));
    s.seen.resize(eyes), s.visible.resize(eyes);
    for (std::size_t e = 0; e < eyes; ++e)
        if (!resize_unless_stopped(s.seen[e], count, frame) ||
            !resize_unless_stopped(s.visible[e], count, frame))
            return false;
    if (!resize_unless_stopped(s.keys, count, frame)) return false;
    const auto see = [&](std::size_t i) {
        const PosedSplat<float> p = posed<float>(cloud, frame, i);
        s.keys[i] = no_depth_key;
        for (std::size_t e = 0; e < eyes; ++e)
            if (project(cameras[e], frame.options, p.centre, p.half_axes, cloud.opacity[i],
                        s.seen[e][i])) {
                s.visible[e][i] = 1;
                s.keys[i] = depth_key(p.centre - middle, frame.options.near);
            }
    };
    const auto keep = [&](std::size_t i) {
        if (s.keys[i] != no_depth_key) s.order.push_back(int(i));
    };
    return parallel_for_unless_stopped(count, frame, see) &&
           for_each_unless_stopped(count, frame, keep) &&
           sort_unless_stopped(s.order, frame, [&](int a, int b) {
               return s.keys[std::size_t(a)] < s.keys[std::size_t(b)];
           });
}

// Collects the splats visible to one eye, nearest first.
bool find_seen(std::size_t e, const Sorted& s, const SplatCloud& cloud, const SplatFrame& frame,
               std::vector<SeenSplat>& seen)
{
    std::vector<int> which;
    const auto choose = [&](std::size_t n) {
        if (s.visible[e][std::size_t(s.order[n])]) which.push_back(s.order[n]);
    };
    const auto see = [&](std::size_t n) {
        const auto i = std::size_t(which[n]);
        const PosedSplat<float> p = posed<float>(cloud, frame, i);
        seen[n] = {s.seen[e][i], colour_from(frame.eyes[e].position, p, cloud, i)};
    };
    return for_each_unless_stopped(s.order.size(), frame, choose) &&
           resize_unless_stopped(seen, which.size(), frame) &&
           parallel_for_unless_stopped(which.size(), frame, see);
}

// First and last tile along one axis that the interval from `low` to `high` may touch.
struct Tiles {
    int first, last;
};
Tiles tiles_between(float low, float high, int tiles)
{
    const float end = float(tiles * tile - 1);
    return {int(std::ceil(clamp(low, 0.0f, end))) / tile, int(clamp(high, -1.0f, end)) / tile};
}

// Lists the splats of each tile of a row, in the order of `seen`. `hidden`, per tile of the row: 1
// for an empty list; null: none is hidden.
bool list_row(const std::vector<SeenSplat>& seen, int row, const SplatFrame& frame,
              const Eye<float>& eye, const char* hidden, std::vector<std::vector<int>>& lists)
{
    const int columns = (eye.width + tile - 1) / tile, rows = (eye.height + tile - 1) / tile;
    lists.resize(std::size_t(columns));
    return for_each_unless_stopped(seen.size(), frame, [&](std::size_t n) {
        const Footprint<float>& f = seen[n].shape;
        const Tiles y = tiles_between(f.v - f.half_height, f.v + f.half_height, rows);
        if (row < y.first || row > y.last) return;
        const Tiles x = tiles_between(f.u - f.half_width, f.u + f.half_width, columns);
        for (int k = x.first; k <= x.last; ++k) {
            if (hidden && hidden[k]) continue;
            const float x0 = float(k * tile), y0 = float(row * tile);
            if (reaches(f, x0, y0, x0 + tile - 1, y0 + tile - 1))
                lists[std::size_t(k)].push_back(int(n));
        }
    });
}

struct Target {
    Picture& picture;
    const Backdrop* behind;
    Vec3<float> background;

    // Draws a block of `step` x `step` pixels at (x, y) from one sample at its centre, over the
    // splats of `list`. The background is sampled per pixel.
    void draw(int x, int y, int step, const std::vector<int>& list,
              const std::vector<SeenSplat>& seen) const
    {
        const float u = float(x) + sample_offset(step), v = float(y) + sample_offset(step);
        const int right = std::min(x + step, picture.width),
                  low = std::min(y + step, picture.height);
        const float mesh = mesh_at(place(std::min(x + step / 2, picture.width - 1),
                                         std::min(y + step / 2, picture.height - 1)));
        Pixel<float> p;
        for (int n : list) {
            blend(p, seen[std::size_t(n)].shape, seen[std::size_t(n)].colour, u, v, mesh);
            if (done(p)) break;
        }
        for (int j = y; j < low; ++j)
            for (int i = x; i < right; ++i) put(p, place(i, j));
    }

    std::size_t place(int x, int y) const
    {
        return std::size_t(y) * std::size_t(picture.width) + std::size_t(x);
    }
    float mesh_at(std::size_t at) const { return behind ? behind->depth[at] : no_depth; }
    void put(Pixel<float> p, std::size_t at) const
    {
        const float mesh = mesh_at(at);
        const bool hit = mesh < no_depth;
        finish(p, hit ? behind->colour[at] : background, hit ? 1.0f : 0.0f, mesh);
        picture.colour[at] = p.colour;
        picture.alpha[at] = 1 - p.transmittance;
        picture.depth[at] = p.depth;
    }
};

}  // namespace

void check_frame(const SplatCloud& cloud, const SplatFrame& frame)
{
    const auto refuse = [](const std::string& why) {
        throw std::invalid_argument("splats: " + why);
    };
    const std::size_t n = cloud.count();
    if (cloud.rotation.size() != n || cloud.scale.size() != n || cloud.opacity.size() != n ||
        cloud.degree < 0 || cloud.degree > max_sh_degree ||
        cloud.sh.size() != n * std::size_t(harmonics(cloud.degree)))
        refuse("a cloud with arrays of different length");
    if (n > std::size_t(1) << 28) refuse("more than 2^28 splats");
    if (frame.eyes.empty() || frame.eyes.size() > 2) refuse("expected one or two eyes");
    for (const Eye<float>& e : frame.eyes)
        if (!valid(e)) refuse("an eye with an invalid frustum or size");
    const SplatOptions<float>& r = frame.options;
    if (!(r.near > 0) || !(r.near_full >= r.near) || !(r.near_full < 1e9f))
        refuse("expected 0 < near <= near_full");
    if (!frame.behind.empty() && frame.behind.size() != frame.eyes.size())
        refuse("expected a backdrop for each eye");
    for (std::size_t e = 0; e < frame.behind.size(); ++e) {
        const Backdrop& b = frame.behind[e];
        const std::size_t pixels =
            std::size_t(frame.eyes[e].width) * std::size_t(frame.eyes[e].height);
        if (b.colour.size() != b.depth.size() || (b.depth.size() && b.depth.size() != pixels))
            refuse("a backdrop of another size than the eye's picture");
    }
    if (!frame.hidden.empty() && frame.hidden.size() != frame.eyes.size())
        refuse("expected hidden tiles for each eye");
    for (std::size_t e = 0; e < frame.hidden.size(); ++e) {
        const auto along = [](int pixels) { return std::size_t((pixels + tile - 1) / tile); };
        const std::size_t tiles = along(frame.eyes[e].width) * along(frame.eyes[e].height);
        if (!frame.hidden[e].empty() && frame.hidden[e].size() != tiles)
            refuse("hidden tiles of a picture of another size");
    }
    if (!frame.fovea.empty() && frame.fovea.size() != frame.eyes.size())
        refuse("expected a fovea for each eye");
    for (const Fovea<float>& f : frame.fovea)
        if (!(std::fabs(f.x) < 1000 && std::fabs(f.y) < 1000 && f.fine >= 0 &&
              f.middling >= f.fine && f.middling <= 1e9f))
            refuse("expected a fovea with 0 <= fine <= middling");
    if (frame.moved_centre.size() != frame.moved_F.size() || frame.moved_centre.size() > n)
        refuse("more moved splats than splats");
}

namespace {

// Draws a row of tiles until the frame is stopped. `steps`: block size per square of the fovea.
void draw_row(const Target& target, int row, const std::vector<std::vector<int>>& lists,
              const std::vector<int>& steps, const std::vector<SeenSplat>& seen,
              const SplatFrame& frame)
{
    const int low = row * tile, high = std::min(target.picture.height, low + tile);
    std::size_t since_poll = 0;
    for (int y = low; y < high; ++y)
        for (int x = 0; x < target.picture.width; ++x) {
            const int step = steps[std::size_t(x / fovea_square)];
            if (x % step != 0 || y % step != 0) continue;
            const std::vector<int>& list = lists[std::size_t(x / tile)];
            since_poll += 16 + list.size();
            if (since_poll > poll_interval) {
                if (frame.stopped()) return;
                since_poll = 0;
            }
            target.draw(x, y, step, list, seen);
        }
}

// Block sizes of one row of squares.
std::vector<int> steps_along(const SplatFrame& frame, std::size_t e, int y)
{
    const Pinhole<float> eye = pinhole(frame.eyes[e]);
    const Fovea<float> fovea = frame.fovea.empty() ? Fovea<float>{} : frame.fovea[e];
    std::vector<int> steps;
    for (int x = 0; x < eye.width; x += fovea_square)
        steps.push_back(fovea_step(fovea, eye, x, y / fovea_square * fovea_square));
    return steps;
}

bool draw_eye(std::size_t e, const std::vector<SeenSplat>& seen, const SplatFrame& frame,
              Picture& picture)
{
    const Eye<float>& eye = frame.eyes[e];
    const int width = eye.width, height = eye.height;
    if (!resize_unless_stopped(picture, eye, frame)) return false;
    const bool mesh = !frame.behind.empty() && !frame.behind[e].depth.empty();
    const Target target{picture, mesh ? &frame.behind[e] : nullptr, frame.background};
    const int columns = (width + tile - 1) / tile, rows = (height + tile - 1) / tile;
    const bool all = frame.hidden.empty() || frame.hidden[e].empty();
    parallel_for(rows, LoopOptions{.chunk = 1}, [&](int row) {
        std::vector<std::vector<int>> lists;
        const char* const hidden =
            all ? nullptr : frame.hidden[e].data() + std::ptrdiff_t(row) * columns;
        if (!list_row(seen, row, frame, eye, hidden, lists)) return;
        draw_row(target, row, lists, steps_along(frame, e, row * tile), seen, frame);
    });
    return !frame.stopped();
}

}  // namespace

Fovea<float> fovea_of(double degrees)
{
    const auto tangent = [](double angle) {
        return float(std::tan(std::min(angle, 89.0) * std::numbers::pi / 180));
    };
    return {0, 0, tangent(degrees), tangent(degrees + 15)};
}

double blended_share(const SplatFrame& frame, std::size_t eye)
{
    const int width = frame.eyes[eye].width, height = frame.eyes[eye].height;
    double samples = 0;
    for (int y = 0; y < height; y += fovea_square) {
        int x = 0;
        for (const int step : steps_along(frame, eye, y)) {
            const auto along = [step](int from, int end) {
                return (std::min(end - from, fovea_square) + step - 1) / step;
            };
            samples += double(along(x, width)) * along(y, height);
            x += fovea_square;
        }
    }
    return samples / (double(width) * height);
}

std::vector<Picture> cpu_raster(const SplatCloud& cloud, const SplatFrame& frame)
{
    check_frame(cloud, frame);
    Sorted order;
    if (!sort_seen(cloud, frame, order)) return {};
    std::vector<Picture> pictures(frame.eyes.size());
    for (std::size_t e = 0; e < frame.eyes.size(); ++e) {
        std::vector<SeenSplat> seen;
        if (!find_seen(e, order, cloud, frame, seen) || !draw_eye(e, seen, frame, pictures[e]))
            return {};
    }
    return pictures;
}

double psnr(const Picture& a, const Picture& b)
{
    if (a.width != b.width || a.height != b.height || a.pixels() != b.pixels() || !a.pixels())
        throw std::invalid_argument("pictures of different sizes, or empty");
    double sum = 0;
    for (std::size_t i = 0; i < a.pixels(); ++i) {
        const Vec3<double> d = cast<double>(a.colour[i]) - cast<double>(b.colour[i]);
        sum += dot(d, d);
    }
    const double mean = sum / (3 * double(a.pixels()));
    if (mean == 0) return 200;
    return std::min(200.0, -10 * std::log10(mean));
}

}  // namespace knead
