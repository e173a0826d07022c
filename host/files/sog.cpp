// SOG of PlayCanvas, versions 1 and 2, read: images of quantised values, a pixel a splat, and their
// ranges or codebooks in meta.json; in a folder or a ZIP. docs/reference/formats.md.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/paths.h"
#include "host/files/splat_gather.h"
#include "host/files/webp.h"
#include "host/files/zip.h"

namespace knead {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t longest_side = 16383;  // of a WebP image
constexpr std::size_t codes = 256, palette_row = 64, longest_palette = 65536;
// Decompression limit: images of more pixels than this and than this multiple of the file's bytes
// are rejected.
constexpr std::size_t pixels_anyway = 1 << 24, pixels_ratio = 25;

// Where meta.json and the images are.
struct SogSource {
    std::string path;  // for errors
    std::function<std::string(const std::string& name)> read;
    std::size_t most_pixels = 0;
};

class SogReader {
  public:
    explicit SogReader(SogSource from) : source(std::move(from))
    {
        meta = parse_json(source.read("meta.json"), where("meta.json"));
        if (!meta.is_object()) fail("", "an object", described(meta));
        if (meta.contains("lod") || meta.contains("lodLevels") || meta.contains("tree"))
            fail("", "one cloud of splats", "a tree of levels of detail (streamed SOG)");
        version = meta.contains("version") ? int(whole("version", 0, 1000)) : 1;
        if (version != 1 && version != 2)
            fail("/version", "version 1 or 2", std::to_string(version));
        count = version == 2 ? whole("count", 0, UINT32_MAX) : shape_count();
    }

    SplatFile read()
    {
        SplatFile file;
        file.format = "sog";
        SplatCloud& cloud = file.cloud;
        if (const Json model = meta.value("model", Json()); model == "antialiased")
            cloud.antialiased = true;
        // The first image bounds the count, before anything is allocated for it.
        read_centres(cloud);
        read_rotations(cloud);
        read_scales(cloud);
        read_colours(cloud);
        if (meta.contains("shN")) add_harmonics(cloud);
        if (cloud.count() == 0) throw InputError(source.path + ": expected splats, found none");
        drop_not_finite(file, source.path);
        return file;
    }

  private:
    std::string where(const std::string& name) const { return source.path + ": " + name; }
    [[noreturn]] void fail(const std::string& pointer, const std::string& expected,
                           const std::string& found) const
    {
        refuse(where("meta.json"), pointer.empty() ? "/" : pointer, expected, found);
    }
    [[noreturn]] static void refuse(const std::string& path, const std::string& place,
                                    const std::string& expected, const std::string& found)
    {
        throw InputError(
            fmt::format("{}: {}: expected {}, found {}", path, place, expected, found));
    }

    std::size_t whole(const char* key, std::size_t low, std::size_t high) const
    {
        const Json v = meta.value(key, Json());
        if (!v.is_number_unsigned() || v.get<std::uint64_t>() < low ||
            v.get<std::uint64_t>() > high)
            fail(std::string("/") + key, "a whole number", described(v));
        return v.get<std::size_t>();
    }

    const Json& section(const char* key) const
    {
        const auto at = meta.find(key);
        if (at == meta.end() || !at->is_object())
            fail(std::string("/") + key, "an object",
                 at == meta.end() ? "nothing" : described(*at));
        return *at;
    }

    std::size_t shape_count() const
    {
        const Json& means = section("means");
        const auto shape = means.find("shape");
        if (shape == means.end() || !shape->is_array() || shape->empty() ||
            !(*shape)[0].is_number_unsigned() || (*shape)[0].get<std::uint64_t>() > UINT32_MAX)
            fail("/means/shape", "the number of splats first", "something else");
        return (*shape)[0].get<std::size_t>();
    }

    // `n` finite numbers.
    std::vector<double> numbers(const char* of, const char* key, std::size_t n) const
    {
        const Json& in = section(of);
        const std::string pointer = fmt::format("/{}/{}", of, key);
        const auto at = in.find(key);
        if (at == in.end() || !at->is_array() || at->size() != n)
            fail(pointer, fmt::format("{} numbers", n),
                 at == in.end()    ? "nothing"
                 : !at->is_array() ? described(*at)
                                   : std::to_string(at->size()));
        std::vector<double> all;
        for (const Json& v : *at) {
            if (!v.is_number() || !std::isfinite(v.get<double>()))
                fail(pointer, "finite numbers", described(v));
            all.push_back(v.get<double>());
        }
        return all;
    }

