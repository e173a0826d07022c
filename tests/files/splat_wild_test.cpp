// Splat files of other programs: the values that small files of each kind must give, transforms of
// coordinate systems and of glTF nodes, and files that are malformed.
#include <gtest/gtest.h>
#include <zstd.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/files/file_kind.h"
#include "host/files/glb.h"
#include "host/files/gzip.h"
#include "host/files/splat_axes.h"
#include "tests/files/splat_cases.h"
#include "tests/reason.h"

namespace knead {
namespace {

const std::string data = "tests/files/data/";

void expect_near(Vec3<float> found, Vec3<double> expected, double tolerance)
{
    EXPECT_NEAR(found.x, expected.x, tolerance);
    EXPECT_NEAR(found.y, expected.y, tolerance);
    EXPECT_NEAR(found.z, expected.z, tolerance);
}

// Largest difference between the covariances of two clouds [m^2].
double covariances_apart(const SplatCloud& a, const SplatCloud& b)
{
    double most = 0;
    for (std::size_t i = 0; i < a.count(); ++i) {
        const auto of = [&](const SplatCloud& c) {
            return covariance(
                Ellipsoid<double>{unit(cast<double>(c.rotation[i])), cast<double>(c.scale[i])});
        };
        const Sym3<double> p = of(a), q = of(b);
        for (const double d :
             {p.xx - q.xx, p.yy - q.yy, p.zz - q.zz, p.xy - q.xy, p.xz - q.xz, p.yz - q.yz})
            most = std::max(most, std::abs(d));
    }
    return most;
}

TEST(SplatsInTheWild, ACompressedPlyHasTheValuesOfItsSource)
{
    const SplatFile file = read_splats(data + "supersplat.compressed.ply");
    EXPECT_EQ(file_kind(data + "supersplat.compressed.ply"), FileKind::splats);
    EXPECT_EQ(file.format, "compressed ply");
    const SplatCloud& c = file.cloud;
    ASSERT_EQ(c.count(), 512u);
    expect_near(c.centre[0], {0.0313367, -0.000118, 0.499023}, 1e-6);
    expect_near(c.scale[0], {0.046999, 0.046999, 0.046999}, 1e-6);
    EXPECT_NEAR(c.opacity[0], 242 / 255.0, 1e-6);
    EXPECT_NEAR(std::abs(c.sh[0].x), 1.417963, 1e-5);
    EXPECT_NEAR(c.rotation[0].w, 0.9999993, 1e-6);
    EXPECT_NEAR(c.rotation[0].x, 6.9e-4, 1e-5);
    Vec3<float> low = c.centre[0], high = low;
    for (const Vec3<float>& x : c.centre)
        low = {std::min(low.x, x.x), std::min(low.y, x.y), std::min(low.z, x.z)},
        high = {std::max(high.x, x.x), std::max(high.y, x.y), std::max(high.z, x.z)};
    expect_near(low, {-0.49917, -0.49929, -0.499023}, 1e-5);
    expect_near(high, {0.49803, 0.49966, 0.499023}, 1e-5);
}

TEST(SplatsInTheWild, EachVersionOfSpzHasItsValues)
{
    for (const char* name :
         {"spz_v1.spz", "spz_v3.spz", "spz_v3coord.spz", "spz_v3coord_rub.spz", "spz_v3safe.spz"}) {
        const SplatCloud c = read_splats(data + name).cloud;
        ASSERT_EQ(c.count(), 500u) << name;
        // Stored right, down, front: not turned.
        const double turned = std::string(name) == "spz_v3coord.spz" ? -1 : 1;
        expect_near(c.centre[0],
                    {std::string(name) == "spz_v1.spz" ? 0.031616 : 0.031494, 0, turned * 0.499023},
                    1e-6);
        EXPECT_NEAR(c.opacity[0], 242 / 255.0, 1e-6);
        EXPECT_NEAR(c.sh[0].x, -1.42484, 1e-5);
        EXPECT_NEAR(c.sh[0].z, 1.42484, 1e-5);
        EXPECT_NEAR(c.scale[0].x, 0.046771, 1e-6);
    }
}

// The 16 systems of the coordinate record: a point, a direction of colour, an ellipsoid.
TEST(SplatsInTheWild, EveryCoordinateSystemOfSpzIsConverted)
{
    const SplatCloud cloud = drawn(20, 3, 21);
    for (unsigned system = 1; system <= 16; ++system) {
        const std::string letters = spz_axes(system);
        const SplatAxes axes(letters.c_str());
        // Columns: where +x, +y and +z of the file point among right, down, front.
        const auto along = [](char c) {
            const double sign = c == 'R' || c == 'D' || c == 'F' ? 1 : -1;
            return Vec3<double>{c == 'R' || c == 'L' ? sign : 0, c == 'D' || c == 'U' ? sign : 0,
                                c == 'F' || c == 'B' ? sign : 0};
        };
        const Mat3<double> m{along(letters[0]), along(letters[1]), along(letters[2])};
        const Vec3<double> v{0.48, 0.6, -0.64}, placed = axes.place(v), expected = m * v;
        EXPECT_EQ(length(placed - expected), 0) << letters;
        for (std::size_t i = 0; i < cloud.count(); ++i) {
            const Ellipsoid<double> e{unit(cast<double>(cloud.rotation[i])),
                                      cast<double>(cloud.scale[i])};
            const Mat3<double> Q = rotation(e.q),
                               L = m *
                                   Mat3<double>{e.scale.x * Q.a, e.scale.y * Q.b, e.scale.z * Q.c};
            const Sym3<double> right = symmetric(L * transpose(L)),
                               found = covariance(
                                   Ellipsoid<double>{axes.turn(e.q), axes.half_axes(e.scale)});
            EXPECT_NEAR(found.xy, right.xy, 1e-12) << letters;
            EXPECT_NEAR(found.yy, right.yy, 1e-12) << letters;
            EXPECT_NEAR(found.yz, right.yz, 1e-12) << letters;
            const auto own = [&](int k) { return cast<double>(cloud.sh[16 * i + std::size_t(k)]); };
            const Vec3<double> was = sh_colour(3, v, own), is = sh_colour(3, m * v, [&](int k) {
                                                               return axes.coefficient(k, own);
                                                           });
            EXPECT_NEAR(was.x, is.x, 1e-9) << letters;
            EXPECT_NEAR(was.z, is.z, 1e-9) << letters;
        }
    }
}

TEST(SplatsInTheWild, TheCoordinateRecordIsObeyed)
{
    const auto read = [](std::uint32_t system) {
        SpzByHand by_hand{.flags = 2};
        by_hand.behind = bytes_of(std::vector<std::uint32_t>{0xadbe0003u, 4, system});
        return parse_spz(gzipped(by_hand.bytes()), "c.spz").cloud.centre[0];
    };
    // Stored (1, 2, -3).
    for (const std::uint32_t system : {0u, 4u}) expect_near(read(system), {1, -2, 3}, 0);
    expect_near(read(6), {1, 2, -3}, 0);
    expect_near(read(7), {-1, -2, -3}, 0);   // left, up, front
    expect_near(read(12), {1, 3, 2}, 0);     // right, front, up
    expect_near(read(13), {-1, -3, -2}, 0);  // left, back, down
    for (const std::uint32_t system : {17u, 0xffffffffu}) EXPECT_THROW(read(system), InputError);
}

// A file of version 4 by the description of the format, degree 1, two splats.
std::string spz_4_by_hand(const std::string& extensions = "", int streams = 6,
                          std::size_t longer = 0)
{
    const std::string arrays = SpzByHand().bytes().substr(16);
    const std::size_t sizes[] = {18, 2, 6, 6, 8, 18};
    std::string table, frames;
    std::size_t at = 0;
    for (int k = 0; k < streams; ++k) {
        std::string frame(ZSTD_compressBound(sizes[k]), '\0');
        frame.resize(ZSTD_compress(frame.data(), frame.size(), arrays.data() + at, sizes[k], 3));
        table += bytes_of(std::vector<std::uint64_t>{frame.size(), sizes[k] + longer});
        frames += frame, at += sizes[k];
    }
    const std::uint8_t flags = extensions.empty() ? 0 : 2;
    return "NGSP" + bytes_of(std::vector<std::uint32_t>{4, 2}) +
           bytes_of(std::vector<std::uint8_t>{1, 12, flags, std::uint8_t(streams)}) +
           bytes_of(std::vector<std::uint32_t>{std::uint32_t(32 + extensions.size()), 0, 0, 0}) +
           extensions + table + frames;
}

TEST(SplatsInTheWild, SpzOfVersionFourIsReadStreamByStream)
{
    const SplatCloud as_3 = parse_spz(SpzByHand().bytes(), "3.spz").cloud;
    const std::string bytes = spz_4_by_hand();
    const SplatFile file = parse_spz(bytes, "4.spz");
    const Apart most = apart(as_3, file.cloud);
    EXPECT_EQ(most.centre + most.scale + most.opacity + most.dc + most.rest, 0);
    ASSERT_EQ(file.notes.size(), 1u);
    EXPECT_NE(file.notes[0].find("set `up`"), std::string::npos);
    const std::string front = bytes_of(std::vector<std::uint32_t>{7, 2}) + "ab" +
                              bytes_of(std::vector<std::uint32_t>{0xadbe0003u, 4, 6});
    const SplatFile turned = parse_spz(spz_4_by_hand(front), "4.spz");
    expect_near(turned.cloud.centre[0], {1, 2, -3}, 0);
    EXPECT_TRUE(turned.notes.empty());
    const auto said = [](const std::string& all) {
        return reason<InputError>([&] { parse_spz(all, "4.spz"); });
    };
    EXPECT_NE(said(spz_4_by_hand("", 4)).find("6 streams"), std::string::npos);
    EXPECT_NE(said(spz_4_by_hand("", 6, 1)).find("stream 1 of 18 bytes"), std::string::npos);
    EXPECT_NE(said(bytes + "x").find("more"), std::string::npos);
    EXPECT_NE(said(gzipped(bytes)).find("in the open"), std::string::npos);
    for (std::size_t size = 0; size < bytes.size(); ++size)
        EXPECT_THROW(parse_spz(bytes.substr(0, size), "4.spz"), InputError) << size;
    std::string damaged = bytes;
    damaged[32 + 6 * 16] = 0;  // the mark of the first frame
    EXPECT_NE(said(damaged).find("stream 1 to unpack"), std::string::npos);
}

TEST(SplatsInTheWild, OurOwnGlbComesBack)
{
    EXPECT_EQ(file_kind(data + "khr_own.glb"), FileKind::splats);
    const SplatFile file = read_splats(data + "khr_own.glb");
    const SplatCloud source = read_splats(data + "khr_source.ply").cloud;
    EXPECT_EQ(file.format, "glb");
    EXPECT_TRUE(file.notes.empty());
    ASSERT_EQ(file.cloud.count(), 300u);
    EXPECT_EQ(file.cloud.degree, 1);
    const Apart most = apart(source, file.cloud);
    EXPECT_LE(most.centre, 1e-7);
    EXPECT_LE(most.opacity, 1e-6);
    EXPECT_LE(most.dc, 1e-6);
    EXPECT_LE(most.rest, 1e-6);
    EXPECT_LE(covariances_apart(source, file.cloud), 1e-8);
    const SplatFile other = read_splats(data + "khr_other.glb");
    EXPECT_EQ(other.cloud.count(), 300u);
    EXPECT_EQ(other.cloud.degree, 0);
    EXPECT_NE(reason<InputError>([] {
                  read_splats(data + "khr_spz2.glb");
              }).find("KHR_gaussian_splatting_compression_spz_2"),
              std::string::npos);
    for (int degree : {0, 2, 3}) {
        const SplatCloud cloud = drawn(40, degree, 5);
        const SplatCloud back = parse_splat_glb(splat_glb_bytes(cloud, "w.glb"), "w.glb").cloud;
        EXPECT_EQ(back.degree, degree);
        EXPECT_LE(apart(cloud, back).rest, 2e-6);
        // Half axes reach to e: squares to 7.4, of floats that were rounded a few times.
        EXPECT_LE(covariances_apart(cloud, back), 32 * 7.4 * 0x1p-23);
    }
}

using Json = nlohmann::json;

// Our own file of a few splats with its document changed.
std::string changed_glb(const std::function<void(Json&)>& change, int degree = 1,
                        std::size_t count = 5)
{
    const std::string bytes = splat_glb_bytes(drawn(count, degree, 8), "c.glb");
    std::uint32_t size;
    std::memcpy(&size, bytes.data() + 12, 4);
    Json document = Json::parse(bytes.substr(20, size));
    change(document);
    std::string text = document.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string out = bytes.substr(0, 8);
    out += bytes_of(std::vector<std::uint32_t>{std::uint32_t(bytes.size() - size + text.size()),
                                               std::uint32_t(text.size()), glb_json});
    return out + text + bytes.substr(20 + size);
}

TEST(SplatsInTheWild, NodesOfTheDefaultScenePlaceTheirSplats)
{
    const SplatCloud plain_one = parse_splat_glb(changed_glb([](Json&) {}), "n.glb").cloud;
    const auto read = [](const std::function<void(Json&)>& change) {
        return parse_splat_glb(changed_glb(change), "n.glb");
    };
    // Up by 2 in glTF is -2 along the cloud's y; two parents; a mirrored twin; one out of the
    // scene.
    const SplatFile file = read([](Json& d) {
        d["nodes"] = Json::parse(R"([{"children": [1], "translation": [0, 2, 0]},
            {"mesh": 0, "scale": [2, 2, 2]}, {"mesh": 0, "scale": [-1, 1, 1]}, {"mesh": 0}])");
        d["scenes"] = Json::parse(R"([{"nodes": [3]}, {"nodes": [0, 2]}])");
        d["scene"] = 1;
    });
    ASSERT_EQ(file.cloud.count(), 10u);
    for (std::size_t i = 0; i < 5; ++i) {
        const Vec3<double> x = cast<double>(plain_one.centre[i]);
        expect_near(file.cloud.centre[i], {2 * x.x, 2 * x.y - 2, 2 * x.z}, 1e-5);
        expect_near(file.cloud.centre[5 + i], {-x.x, x.y, x.z}, 1e-6);
        EXPECT_NEAR(
            std::max({file.cloud.scale[i].x, file.cloud.scale[i].y, file.cloud.scale[i].z}),
            2 * std::max({plain_one.scale[i].x, plain_one.scale[i].y, plain_one.scale[i].z}), 1e-5);
        // The mirrored colour: y, z, x of degree 1, of which x is negated.
        const Vec3<float> was = plain_one.sh[4 * i + 3], is = file.cloud.sh[4 * (5 + i) + 3];
        EXPECT_NEAR(is.x, -was.x, 1e-6);
        EXPECT_NEAR(file.cloud.sh[4 * (5 + i) + 1].x, plain_one.sh[4 * i + 1].x, 1e-6);
    }
    // Without scenes: all roots.
    EXPECT_EQ(read([](Json& d) { d.erase("scenes"), d.erase("scene"); }).cloud.count(), 5u);
    // Stretched along one axis: the covariance follows.
    const SplatFile stretched = read([](Json& d) { d["nodes"][0]["scale"] = {1, 3, 1}; });
    for (std::size_t i = 0; i < 5; ++i) {
        const auto of = [&](const SplatCloud& c) {
            return covariance(
                Ellipsoid<double>{unit(cast<double>(c.rotation[i])), cast<double>(c.scale[i])});
        };
        const Sym3<double> a = of(plain_one), b = of(stretched.cloud);
        EXPECT_NEAR(b.yy, 9 * a.yy, 1e-4);
        EXPECT_NEAR(b.xy, 3 * a.xy, 1e-4);
        EXPECT_NEAR(b.xz, a.xz, 1e-4);
    }
}

TEST(SplatsInTheWild, ADialectOfGlbWithLogarithmsIsUnderstoodAndSaid)
{
    std::string bytes = changed_glb([](Json& d) { d["asset"]["generator"] = "splatter 2.3"; }, 0);
    const SplatCloud linear = parse_splat_glb(bytes, "l.glb").cloud;
    std::uint32_t size;
    std::memcpy(&size, bytes.data() + 12, 4);
    const Json d = Json::parse(bytes.substr(20, size));
    const std::size_t accessor =
        d["meshes"][0]["primitives"][0]["attributes"]["KHR_gaussian_splatting:SCALE"];
    const std::size_t view = d["accessors"][accessor]["bufferView"],
                      from = 28 + size + d["bufferViews"][view]["byteOffset"].get<std::size_t>();
    for (std::size_t k = 0; k < 15; ++k) {
        float s;
        std::memcpy(&s, bytes.data() + from + 4 * k, 4);
        s = std::log(s);
        std::memcpy(bytes.data() + from + 4 * k, &s, 4);
    }
    const SplatFile file = parse_splat_glb(bytes, "l.glb");
    EXPECT_LE(apart(linear, file.cloud).scale, 1e-5);
    ASSERT_EQ(file.notes.size(), 1u);
    EXPECT_NE(file.notes[0].find("logarithms"), std::string::npos);
    EXPECT_NE(file.notes[0].find("splatter 2.3"), std::string::npos);
}

TEST(SplatsInTheWild, AMalformedGlbIsRefusedWithItsPlace)
{
    const auto said = [](const std::function<void(Json&)>& change) {
        const std::string bytes = changed_glb(change);
        return reason<InputError>([&] { parse_splat_glb(bytes, "m.glb"); });
    };
    const auto tells = [&](const std::function<void(Json&)>& change, const std::string& what) {
        const std::string text = said(change);
        EXPECT_NE(text.find(what), std::string::npos) << text;
    };
    const auto primitive = [](Json& d) -> Json& { return d["meshes"][0]["primitives"][0]; };
    const std::string splatting = "KHR_gaussian_splatting";
    tells([](Json& d) { d["extensionsRequired"] = {"EXT_other"}; }, "EXT_other");
    tells([&](Json& d) { primitive(d)["extensions"][splatting]["kernel"] = "cube"; }, "cube");
    tells([&](Json& d) { primitive(d)["mode"] = 4; }, "points (0)");
    tells([&](Json& d) { primitive(d)["attributes"].erase("POSITION"); }, "POSITION");
    tells([&](Json& d) { primitive(d)["attributes"].erase(splatting + ":SH_DEGREE_1_COEF_2"); },
          "SH_DEGREE_1_COEF_2");
    tells([](Json& d) { d["accessors"][0]["count"] = 4; }, "4 elements each");
    tells([](Json& d) { d["accessors"][0]["count"] = 4000000000u; }, "bytes of its view");
    tells([](Json& d) { d["accessors"][0]["sparse"] = Json::object(); }, "sparse");
    tells([](Json& d) { d["accessors"][0].erase("bufferView"); }, "without a view");
    tells([](Json& d) { d["accessors"][0]["bufferView"] = 99; }, "one of");
    tells([](Json& d) { d["bufferViews"][0]["byteLength"] = 4000000000u; }, "of the buffer");
    tells([](Json& d) { d["bufferViews"][0]["byteStride"] = 4; }, "at least 12");
    tells([](Json& d) { d["nodes"][0]["children"] = {0}; }, "cycle");
    tells([](Json& d) { d["nodes"][0]["scale"] = {0, 1, 1}; }, "determinant");
    tells([](Json& d) { d["nodes"][0]["matrix"] = {1, 2}; }, "16 numbers");
    tells([](Json& d) { d["nodes"][0].erase("mesh"); }, "none");
    tells([](Json& d) { d["scene"] = 7; }, "one of 1 scenes");
    // A node of 16 bytes is 60 splats more.
    const std::string many = changed_glb(
        [](Json& d) {
            d["nodes"] = Json::array();
            d["scenes"][0]["nodes"] = Json::array();
            for (int k = 0; k < 4000; ++k)
                d["nodes"].push_back({{"mesh", 0}}), d["scenes"][0]["nodes"].push_back(k);
        },
        1, 60);
    EXPECT_NE(reason<InputError>([&] { parse_splat_glb(many, "m.glb"); }).find("times the file's"),
              std::string::npos);
    tells(
        [&](Json& d) {
            primitive(d)["extensions"][splatting]["extensions"]["EXT_packed"] = Json::object();
        },
        "EXT_packed");
    EXPECT_EQ(parse_splat_glb(changed_glb([&](Json& d) {
                                  primitive(d)["extensions"][splatting]["colorSpace"] =
                                      "lin_rec709_display";
                              }),
                              "l.glb")
                  .notes.size(),
              1u);
}

TEST(SplatsInTheWild, AKsplatByHandIsRead)
{
    const std::string bytes = ksplat_of_level(1);
    const SplatFile file = parse_splats(bytes, "a.ksplat");
    EXPECT_EQ(file.format, "ksplat");
    const SplatCloud& c = file.cloud;
    ASSERT_EQ(c.count(), 3u);
    EXPECT_EQ(c.degree, 1);
    expect_near(c.centre[0], {10, 22.5, 27.5}, 1e-5);
    expect_near(c.centre[1], {-1, 0.5, -5.5}, 1e-5);
    expect_near(c.centre[2], {-1, 0.5, -5.5}, 1e-5);
    expect_near(c.scale[0], {1, 2, 0.5}, 0);
    EXPECT_EQ(c.rotation[0].x, 1);
    EXPECT_NEAR(c.opacity[0], 0.8, 1e-6);
    EXPECT_NEAR(c.sh[0].x, 0.5 / sh_constant, 1e-6);
    expect_near(c.sh[1], {1, 0, -1}, 0);
    expect_near(c.sh[2], {2, 0, -1}, 0);
    expect_near(c.sh[3], {0.5, 0, -1}, 0);
    const SplatCloud zero = parse_ksplat(ksplat_of_level(0), "0.ksplat").cloud,
                     two = parse_ksplat(ksplat_of_level(2), "2.ksplat").cloud;
    expect_near(zero.centre[2], {2, 2, 3}, 0);
    expect_near(zero.sh[2], {2, 0, -1}, 0);
    expect_near(two.centre[1], {-1, 0.5, -5.5}, 1e-5);
    expect_near(two.sh[3], {0.5, 0, -1}, 0.01);
    for (std::size_t size = 0; size < bytes.size(); size += size < 4090 ? 97 : 1)
        EXPECT_THROW(parse_ksplat(bytes.substr(0, size), "k.ksplat"), InputError) << size;
    EXPECT_THROW(parse_ksplat(bytes + "x", "k.ksplat"), InputError);
    // A bucket too few, and counts beyond the file.
    for (const std::size_t at : {4096 + 4, 4096 + 12, 4096 + 32, 4096 + 36, 4, 20}) {
        std::string wrong = bytes;
        wrong[at + 1] = '\x7f';
        EXPECT_THROW(parse_ksplat(wrong, "k.ksplat"), InputError) << at;
    }
    std::string few = bytes;
    few[4096 + 1024] = 1;
    EXPECT_NE(reason<InputError>([&] { parse_ksplat(few, "k.ksplat"); }).find("buckets of 3"),
              std::string::npos);
}

TEST(SplatsInTheWild, FormatsThatAreNotReadAreNamed)
{
    const auto said = [](const std::string& bytes, const std::string& path) {
        return reason<InputError>([&] { parse_splats(bytes, path); });
    };
    EXPECT_NE(said(std::string("\x4b\x67\0\0", 4), "model").find(".splatv"), std::string::npos);
    EXPECT_NE(said("", "a.splatv").find("move"), std::string::npos);
    EXPECT_NE(said("", "scan.lcc").find("XGRIDS"), std::string::npos);
}

// The older kind: without bounds of colours, which are stored as they are; an element "sh" of no
// properties, as another writer has it.
TEST(SplatsInTheWild, ACompressedPlyOfTwelveColumnsIsRead)
{
    Names bounds;
    for (const char* of : {"min_", "max_", "min_scale_", "max_scale_"})
        for (const char* axis : {"x", "y", "z"}) bounds.push_back(of + std::string(axis));
    const std::string bytes =
        "ply\nformat binary_little_endian 1.0\nelement chunk 1\n" + properties(bounds) +
        "element vertex 1\n" +
        properties({"packed_position", "packed_rotation", "packed_scale", "packed_color"}, "uint") +
        "element sh 1\nend_header\n" +
        bytes_of(std::vector<float>{-1, -2, -3, 1, 2, 3, -4, -4, -4, 0, -4, -2}) +
        // The upper end, the lower end and the middle; z is the largest; a half and both ends.
        bytes_of(std::vector<std::uint32_t>{2047u << 21 | 1024, 3u << 30 | 512u << 20 | 512u << 10,
                                            2047u << 21 | 2047, 0xff003380u});
    const SplatFile file = parse_splats(bytes, "old.ply");
    ASSERT_EQ(file.cloud.count(), 1u);
    EXPECT_EQ(file.cloud.degree, 0);
    expect_near(file.cloud.centre[0], {1, -2, 3 * (2048.0 / 2047 - 1)}, 1e-6);
    expect_near(file.cloud.scale[0], {1, std::exp(-4), std::exp(-2)}, 1e-6);
    EXPECT_NEAR(file.cloud.opacity[0], 128 / 255.0, 1e-6);
    expect_near(file.cloud.sh[0], {0.5 / sh_constant, -0.5 / sh_constant, -0.3 / sh_constant},
                1e-6);
    const double half_step = std::sqrt(2.0) * (512 / 1023.0 - 0.5), y = -std::sqrt(0.5);
    EXPECT_NEAR(file.cloud.rotation[0].w, half_step, 1e-6);
    EXPECT_NEAR(file.cloud.rotation[0].x, half_step, 1e-6);
    EXPECT_NEAR(file.cloud.rotation[0].y, y, 1e-6);
    EXPECT_NEAR(file.cloud.rotation[0].z, std::sqrt(0.5 - 2 * half_step * half_step), 1e-6);
}

// A header of compressed PLY, with a chunk and a vertex element.
TEST(SplatsInTheWild, ACompressedPlyThatIsMalformedSaysWhere)
{
    const std::string whole = compressed_ply_bytes(drawn(300, 1, 4), "w.ply");
    const auto said = [&](const std::string& from, const std::string& to) {
        std::string bytes = whole;
        bytes.replace(bytes.find(from), from.size(), to);
        return reason<InputError>([&] { parse_splats(bytes, "c.ply"); });
    };
    const auto tells = [&](const std::string& from, const std::string& to,
                           const std::string& what) {
        EXPECT_NE(said(from, to).find(what), std::string::npos) << said(from, to);
    };
    tells("element chunk 2", "element chunk 1", "bytes more");
    tells("element vertex 300", "element vertex 301", "bytes left");
    tells("element vertex 300", "element vertex 4000000000", "bytes left");
    tells("min_scale_y", "min_scale_q", "min_scale_y");
    tells("uint packed_color", "int packed_color", "uint");
    tells("f_rest_8", "f_rest_x", "\"f_rest_8\"");
    tells("property uchar f_rest_8\n", "", "0, 9, 24 or 45");
    // A chunk too few, and a splat without harmonics.
    std::string few = whole;
    few.replace(few.find("element chunk 2"), 15, "element chunk 1");
    few.erase(few.find("end_header\n") + 11, 72);
    EXPECT_NE(reason<InputError>([&] { parse_splats(few, "c.ply"); }).find("a chunk for each"),
              std::string::npos);
    std::string bare = whole.substr(0, whole.size() - 9);
    bare.replace(bare.find("element sh 300"), 14, "element sh 299");
    EXPECT_NE(reason<InputError>([&] { parse_splats(bare, "c.ply"); }).find("harmonics of 300"),
              std::string::npos);
    tells("binary_little_endian", "ascii", "little_endian");
    EXPECT_THROW(parse_splats(whole.substr(0, whole.size() - 1), "c.ply"), InputError);
    EXPECT_THROW(compressed_ply_bytes({}, "c.ply"), InputError);
}

}  // namespace
}  // namespace knead
