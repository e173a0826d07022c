// Numbers and encodings of texts that other programs wrote, in every reader of text.
#include "host/base/text_number.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/files/file_kind.h"
#include "host/files/mesh_reader.h"
#include "host/files/particle_file.h"
#include "host/files/stl.h"
#include "host/hands/recording.h"
#include "tests/folder.h"
#include "tests/reason.h"

namespace knead {
namespace {

double value(const std::string& word)
{
    const TextNumber found = text_number(word);
    EXPECT_EQ(found.fault, "") << word;
    return found.value;
}
std::string fault(const std::string& word) { return std::string(text_number(word).fault); }

TEST(TextNumber, IsWhatTheWholeWordSays)
{
    EXPECT_EQ(value("0.5"), 0.5);
    EXPECT_EQ(value("+0.5"), 0.5);
    EXPECT_EQ(value("-.5e1"), -5);
    EXPECT_EQ(value("7."), 7);
    EXPECT_EQ(value("6e5"), 6e5);
    EXPECT_EQ(value("5123456.123456789"), 5123456.123456789);
    EXPECT_EQ(value("1e-50"), 1e-50);
    EXPECT_EQ(value("1e-400"), 0);
    EXPECT_EQ(value("-3.2e-320"), -3.2e-320);
    EXPECT_TRUE(std::signbit(value("-0.0")));
    for (const char* word : {"nan", "NaN", "-nan(ind)", "1.#IND", "-1.#IND", "1.#QNAN"})
        EXPECT_TRUE(std::isnan(value(word))) << word;
    EXPECT_EQ(value("-1.#INF"), -std::numeric_limits<double>::infinity());
    EXPECT_EQ(value("Infinity"), std::numeric_limits<double>::infinity());
    for (const char* word : {"", "+", "-", "++1", "+-1", "1.5x", "1e", "0x1", "two", "1.#", "e5"})
        EXPECT_EQ(fault(word), "no number") << word;
    EXPECT_EQ(fault("1e999"), "too large");
    EXPECT_EQ(fault("-1e999"), "too large");
    for (const char* word : {"1,5", "0,0", "-1,5", "1,5e3"})
        EXPECT_EQ(fault(word), "decimal comma?") << word;
    EXPECT_EQ(fault("1,two"), "no number");
    EXPECT_EQ(finite_text_number("nan").fault, "not finite");
}

constexpr const char* points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
constexpr const char* faces = "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

std::string replaced(std::string text, const std::string& by, const std::string& with)
{
    for (std::size_t at = 0; (at = text.find(by, at)) != text.npos; at += with.size())
        text.replace(at, by.size(), with);
    return text;
}
MeshFile obj(const std::string& text) { return parse_obj(text, "t.obj"); }
std::string refused(const std::string& text)
{
    return reason<InputError>([&] { obj(text); });
}

TEST(ObjFile, IsReadAsOthersWriteIt)
{
    const std::string plain = std::string(points) + faces;
    for (const std::string& text :
         {plain, "\xef\xbb\xbf" + plain, replaced(plain, "\n", "\r\n"), replaced(plain, "\n", "\r"),
          faces + std::string(points), replaced(plain, "f 1 3 2", "f 1 3 \\\n2"),
          replaced(plain, "f 1 3 2", "f 1 3 \\\r\n  2"), replaced(plain, "f 1 3 2", "f 1 3 2#x"),
          replaced(plain, "f 1 3 2", "f 1 3 2 # first"), replaced(plain, "v 0 1 0", "v 0 +1 -0.0"),
          replaced(plain, "v 1 0 0", "v 1 1e-50 -3.2e-320"),
          replaced(plain, "v 1 0 0", "v 1 0 0 2"), replaced(plain, "f 2 3 4", "f -3/1/1 -2//7 -1"),
          "# head\no x\ns off\n" + plain}) {
        const MeshFile file = obj(text);
        EXPECT_NEAR(volume(file.meshes.at(0)), 1.0 / 6, 1e-12) << text;
        EXPECT_TRUE(file.notes.empty());
    }
    EXPECT_EQ(obj(plain + "l 1 2\np 1\n").notes.at(0), "2 lines and points left out");
    const MeshFile shown =
        obj(replaced(plain, "\nf 1 3", " 0.5\nf 1 3").replace(0, 0, "usemtl a\n"));
    EXPECT_EQ(shown.notes.size(), 1u);
}

TEST(ObjFile, HasColoursBesideItsVertices)
{
    const auto with = [](const std::string& colour) {
        return obj(replaced(std::string(points), "\n", " " + colour + "\n") + faces)
            .meshes[0]
            .colours;
    };
    for (const char* colour : {"1 0.5 0.2", "1 0.5 0.2 1", "255 127.5 51"}) {
        const auto colours = with(colour);
        ASSERT_EQ(colours.size(), 4u) << colour;
        EXPECT_NEAR(colours[3].x, 1, 1e-6);
        EXPECT_NEAR(colours[3].y, 0.2140411, 1e-6);
        EXPECT_NEAR(colours[3].z, 0.0331048, 1e-6);
    }
    EXPECT_TRUE(with("1").empty());
}

TEST(ObjFile, SaysWhatIsWrongWithItsNumbers)
{
    const std::string plain = std::string(points) + faces;
    EXPECT_EQ(refused(replaced(plain, "v 1 0 0", "v 1,5 0 0")),
              "t.obj: line 2: expected a finite number, found \"1,5\" (decimal comma?)");
    EXPECT_EQ(refused(replaced(plain, "v 1 0 0", "v 1e999 0 0")),
              "t.obj: line 2: expected a finite number, found \"1e999\" (too large)");
    EXPECT_NE(refused(replaced(plain, "v 1 0 0", "v 1.#IND 0 0")).find("(not finite)"),
              std::string::npos);
    EXPECT_EQ(refused(replaced(plain, "f 1 2 4", "f 1 2 5")),
              "t.obj: line 6: expected the number of one of 4 vertices, found \"5\"");
    EXPECT_NE(refused(replaced(plain, "f 1 2 4", "f 1 2 -5")).find("line 6"), std::string::npos);
    EXPECT_NE(refused(replaced(plain, "f 1 2 4", "f 1 2 0")).find("line 6"), std::string::npos);
    EXPECT_NE(refused(std::string("\xff\xfev\0", 4)).find("UTF-16"), std::string::npos);
}

TEST(StlFile, MayShoutAndHaveAMark)
{
    const std::string text =
        "solid x\nfacet normal nan 0 -1\nouter loop\nvertex 0 0 0\nvertex +1 0 0\nvertex 0 1 "
        "1e-400\nendloop\nendfacet\nendsolid x\n";
    std::string upper = text;
    for (char& c : upper)
        if (c >= 'a' && c <= 'z') c = char(c - 'a' + 'A');
    for (const std::string& one :
         {text, upper, "\xef\xbb\xbf" + text, replaced(text, "\n", "\r"), " \n" + text + text})
        EXPECT_GE(parse_stl(one, "t.stl").triangles.size(), 1u) << one;
    const auto said = [](const std::string& some) {
        return reason<InputError>([&] { parse_stl(some, "t.stl"); });
    };
    EXPECT_EQ(said(replaced(replaced(text, "\n", "\r\n"), "+1", "1,5")),
              "t.stl: line 5: expected a finite number, found \"1,5\" (decimal comma?)");
    std::string binary(84 + 50, '\0');
    binary.replace(0, 11, "solid knead"), binary[80] = 1;
    const float x[] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0};
    std::memcpy(&binary[84], x, sizeof x);
    EXPECT_EQ(parse_stl(binary, "t.stl").triangles.size(), 1u) << "by its size";
}

std::string ply(const std::string& type, const std::string& rows, const std::string& end = "\n")
{
    return replaced("ply\nformat ascii 1.0\nelement vertex 4\nproperty " + type + " x\nproperty " +
                        type + " y\nproperty " + type + " z\nelement tristrips 1\n" +
                        "property list int int vertex_indices\nend_header\n" + rows,
                    "\n", end);
}

TEST(PlyText, IsReadAsOthersWriteIt)
{
    const std::string rows = "0 0 0\n+1 0 1e-400\n0 1 0\n0 0 1\n";
    for (const char* const end : {"\n", "\r\n", "\r"})
        for (const char* const type : {"float", "double", "int64", "uint64"}) {
            const FileMesh mesh =
                to_mesh(parse_ply(ply(type, rows + "4 0 1 2 3\n", end), "t"), "t");
            ASSERT_EQ(mesh.triangles.size(), 2u);
            EXPECT_TRUE((mesh.triangles[1] == Int3{1, 3, 2}));
            EXPECT_EQ(mesh.vertices[1].x, 1);
        }
    const std::string strips = "\xef\xbb\xbf" + ply("float", rows + "8 0 1 2 -1 1 3 2 0\n");
    EXPECT_EQ(to_mesh(parse_ply(strips, "t"), "t").triangles.size(), 3u);
    EXPECT_FALSE(holds_particles(parse_ply_header(strips, "t")));
    EXPECT_TRUE(holds_particles(parse_ply_header(replaced(strips, "strips 1", "strips 0"), "t")));
    const auto said = [&](const std::string& row) {
        return reason<InputError>([&] { parse_ply(ply("float", row + rows), "t"); });
    };
    EXPECT_NE(said("0 1,5 0").find("found \"1,5\" (decimal comma?)"), std::string::npos);
    EXPECT_NE(said("0 1.5x 0").find("found \"1.5x\""), std::string::npos);
    EXPECT_TRUE(std::isnan(parse_ply(ply("float", "1.#IND" + rows.substr(1) + "0\n"), "t")
                               .elements[0]
                               .properties[0]
                               .values[0]));
}

TEST(PlyBinary, HasWideIntegersAndDataThatBeginsLikeALine)
{
    const std::string head =
        "ply\rformat binary_little_endian 1.0\relement vertex 2\rproperty int64 x\rproperty uint64 "
        "y\rproperty int8 z\rend_header\r";
    std::string body(2 * 17, '\0');
    body[0] = '\n', body[17] = '\xfe', std::fill_n(body.begin() + 18, 7, '\xff'), body[25] = 3;
    const PlyFile file = parse_ply(head + body, "t");
    EXPECT_EQ(file.elements[0].properties[0].values[0], 10);
    EXPECT_EQ(file.elements[0].properties[0].values[1], -2);
    EXPECT_EQ(file.elements[0].properties[1].values[1], 3);
}

TEST(Csv, IsReadAsOthersWriteIt)
{
    EXPECT_EQ(parse_csv("x,y,z\n+0.5,0.5,0.5\n", "t")[0].x.x, 0.5);
    EXPECT_EQ(parse_csv("x,y,z,vx\n0.5,0.5,0.5,1e-400", "t")[0].v.x, 0);
    EXPECT_EQ(parse_csv("\xef\xbb\xbfx,y,z\r1,2,3\r4,5,6\r", "t").size(), 2u);
    EXPECT_NE(
        reason<InputError>([] { parse_csv(std::string("\xfe\xff\0x", 4), "t"); }).find("UTF-16"),
        std::string::npos);
}

TEST(JsonText, MayHaveTheMarkOfUtf8AndNoOther)
{
    EXPECT_EQ(parse_json("\xef\xbb\xbf{\"a\": 1e-400}", "t")["a"].get<double>(), 0);
    EXPECT_NE(reason<InputError>([] {
                  parse_json(std::string("\xff\xfe{\0}\0", 6), "t");
              }).find("UTF-16"),
              std::string::npos);
}

// The float step at five million metres is half a metre.
TEST(MeshFile, CoordinatesOfAMapKeepTheShape)
{
    const Folder folder;
    std::string text =
        "v 500000.1 5400000.2 300\nv 500000.3 5400000.2 300\n"
        "v 500000.1 5400000.4 300\nv 500000.1 5400000.2 300.2\n";
    const MeshFile file = obj(text + faces);
    EXPECT_NEAR(volume(file.meshes[0]) / (0.008 / 6), 1, 1e-6);
    const Vec3<double> origin = file.meshes[0].vertices[0];
    EXPECT_NEAR(volume(float_meshes(file, "t", origin)[0]) / (0.008 / 6), 1, 1e-5);
}

}  // namespace
}  // namespace knead