    std::string image_name(const char* of, std::size_t k, std::size_t n) const
    {
        const Json& in = section(of);
        const std::string pointer = fmt::format("/{}/files", of);
        const auto at = in.find("files");
        if (at == in.end() || !at->is_array() || at->size() != n || !(*at)[k].is_string())
            fail(pointer, fmt::format("{} names of files", n), "something else");
        const std::string name = (*at)[k].get<std::string>();
        // Of the folder itself: a downloaded file must not name others.
        if (name.empty() || name.find_first_of("/\\") != std::string::npos || name == ".." ||
            name == ".")
            fail(pointer, "names of files beside meta.json", "\"" + name.substr(0, 80) + "\"");
        return name;
    }

    RgbaImage image(const char* of, std::size_t k, std::size_t n) const
    {
        const std::string name = image_name(of, k, n);
        return read_webp(source.read(name), where(name), source.most_pixels);
    }
    // A pixel for each splat.
    RgbaImage image_of_splats(const char* of, std::size_t k, std::size_t n) const
    {
        RgbaImage found = image(of, k, n);
        if (found.pixels.size() / 4 < count)
            refuse(where(image_name(of, k, n)), "size", fmt::format("pixels of {} splats", count),
                   fmt::format("{} x {}", found.width, found.height));
        return found;
    }

    // sign(n) (e^|n| - 1) of 16 bits between the bounds.
    void read_centres(SplatCloud& cloud) const
    {
        const auto low = numbers("means", "mins", 3), high = numbers("means", "maxs", 3);
        const RgbaImage lower = image_of_splats("means", 0, 2),
                        upper = image_of_splats("means", 1, 2);
        cloud.centre.reserve(count);
        for (std::size_t i = 0; i < count; ++i) {
            const auto at = [&](std::size_t k) {
                const double t = (lower.pixels[4 * i + k] + 256.0 * upper.pixels[4 * i + k]) /
                                 65535,
                             n = low[k] + (high[k] - low[k]) * t;
                return float(std::copysign(std::expm1(std::abs(n)), n));
            };
            cloud.centre.push_back({at(0), at(1), at(2)});
        }
    }

    // The index of the largest of w, x, y, z in alpha, from 252; the others in ascending order.
    void read_rotations(SplatCloud& cloud) const
    {
        const RgbaImage pixels = image_of_splats("quats", 0, 1);
        cloud.rotation.reserve(count);
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint8_t* p = pixels.pixels.data() + 4 * i;
            if (p[3] < 252) {
                cloud.rotation.push_back({1, 0, 0, 0});
                continue;
            }
            const std::size_t largest = p[3] - 252u;
            std::array<double, 4> q{};
            double rest = 1;
            for (std::size_t k = 0, n = 0; k < 4; ++k) {
                if (k == largest) continue;
                q[k] = (p[n++] / 255.0 * 2 - 1) / std::numbers::sqrt2;
                rest -= q[k] * q[k];
            }
            q[largest] = std::sqrt(std::max(0.0, rest));
            cloud.rotation.push_back(cast<float>(unit(Quat<double>{q[0], q[1], q[2], q[3]})));
        }
    }

    // Values of a channel: of a codebook in version 2, between bounds in version 1.
    std::array<std::vector<double>, 4> tables(const char* of, std::size_t channels) const
    {
        std::array<std::vector<double>, 4> all;
        if (version == 2) {
            all[0] = numbers(of, "codebook", codes);
            for (std::size_t k = 1; k < 3; ++k) all[k] = all[0];
            return all;
        }
        const auto low = numbers(of, "mins", channels), high = numbers(of, "maxs", channels);
        for (std::size_t k = 0; k < channels; ++k)
            for (std::size_t b = 0; b < codes; ++b)
                all[k].push_back(low[k] + (high[k] - low[k]) * double(b) / 255);
        return all;
    }

    void read_scales(SplatCloud& cloud) const
    {
        const auto table = tables("scales", 3);
        const RgbaImage pixels = image_of_splats("scales", 0, 1);
        cloud.scale.reserve(count);
        for (std::size_t i = 0; i < count; ++i) {
            const auto at = [&](std::size_t k) {
                return float(std::exp(table[k][pixels.pixels[4 * i + k]]));
            };
            cloud.scale.push_back({at(0), at(1), at(2)});
        }
    }

