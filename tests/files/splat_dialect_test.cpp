// Dialects of splat PLY: what trainers other than the first one write, and what is refused by name.
#include <gtest/gtest.h>

#include <cmath>

#include "host/base/errors.h"
#include "host/files/file_kind.h"
#include "tests/files/splat_cases.h"
#include "tests/reason.h"

namespace knead {
namespace {

Names without(const Names& names, const std::string& prefix)
{
    Names left;
    for (const std::string& name : names)
        if (!name.starts_with(prefix)) left.push_back(name);
    return left;
}

// All remarks of a file, a line each.
std::string said(const SplatFile& file)
{
    std::string all;
    for (const std::string& remark : remarks(file)) all += remark + "\n";
    return all;
}

bool contains(const std::string& text, const std::string& part)
{
    return text.find(part) != std::string::npos;
}

// one_row without f_dc, with three colours of a type behind.
template <class T>
std::string coloured(const std::vector<T>& rgb, const std::string& type, const Names& names)
{
    std::vector<float> row(one_row.begin(), one_row.end());
    row.erase(row.begin() + 3, row.begin() + 6);
    return "ply\nformat binary_little_endian 1.0\nelement vertex 1\n" +
           properties(without(plain, "f_dc_")) + properties(names, type) + "end_header\n" +
           bytes_of(row) + bytes_of(rgb);
}

TEST(SplatDialects, ColoursOfThreeChannelsBecomeTheCoefficientOfDegreeZero)
{
    const Names names{"red", "green", "blue"};
    const auto dc = [](const std::string& bytes) {
        const SplatFile file = parse_splat_ply(bytes, "rgb.ply");
        EXPECT_TRUE(contains(said(file), "colours are read from")) << said(file);
        return file.cloud.sh.at(0);
    };
    const Vec3<float> bytes = dc(coloured(std::vector<std::uint8_t>{229, 25, 128}, "uchar", names));
    EXPECT_NEAR(bytes.x, 1.411012, 1e-6);
    EXPECT_NEAR(bytes.y, -1.424914, 1e-6);
    const float f = 229 / 255.0f, g = 25 / 255.0f;
    const Vec3<float> floats = dc(coloured(std::vector<float>{f, g, 0.5f}, "float", names));
    EXPECT_NEAR(floats.x, 1.411012, 1e-6);
    EXPECT_NEAR(floats.y, -1.424914, 1e-6);
    const std::string large =
        coloured(std::vector<float>{229, 25, 127.5f}, "float", {"r", "g", "b"});
    const Vec3<float> scaled = dc(large);
    EXPECT_NEAR(scaled.x, 1.411012, 2e-4);  // went through floats of 255 times the size
    EXPECT_NEAR(scaled.y, -1.424914, 2e-4);
    EXPECT_NEAR(scaled.z, 0, 2e-4);
    EXPECT_TRUE(contains(said(parse_splat_ply(large, "l.ply")), "0 to 255"));
    // Beside harmonics they are for other programs.
    Names both = plain;
    std::vector<double> row = one_row;
    for (const char* name : {"red", "green", "blue"}) both.push_back(name), row.push_back(0.9);
    const SplatFile kept = parse_splat_ply(little(row, both), "both.ply");
    EXPECT_EQ(length(kept.cloud.sh[0] - Vec3<float>{0.5f, 0.25f, -1}), 0);
    EXPECT_EQ(said(kept), "");
    for (const Names& incomplete : {Names{"red", "green"}, Names{"r"}})
        EXPECT_THROW(
            parse_splat_ply(coloured(std::vector<float>(incomplete.size(), 1), "float", incomplete),
                            "i.ply"),
            InputError);
    EXPECT_THROW(
        parse_splat_ply(coloured(std::vector<std::int32_t>{1, 2, 3}, "int", names), "w.ply"),
        InputError);
}

TEST(SplatDialects, TheFilterOfMipSplattingIsApplied)
{
    Names names = plain;
    names.push_back("filter_3D");
    std::vector<double> row = one_row;
    row[6] = std::log(0.9 / 0.1);
    row[7] = row[8] = std::log(0.02), row[9] = std::log(0.002);
    row.push_back(0.01);
    const SplatFile file = parse_splat_ply(little(row, names), "mip.ply");
    EXPECT_NEAR(file.cloud.scale[0].x, 0.0223607, 1e-6);
    EXPECT_NEAR(file.cloud.scale[0].y, 0.0223607, 1e-6);
    EXPECT_NEAR(file.cloud.scale[0].z, 0.0101980, 1e-6);
    EXPECT_NEAR(file.cloud.opacity[0], 0.9 * 0.15689, 1e-5);
    EXPECT_TRUE(file.cloud.antialiased);
    EXPECT_TRUE(contains(said(file), "filter_3D is applied"));
}

TEST(SplatDialects, OtherMethodsAreRefusedByName)
{
    const auto why = [](const Names& more, const std::string& element = "") {
        Names names = without(plain, "f_dc_");
        names.insert(names.end(), more.begin(), more.end());
        std::string bytes = little(std::vector<double>(names.size(), 0.5), names);
        if (!element.empty()) {
            bytes.insert(bytes.find("end_header"), "element " + element + " 0\nproperty float a\n");
        }
        EXPECT_TRUE(holds_splats(parse_ply_header(bytes, "other.ply")));
        return reason<InputError>([&] { parse_splat_ply(bytes, "other.ply"); });
    };
    EXPECT_TRUE(contains(why({"f_offset_0", "f_anchor_feat_0"}), "Scaffold-GS"));
    EXPECT_TRUE(contains(why({"scale_3", "scale_4", "scale_5"}), "Scaffold-GS"));
    EXPECT_TRUE(contains(why({"level", "extra_level", "info", "f_offset_0"}), "Octree-GS"));
    EXPECT_TRUE(contains(why({"sb_params_0"}), "beta splatting"));
    EXPECT_TRUE(contains(why({"beta"}), "not Gaussians"));
    EXPECT_TRUE(contains(why({"motion_0", "trbf_center"}), "splats move"));
    EXPECT_TRUE(contains(why({}, "codebook_centers"), "codebooks"));
}

TEST(SplatDialects, PropertiesThatAreNotUnderstoodAreNamedOnce)
{
    Names names = plain;
    std::vector<double> row = one_row;
    const Names more{"nx", "obj_dc_0", "label", "roughness", "f_asg_0", "albedo_r"};
    for (const std::string& name : more) names.push_back(name), row.push_back(1);
    EXPECT_EQ(said(parse_splat_ply(little(row, names), "u.ply")),
              "properties that are not understood and left out: roughness, f_asg_0, albedo_r\n");
    for (int k = 0; k < 40; ++k) names.push_back("v" + std::to_string(k)), row.push_back(1);
    EXPECT_TRUE(contains(said(parse_splat_ply(little(row, names), "u.ply")), "and 31 more"));
}

TEST(SplatDialects, DiscsAndGreySplatsAreSaid)
{
    const std::vector<double> row(one_row.begin(), one_row.end() - 1);
    EXPECT_TRUE(contains(said(parse_splat_ply(little(row, without(plain, "scale_2")), "d.ply")),
                         "flat discs"));
    const std::vector<double> short_row(one_row.begin(), one_row.end() - 3);
    EXPECT_TRUE(contains(said(parse_splat_ply(little(short_row, without(plain, "f_dc_")), "g.ply")),
                         "grey"));
}

// Scale and opacity as stored, 200 splats in a box of 2 m.
std::string uniform(double scale, double opacity)
{
    std::vector<double> rows;
    for (int i = 0; i < 200; ++i) {
        std::vector<double> row = one_row;
        row[0] = -1 + i / 100.0, row[1] = std::sin(i), row[2] = std::cos(i);
        row[6] = opacity * (1 + 0.001 * (i % 7));
        row[7] = row[8] = row[9] = scale;
        rows.insert(rows.end(), row.begin(), row.end());
    }
    return little(rows);
}

TEST(SplatDialects, ValuesThatLookLinearBringAHint)
{
    const std::string linear = said(parse_splat_ply(uniform(0.0375994, 0.95), "l.ply"));
    EXPECT_TRUE(contains(linear, "every opacity")) << linear;
    EXPECT_TRUE(contains(linear, "every scale")) << linear;
    EXPECT_EQ(said(parse_splat_ply(uniform(-3, 2), "t.ply")), "");
    // In millimetres: logarithms are positive, and the box is 2000 wide.
    std::vector<double> rows;
    for (int i = 0; i < 200; ++i) {
        std::vector<double> row = one_row;
        row[0] = -1000 + 10 * i, row[6] = -3 + 0.05 * i, row[7] = row[8] = row[9] = 3;
        rows.insert(rows.end(), row.begin(), row.end());
    }
    EXPECT_EQ(said(parse_splat_ply(little(rows), "mm.ply")), "");
}

TEST(SplatDialects, TheLastCommentOnTheScreenFilterCounts)
{
    const auto read = [](const std::string& comments) {
        const std::string head = header("binary_little_endian", 1, plain, "float", comments);
        const std::vector<float> floats(one_row.begin(), one_row.end());
        return parse_splat_ply(head + bytes_of(floats), "c.ply");
    };
    EXPECT_TRUE(read("comment splatrendermode: MIP\n").cloud.antialiased);
    EXPECT_TRUE(read("comment antialiased 0\ncomment Antialiased 1\n").cloud.antialiased);
    EXPECT_FALSE(
        read("comment antialiased 1\ncomment SplatRenderMode: default\n").cloud.antialiased);
    EXPECT_TRUE(contains(said(read("comment Vertical Axis: z\n")), "\"up\": \"z\""));
}

TEST(SplatDialects, LinearColoursOfAnElementBehindTheSplatsAreSaid)
{
    const auto read = [](char space) {
        std::string head = header("binary_little_endian", 1, plain);
        head.insert(head.find("end_header"),
                    "element extrinsic 1\nproperty float e\nelement color_space 1\n"
                    "property uchar color_space\n");
        const std::vector<float> floats(one_row.begin(), one_row.end());
        return said(parse_splat_ply(
            head + bytes_of(floats) + bytes_of(std::vector<float>{1}) + space, "sharp.ply"));
    };
    EXPECT_EQ(read('\0'), "");
    EXPECT_TRUE(contains(read('\1'), "linear"));
}

}  // namespace
}  // namespace knead
