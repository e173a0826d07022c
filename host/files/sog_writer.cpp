// SOG of PlayCanvas, version 2, written: a ZIP of lossless WebP images, of which each has a pixel a
// splat. docs/reference/formats.md.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>

#include "host/base/errors.h"
#include "host/files/splat_gather.h"
#include "host/files/webp.h"
#include "host/files/zip.h"

namespace knead {
namespace {

using Json = nlohmann::json;
constexpr std::size_t code_count = 256, entries_a_row = 64, most_entries = 65536;
constexpr int largest_image = 16383, lloyd_steps = 40;
constexpr std::size_t largest_sample = 1 << 19;

// The codes of a codebook, ascending, and the nearest one of a value.
class Codebook {
  public:
    // Lloyd's algorithm in one dimension: each code is the mean of the values nearest to it. Exact
    // for at most 256 different values.  [Lloyd 1982]
    explicit Codebook(std::vector<float> values)
    {
        std::sort(values.begin(), values.end());
        for (const float v : values)
            if (codes.size() <= code_count && (codes.empty() || v != codes.back()))
                codes.push_back(v);
        if (codes.size() <= code_count) {
            codes.resize(code_count, codes.empty() ? 0 : codes.back());
            return;
        }
        codes.clear();
        // Half of the first codes by share of the values, half by their range.
        for (std::size_t k = 0; k < code_count / 2; ++k) {
            const double t = (double(k) + 0.5) / (code_count / 2.0);
            codes.push_back(values[std::size_t(t * double(values.size()))]);
            codes.push_back(std::lerp(values.front(), values.back(), float(t)));
        }
        std::sort(codes.begin(), codes.end());
        std::vector<double> sums(values.size() + 1, 0);
        std::partial_sum(values.begin(), values.end(), sums.begin() + 1,
                         [](double a, float b) { return a + double(b); });
        for (int n = 0; n < lloyd_steps; ++n) improve(values, sums);
        codes.front() = std::min(codes.front(), values.front());
        codes.back() = std::max(codes.back(), values.back());
    }

    std::uint8_t nearest(float value) const
    {
        const auto above = std::lower_bound(codes.begin(), codes.end(), value);
        if (above == codes.begin()) return 0;
        const bool lower = above == codes.end() || value - *(above - 1) <= *above - value;
        return std::uint8_t(above - codes.begin() - (lower ? 1 : 0));
    }

    Json json() const { return codes; }

  private:
    void improve(const std::vector<float>& values, const std::vector<double>& sums)
    {
        std::size_t from = 0;
        for (std::size_t k = 0; k < code_count; ++k) {
            std::size_t to = values.size();
            if (k + 1 < code_count) {
                const float middle = codes[k] + (codes[k + 1] - codes[k]) / 2;
                to = std::size_t(
                    std::upper_bound(values.begin() + std::ptrdiff_t(from), values.end(), middle) -
                    values.begin());
            }
            if (to > from) codes[k] = float((sums[to] - sums[from]) / double(to - from));
            from = to;
        }
        std::sort(codes.begin(), codes.end());
    }

    std::vector<float> codes;
};

// `n` values at(0), at(1), ..., or an even sample of them.
std::vector<float> sampled_values(std::size_t n, const std::function<float(std::size_t)>& at)
{
    const std::size_t size = std::min(n, largest_sample);
    std::vector<float> all(size);
    for (std::size_t k = 0; k < size; ++k) all[k] = at(k * n / size);
    return all;
}

// Groups splats with similar harmonics: boxes in the space of coefficients are cut through the
// mean of the coefficient that varies most, until there are as many as entries.
class Palette {
  public:
    explicit Palette(const SplatCloud& given)
        : cloud(given), rest(std::size_t(harmonics(given.degree)) - 1), labels(given.count())
    {
        if (cloud.count() <= most_entries) {
            std::iota(labels.begin(), labels.end(), 0u);
            for (std::size_t i = 0; i < cloud.count(); ++i)
                for (std::size_t k = 0; k < rest; ++k) entries.push_back(value(i, k));
            return;
        }
        order.resize(cloud.count());
        std::iota(order.begin(), order.end(), 0u);
        std::vector<Group> groups{{0, order.size(), most_entries}};
        while (!groups.empty()) {
            const Group next = groups.back();
            groups.pop_back();
            split(next, groups);
        }
    }

    std::size_t count() const { return entries.size() / rest; }
    const Vec3<float>& entry(std::size_t label, std::size_t k) const
    {
        return entries[label * rest + k];
    }
    std::uint32_t label(std::size_t i) const { return labels[i]; }

  private:
    const Vec3<float>& value(std::size_t i, std::size_t k) const
    {
        return cloud.sh[i * (rest + 1) + k + 1];
    }
    static float channel(Vec3<float> v, std::size_t c) { return c == 0 ? v.x : c == 1 ? v.y : v.z; }

    // Splats order[from, to), which become at most `most` entries.
    struct Group {
        std::size_t from, to, most;
    };