    void read_colours(SplatCloud& cloud)
    {
        const auto table = tables("sh0", 4);
        const RgbaImage pixels = image_of_splats("sh0", 0, 1);
        RgbaImage centroids;
        if (meta.contains("shN")) {
            centroids = image("shN", 0, 2);
            cloud.degree = degree_of(centroids);
        }
        const auto stride = std::size_t(harmonics(cloud.degree));
        cloud.opacity.reserve(count);
        cloud.sh.assign(count * stride, Vec3<float>{0, 0, 0});
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint8_t* p = pixels.pixels.data() + 4 * i;
            cloud.sh[i * stride] = {float(table[0][p[0]]), float(table[1][p[1]]),
                                    float(table[2][p[2]])};
            // A logit in version 1.
            cloud.opacity.push_back(
                float(version == 2 ? p[3] / 255.0 : 1 / (1 + std::exp(-table[3][p[3]]))));
        }
        palette = std::move(centroids);
    }

    // By the number of bands, or by the width: 64 entries of 3, 8 or 15 coefficients a row.
    int degree_of(const RgbaImage& centroids) const
    {
        for (int degree = 1; degree <= max_sh_degree; ++degree) {
            if (std::size_t(centroids.width) != palette_row * std::size_t(harmonics(degree) - 1))
                continue;
            const Json bands = section("shN").value("bands", Json(degree));
            if (bands == degree) return degree;
            fail("/shN/bands", std::to_string(degree) + ", by the width of its palette",
                 described(bands));
        }
        refuse(where(image_name("shN", 0, 2)), "size", "a width of 192, 512 or 960 pixels",
               std::to_string(centroids.width));
    }

    void add_harmonics(SplatCloud& cloud) const
    {
        std::vector<double> table;
        if (version == 2) {
            table = numbers("shN", "codebook", codes);
        } else {
            const double low = number("mins"), high = number("maxs");
            for (std::size_t b = 0; b < codes; ++b)
                table.push_back(low + (high - low) * double(b) / 255);
        }
        const RgbaImage labels = image_of_splats("shN", 1, 2);
        std::size_t entries = palette_row * std::size_t(palette.height);
        if (const Json stated = section("shN").value("count", Json()); stated.is_number_unsigned())
            entries = std::min(entries, stated.get<std::size_t>());
        entries = std::min(entries, longest_palette);
        const auto stride = std::size_t(harmonics(cloud.degree)),
                   width = std::size_t(palette.width);
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t label =
                labels.pixels[4 * i] + 256u * std::size_t(labels.pixels[4 * i + 1]);
            if (label >= entries) continue;  // no harmonics
            const std::size_t from =
                label / palette_row * width + label % palette_row * (stride - 1);
            for (std::size_t k = 1; k < stride; ++k) {
                const std::uint8_t* p = palette.pixels.data() + 4 * (from + k - 1);
                cloud.sh[i * stride + k] = {float(table[p[0]]), float(table[p[1]]),
                                            float(table[p[2]])};
            }
        }
    }

    double number(const char* key) const
    {
        const Json v = section("shN").value(key, Json());
        if (!v.is_number() || !std::isfinite(v.get<double>()))
            fail(std::string("/shN/") + key, "a finite number", described(v));
        return v.get<double>();
    }

    const SogSource source;
    Json meta;
    int version = 2;
    std::size_t count = 0;
    RgbaImage palette;  // of harmonics
};

std::size_t most_pixels_of(std::size_t bytes)
{
    return std::min(std::max(pixels_anyway, pixels_ratio * bytes), longest_side * longest_side);
}

}  // namespace

SplatFile parse_sog(const std::string& bytes, const std::string& path)
{
    const ZipReader zip(bytes, path);
    const std::size_t most = std::max(std::size_t(64) << 20, 100 * bytes.size());
    if (!zip.has("meta.json")) {
        if (zip.has("lod-meta.json"))
            throw InputError(path +
                             ": expected one cloud of splats, found streamed SOG (lod-meta.json); "
                             "export a single .sog");
        throw InputError(path + ": expected SOG, a ZIP with meta.json, found none");
    }
    const SogSource source{path,
                           [&](const std::string& name) {
                               return zip.read(name, name == "meta.json" ? max_json_bytes : most);
                           },
                           most_pixels_of(bytes.size())};
    return SogReader(source).read();
}

bool is_sog_folder(const std::string& path)
{
    std::error_code unknown;
    return fs::path(path).filename() == "meta.json" ||
           (fs::is_directory(path, unknown) && fs::exists(fs::path(path) / "meta.json", unknown));
}

SplatFile read_sog_folder(const std::string& path)
{
    std::error_code unknown;
    const fs::path folder =
        fs::is_directory(path, unknown) ? fs::path(path) : fs::path(path).parent_path();
    std::size_t bytes = 0;
    for (const auto& one : fs::directory_iterator(folder.empty() ? "." : folder, unknown))
        if (one.path().extension() == ".webp") {
            const std::uintmax_t size = one.file_size(unknown);
            if (!unknown) bytes += std::size_t(size);
        }
    const SogSource source{path,
                           [&](const std::string& name) {
                               return read_text((folder / name).string(), name == "meta.json"
                                                                              ? max_json_bytes
                                                                              : max_file_bytes);
                           },
                           most_pixels_of(bytes)};
    return SogReader(source).read();
}

}  // namespace knead
