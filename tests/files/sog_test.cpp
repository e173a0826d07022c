// SOG: what is written is read, both versions by hand, folders, archives of other programs, and
// what is malformed or unpacks beyond reason.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/outputs.h"
#include "host/files/file_kind.h"
#include "host/files/webp.h"
#include "host/files/zip.h"
#include "tests/files/splat_cases.h"
#include "tests/folder.h"
#include "tests/reason.h"

namespace knead {
namespace {

using Json = nlohmann::json;
using Entries = std::vector<std::pair<std::string, std::string>>;

// Of a raw deflate stream.
std::string deflated(const std::string& content)
{
    z_stream z{};
    deflateInit2(&z, 9, Z_DEFLATED, -MAX_WBITS, 9, Z_DEFAULT_STRATEGY);
    std::string out(deflateBound(&z, content.size()), '\0');
    z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(content.data()));
    z.avail_in = uInt(content.size());
    z.next_out = reinterpret_cast<Bytef*>(out.data());
    z.avail_out = uInt(out.size());
    deflate(&z, Z_FINISH);
    deflateEnd(&z);
    return out.substr(0, z.total_out);
}

// As other writers have it: deflated, or with the sizes behind the content instead of before it.
std::string foreign_zip(const Entries& entries, bool packed)
{
    std::string out, directory;
    const auto put = [](std::string& to, auto value) {
        to.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    for (const auto& [name, content] : entries) {
        const std::string stored = packed ? deflated(content) : content;
        const auto crc = std::uint32_t(
            crc32(0, reinterpret_cast<const Bytef*>(content.data()), uInt(content.size())));
        const auto header = std::uint32_t(out.size());
        const auto common = [&](std::string& to, bool sizes) {
            put(to, std::uint16_t(20)), put(to, std::uint16_t(0x808));
            put(to, std::uint16_t(packed ? 8 : 0)), put(to, std::uint32_t(0));
            put(to, sizes ? crc : 0u);
            put(to, sizes ? std::uint32_t(stored.size()) : 0u);
            put(to, sizes ? std::uint32_t(content.size()) : 0u);
            put(to, std::uint16_t(name.size())), put(to, std::uint16_t(0));
        };
        put(out, 0x04034b50u), common(out, false);
        out += name + stored;
        put(out, 0x08074b50u), put(out, crc), put(out, std::uint32_t(stored.size()));
        put(out, std::uint32_t(content.size()));
        put(directory, 0x02014b50u), put(directory, std::uint16_t(20)), common(directory, true);
        directory += std::string(10, '\0');
        put(directory, header);
        directory += name;
    }
    const auto at = std::uint32_t(out.size());
    out += directory;
    put(out, 0x06054b50u), put(out, std::uint32_t(0));
    put(out, std::uint16_t(entries.size())), put(out, std::uint16_t(entries.size()));
    put(out, std::uint32_t(directory.size())), put(out, at), put(out, std::uint16_t(3));
    return out + "bye";
}

Entries entries_of(const std::string& zip)
{
    Entries all;
    const std::string path = "e.zip";
    const ZipReader reader(zip, path);
    for (const std::string& name : reader.names())
        all.emplace_back(name, reader.read(name, 1 << 24));
    return all;
}

class Sog : public testing::Test {
  protected:
    void SetUp() override
    {
        if (!webp_available()) GTEST_SKIP() << "built without libwebp";
    }
    // Small but for one far splat, along the writer's curve already.
    static SplatCloud sorted(std::size_t count, int degree, std::uint64_t seed)
    {
        const SplatCloud cloud = drawn(count, degree, seed);
        return parse_sog(sog_bytes(cloud, "s.sog"), "s.sog").cloud;
    }
    // The cloud of our own file with its entries changed.
    static SplatFile changed(const std::function<void(Json&, Entries&)>& change, int degree = 1)
    {
        Entries all = entries_of(sog_bytes(drawn(40, degree, 3), "c.sog"));
        Json meta = Json::parse(all[0].second);
        change(meta, all);
        all[0].second = meta.dump();
        return parse_sog(zip_bytes(all, "c.sog"), "c.sog");
    }
};

// What is read and written again has the same order, so it can be compared splat by splat.
TEST_F(Sog, WhatIsWrittenIsReadWithinItsSteps)
{
    for (int degree = 0; degree <= 3; ++degree) {
        SplatCloud cloud = sorted(500, degree, 4);
        cloud.antialiased = degree % 2;
        const std::string bytes = sog_bytes(cloud, "w.sog");
        EXPECT_EQ(bytes, sog_bytes(cloud, "w.sog"));
        const SplatFile file = parse_sog(bytes, "w.sog");
        EXPECT_EQ(file.format, "sog");
        EXPECT_EQ(file.cloud.degree, degree);
        EXPECT_EQ(file.cloud.antialiased, cloud.antialiased);
        const Apart most = apart(cloud, file.cloud);
        // 16 bits of ln(1 + 2), from -2 to 2, whose slope is 3 at most.
        EXPECT_LE(most.centre, 3 * std::log(3.0) / 65535 + 1e-6);
        EXPECT_LE(most.opacity, 0.5 / 255 + 1e-6);
        // Steps of sqrt(1/2) / 127.5 in three parts: half the square of the difference at most.
        EXPECT_LE(most.rotation, 1e-4);
        // What was quantised once has at most 256 values, which a codebook holds exactly.
        EXPECT_LE(most.scale, 1e-6);
        EXPECT_EQ(most.dc, 0);
        EXPECT_EQ(most.rest, 0);
    }
}

// Of 1500 values from -1 to 1 and of 500 half axes over five decades, in 256 codes.
TEST_F(Sog, ACodebookIsCloseToItsValues)
{
    const SplatCloud cloud = drawn(500, 1, 6);
    SplatCloud back = parse_sog(sog_bytes(cloud, "b.sog"), "b.sog").cloud;
    double worst_dc = 0, worst_scale = 0;
    for (std::size_t i = 0; i < cloud.count(); ++i) {
        std::size_t nearest = 0;
        for (std::size_t k = 0; k < back.count(); ++k)
            if (length(back.centre[k] - cloud.centre[i]) <
                length(back.centre[nearest] - cloud.centre[i]))
                nearest = k;
        worst_dc = std::max(worst_dc, std::abs(double(cloud.sh[4 * i].x) - back.sh[4 * nearest].x));
        worst_scale = std::max(worst_scale, std::abs(std::log(double(cloud.scale[i].y)) -
                                                     std::log(double(back.scale[nearest].y))));
    }
    EXPECT_LE(worst_dc, 1 / 128.0);     // even steps would be 1/128, half of it the error
    EXPECT_LE(worst_scale, 5 / 128.0);  // of ln 10^5 in even steps 0.045
}

TEST_F(Sog, HarmonicsOfManySplatsShareAPalette)
{
    constexpr std::size_t count = 70000;
    SplatCloud cloud = drawn(count, 1, 9);
    // Eight kinds of splats: the palette has room for each.
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t k = 1; k < 4; ++k)
            cloud.sh[4 * i + k] = {float(i % 8) / 8, float(k) / 4, -float(i % 8 / 4)};
    const std::string bytes = sog_bytes(cloud, "m.sog");
    const Json meta = Json::parse(entries_of(bytes)[0].second);
    EXPECT_EQ(meta["shN"]["count"], 8);
    const SplatCloud back = parse_sog(bytes, "m.sog").cloud;
    ASSERT_EQ(back.count(), count);
    for (std::size_t i = 0; i < count; i += 97) {
        const Vec3<float> c = back.sh[4 * i + 1];
        const double kind = 8 * double(c.x);
        EXPECT_NEAR(kind, std::round(kind), 1e-5);
        EXPECT_NEAR(c.z, -std::floor(std::round(kind) / 4), 1e-6);
        EXPECT_NEAR(back.sh[4 * i + 3].y, 0.75, 1e-6);
    }
}

TEST_F(Sog, ArchivesOfOtherWritersAndFoldersAreRead)
{
    const std::string own = sog_bytes(drawn(40, 2, 3), "o.sog");
    const SplatCloud cloud = parse_sog(own, "o.sog").cloud;
    const Entries all = entries_of(own);
    for (const bool packed : {false, true}) {
        const Apart most = apart(cloud, parse_sog(foreign_zip(all, packed), "f.sog").cloud);
        EXPECT_EQ(most.centre + most.scale + most.rest + most.dc, 0) << packed;
    }
    const Folder folder;
    for (const auto& [name, content] : all) write_whole(folder / name, content);
    for (const std::string& path : {folder.path().string(), folder / "meta.json"}) {
        EXPECT_EQ(file_kind(path), FileKind::splats);
        EXPECT_EQ(apart(cloud, read_splats(path).cloud).centre, 0);
    }
    std::filesystem::remove(folder / "quats.webp");
    EXPECT_THROW(read_splats(folder.path().string()), InputError);
    const Folder other;
    write_splats(other / "a.sog", cloud);
    EXPECT_EQ(file_kind(other / "a.sog"), FileKind::splats);
    EXPECT_EQ(read_splats(other / "a.sog").cloud.count(), 40u);
}

// Ranges instead of codebooks, an opacity as a logit.
TEST_F(Sog, VersionOneIsRead)
{
    const SplatFile file = changed([](Json& meta, Entries&) {
        meta.erase("version"), meta.erase("count");
        meta["means"]["shape"] = {40, 3};
        meta["scales"] = {{"mins", {-1, -2, -3}}, {"maxs", {0, 0, 0}}, {"files", {"scales.webp"}}};
        meta["sh0"] = {{"mins", {0, 0, 0, -4}}, {"maxs", {1, 2, 3, 4}}, {"files", {"sh0.webp"}}};
        meta["shN"] = {
            {"mins", -1}, {"maxs", 1}, {"files", {"shN_centroids.webp", "shN_labels.webp"}}};
    });
    const SplatFile two = changed([](Json& meta, Entries&) {
        Json ramp = Json::array();
        for (int b = 0; b < 256; ++b) ramp.push_back(b / 255.0);
        for (const char* of : {"scales", "sh0", "shN"}) meta[of]["codebook"] = ramp;
    });
    ASSERT_EQ(file.cloud.count(), 40u);
    for (std::size_t i = 0; i < 40; ++i) {
        const Vec3<float> t = two.cloud.scale[i], s = file.cloud.scale[i];
        EXPECT_NEAR(std::log(s.x), std::log(t.x) - 1, 1e-5);
        EXPECT_NEAR(std::log(s.z), 3 * std::log(t.z) - 3, 1e-5);
        EXPECT_NEAR(file.cloud.sh[4 * i].y, 2 * two.cloud.sh[4 * i].y, 1e-6);
        EXPECT_NEAR(file.cloud.sh[4 * i + 2].x, 2 * two.cloud.sh[4 * i + 2].x - 1, 1e-6);
        EXPECT_NEAR(file.cloud.opacity[i], 1 / (1 + std::exp(4 - 8 * two.cloud.opacity[i])), 1e-6);
    }
}

TEST_F(Sog, WhatIsMalformedIsRefusedWithItsPlace)
{
    const auto tells = [](const std::function<void(Json&, Entries&)>& change,
                          const std::string& what) {
        const std::string text = reason<InputError>([&] { changed(change); });
        EXPECT_NE(text.find(what), std::string::npos) << text;
    };
    tells([](Json& m, Entries&) { m["version"] = 3; }, "/version");
    tells([](Json& m, Entries&) { m["count"] = 5000; }, "pixels of 5000 splats");
    tells([](Json& m, Entries&) { m["count"] = -1; }, "/count");
    tells([](Json& m, Entries&) { m["count"] = 0; }, "none");
    tells([](Json& m, Entries&) { m["means"]["mins"] = {1, 2}; }, "/means/mins");
    tells([](Json& m, Entries&) { m["scales"]["codebook"].erase(7); }, "256 numbers");
    tells([](Json& m, Entries&) { m["sh0"]["codebook"][7] = "x"; }, "finite numbers");
    tells([](Json& m, Entries&) { m.erase("quats"); }, "/quats");
    for (const char* name : {"../a.webp", "a/b.webp", "..", "", "a\\b"})
        tells([&](Json& m, Entries&) { m["quats"]["files"][0] = name; }, "beside meta.json");
    tells([](Json& m, Entries&) { m["quats"]["files"][0] = "none.webp"; }, "an entry of this name");
    tells([](Json& m, Entries&) { m["shN"]["bands"] = 2; }, "/shN/bands");
    tells(
        [](Json& m, Entries&) {
            m["shN"]["files"] = {"sh0.webp", "shN_labels.webp"};
        },
        "192, 512 or 960");
    tells([](Json&, Entries& all) { all[1].second.resize(40); }, "WebP image");
    tells([](Json&, Entries& all) { all[1].second = "RIFF"; }, "WebP image");
    tells([](Json&, Entries& all) { all[0].first = "lod-meta.json"; }, "streamed SOG");
    // 16000 x 16000 pixels of one colour are a few hundred bytes.
    tells(
        [](Json&, Entries& all) {
            std::string& image = all[1].second;
            // The header of lossless WebP: 14 bits of width - 1, 14 bits of height - 1.
            const std::uint32_t size = 15999u | 15999u << 14 | 1u << 28;
            std::memcpy(image.data() + 21, &size, 4);
        },
        "16000 x 16000");
    const std::string whole = sog_bytes(drawn(10, 0, 3), "z.sog");
    for (std::size_t size = 0; size < whole.size(); size += 13)
        EXPECT_THROW(parse_sog(whole.substr(0, size), "z.sog"), InputError) << size;
    std::string damaged = whole;
    damaged[200] = char(damaged[200] ^ 1);
    EXPECT_NE(reason<InputError>([&] { parse_sog(damaged, "z.sog"); }).find("checksum"),
              std::string::npos);
    EXPECT_THROW(sog_bytes({}, "n.sog"), InputError);
}

}  // namespace
}  // namespace knead