    void split(const Group& group, std::vector<Group>& groups)
    {
        const auto [from, to, most] = group;
        std::vector<Vec3<double>> sum(rest, Vec3<double>{0, 0, 0}), square = sum;
        for (std::size_t n = from; n < to; ++n)
            for (std::size_t k = 0; k < rest; ++k) {
                const Vec3<double> v = cast<double>(value(order[n], k));
                sum[k] = sum[k] + v;
                square[k] = square[k] + Vec3<double>{v.x * v.x, v.y * v.y, v.z * v.z};
            }
        const double share = 1 / double(to - from);
        double widest = 0, mean = 0;
        std::size_t axis = 0;
        for (std::size_t k = 0; k < rest; ++k) {
            const double s[] = {sum[k].x, sum[k].y, sum[k].z},
                         q[] = {square[k].x, square[k].y, square[k].z};
            for (std::size_t c = 0; c < 3; ++c) {
                const double variance = q[c] * share - s[c] * share * (s[c] * share);
                if (variance > widest) widest = variance, axis = 3 * k + c, mean = s[c] * share;
            }
        }
        const auto begin = order.begin() + std::ptrdiff_t(from),
                   end = order.begin() + std::ptrdiff_t(to);
        const auto middle = most < 2 || !(widest > 0)
                                ? begin
                                : std::stable_partition(begin, end, [&](std::uint32_t i) {
                                      return double(channel(value(i, axis / 3), axis % 3)) < mean;
                                  });
        if (middle == begin || middle == end) {
            for (std::size_t n = from; n < to; ++n)
                labels[order[n]] = std::uint32_t(entries.size() / rest);
            for (std::size_t k = 0; k < rest; ++k) entries.push_back(cast<float>(share * sum[k]));
            return;
        }
        // Entries in proportion to the splats, each side with one at least.
        const auto left = std::size_t(middle - begin);
        const auto entries_left = std::clamp<std::size_t>(
            std::size_t(std::llround(double(most) * double(left) * share)), 1, most - 1);
        groups.push_back({from, from + left, entries_left});
        groups.push_back({from + left, to, most - entries_left});
    }

    const SplatCloud& cloud;
    const std::size_t rest;  // coefficients above degree 0
    std::vector<std::uint32_t> labels, order;
    std::vector<Vec3<float>> entries;
};

class SogWriter {
  public:
    SogWriter(const SplatCloud& given, const std::string& file)
        : cloud(given),
          path(file),
          order(order_by_place(given)),
          stride(std::size_t(harmonics(given.degree)))
    {
        // Sides are multiples of 4.
        const double side = std::sqrt(double(cloud.count()));
        width = int(std::ceil(side / 4)) * 4;
        height = int((cloud.count() + 4 * std::size_t(width) - 1) / (4 * std::size_t(width))) * 4;
        if (width > largest_image || height > largest_image)
            throw InputError(fmt::format("{}: SOG: expected at most 268 million splats, found {}",
                                         path, cloud.count()));
    }

    std::string bytes()
    {
        meta = {{"version", 2}, {"asset", {{"generator", "knead"}}}, {"count", cloud.count()}};
        if (cloud.antialiased) meta["model"] = "antialiased";
        add_centres();
        add_rotations();
        add_scales();
        add_colours();
        if (cloud.degree > 0) add_harmonics();
        files.insert(files.begin(), {"meta.json", meta.dump()});
        return zip_bytes(files, path);
    }

  private:
    using Pixel = std::array<std::uint8_t, 4>;

    // Adds an image of a pixel for each splat.
    void add_image(const char* name, const std::function<Pixel(std::uint32_t)>& pixel)
    {
        RgbaImage image{width, height, {}};
        image.pixels.reserve(4 * std::size_t(width) * std::size_t(height));
        for (const std::uint32_t i : order)
            for (const std::uint8_t part : pixel(i)) image.pixels.push_back(part);
        image.pixels.resize(4 * std::size_t(width) * std::size_t(height), 0);
        files.emplace_back(name, webp_bytes(image));
    }

    static double compressed(double x) { return std::copysign(std::log1p(std::abs(x)), x); }

    void add_centres()
    {
        std::array<double, 3> low, high;
        low.fill(std::numeric_limits<double>::infinity()), high.fill(-low[0]);
        const auto parts = [&](std::uint32_t i) {
            const Vec3<float> x = cloud.centre[i];
            return std::array<double, 3>{compressed(x.x), compressed(x.y), compressed(x.z)};
        };
        for (const std::uint32_t i : order) {
            const auto n = parts(i);
            for (std::size_t k = 0; k < 3; ++k)
                low[k] = std::min(low[k], n[k]), high[k] = std::max(high[k], n[k]);
        }
        const auto word = [&](std::uint32_t i, std::size_t k) {
            const double range = high[k] - low[k];
            return range > 0 ? unsigned(std::lround(65535 * (parts(i)[k] - low[k]) / range)) : 0u;
        };
        for (const int shift : {0, 8})
            add_image(shift == 0 ? "means_l.webp" : "means_u.webp", [&](std::uint32_t i) {
                const auto part = [&](std::size_t k) { return std::uint8_t(word(i, k) >> shift); };
                return Pixel{part(0), part(1), part(2), 255};
            });
        meta["means"] = {
            {"mins", low}, {"maxs", high}, {"files", {"means_l.webp", "means_u.webp"}}};
    }

    void add_rotations()
    {
        add_image("quats.webp", [&](std::uint32_t i) {
            const Quat<double> u = unit(cast<double>(cloud.rotation[i]));
            const std::array<double, 4> q{u.w, u.x, u.y, u.z};
            std::size_t largest = 0;
            for (std::size_t k = 1; k < 4; ++k)
                if (std::abs(q[k]) > std::abs(q[largest])) largest = k;
            Pixel p{0, 0, 0, std::uint8_t(252 + largest)};
            const double sign = q[largest] < 0 ? -1 : 1;
            for (std::size_t k = 0, n = 0; k < 4; ++k)
                if (k != largest)
                    p[n++] = byte(255 * (sign * q[k] * std::numbers::sqrt2 / 2 + 0.5));
            return p;
        });
        meta["quats"] = {{"files", {"quats.webp"}}};
    }

    // Natural logarithms: of 0 as the other formats have it, of the largest floats a step less.
    static float logarithm_of(float s)
    {
        return float(std::clamp(std::log(double(s)), -20.0, 88.7228));
    }

    void add_scales()
    {
        const auto part = [&](std::size_t n) {
            const Vec3<float> s = cloud.scale[n / 3];
            return logarithm_of(n % 3 == 0 ? s.x : n % 3 == 1 ? s.y : s.z);
        };
        const Codebook book(sampled_values(3 * cloud.count(), part));
        add_image("scales.webp", [&](std::uint32_t i) {
            const Vec3<float> s = cloud.scale[i];
            return Pixel{book.nearest(logarithm_of(s.x)), book.nearest(logarithm_of(s.y)),
                         book.nearest(logarithm_of(s.z)), 255};
        });
        meta["scales"] = {{"codebook", book.json()}, {"files", {"scales.webp"}}};
    }

    void add_colours()
    {
        const auto part = [&](std::size_t n) {
            const Vec3<float> c = cloud.sh[n / 3 * stride];
            return n % 3 == 0 ? c.x : n % 3 == 1 ? c.y : c.z;
        };
        const Codebook book(sampled_values(3 * cloud.count(), part));
        add_image("sh0.webp", [&](std::uint32_t i) {
            const Vec3<float> c = cloud.sh[i * stride];
            return Pixel{book.nearest(c.x), book.nearest(c.y), book.nearest(c.z),
                         byte(255 * double(cloud.opacity[i]))};
        });
        meta["sh0"] = {{"codebook", book.json()}, {"files", {"sh0.webp"}}};
    }

    void add_harmonics()
    {
        const Palette palette(cloud);
        const std::size_t rest = stride - 1, count = palette.count();
        const Codebook book(sampled_values(3 * rest * count, [&](std::size_t n) {
            const Vec3<float> c = palette.entry(n / 3 / rest, n / 3 % rest);
            return n % 3 == 0 ? c.x : n % 3 == 1 ? c.y : c.z;
        }));
        RgbaImage image{
            int(entries_a_row * rest), int((count + entries_a_row - 1) / entries_a_row), {}};
        image.pixels.reserve(4 * std::size_t(image.width) * std::size_t(image.height));
        for (std::size_t label = 0; label < count; ++label)
            for (std::size_t k = 0; k < rest; ++k) {
                const Vec3<float> c = palette.entry(label, k);
                for (const float v : {c.x, c.y, c.z}) image.pixels.push_back(book.nearest(v));
                image.pixels.push_back(255);
            }
        image.pixels.resize(4 * std::size_t(image.width) * std::size_t(image.height), 0);
        files.emplace_back("shN_centroids.webp", webp_bytes(image));
        add_image("shN_labels.webp", [&](std::uint32_t i) {
            const std::uint32_t label = palette.label(i);
            return Pixel{std::uint8_t(label), std::uint8_t(label >> 8), 0, 255};
        });
        meta["shN"] = {{"count", count},
                       {"bands", cloud.degree},
                       {"codebook", book.json()},
                       {"files", {"shN_centroids.webp", "shN_labels.webp"}}};
    }

    const SplatCloud& cloud;
    const std::string& path;
    const std::vector<std::uint32_t> order;
    const std::size_t stride;
    int width = 0, height = 0;
    Json meta;
    std::vector<std::pair<std::string, std::string>> files;
};

}  // namespace

std::string sog_bytes(const SplatCloud& cloud, const std::string& path)
{
    if (cloud.count() == 0) throw InputError(path + ": expected splats, found none");
    return SogWriter(cloud, path).bytes();
}

}  // namespace knead
