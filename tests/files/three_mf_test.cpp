// 3MF: what is written is read again; builds of others; what is refused.
#include "host/files/three_mf.h"

#include <gtest/gtest.h>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/files/mesh_file.h"
#include "host/files/zip.h"
#include "tests/folder.h"
#include "tests/reason.h"

namespace knead {
namespace {

std::string archive(const std::string& model, const std::string& other = "")
{
    std::vector<std::pair<std::string, std::string>> parts{
        {"_rels/.rels",
         R"(<?xml version="1.0"?><Relationships xmlns="r"><Relationship Id="0"
            Target="/3D/a.model" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
            /></Relationships>)"},
        {"3D/a.model", model}};
    if (!other.empty()) parts.emplace_back("3D/other.model", other);
    return zip_bytes(parts, "t.3mf");
}
MeshFile read(const std::string& model, const std::string& other = "")
{
    return parse_3mf(archive(model, other), "t.3mf");
}
std::string refused(const std::string& model)
{
    return reason<InputError>([&] { read(model); });
}

// Ten units long.
const std::string tetrahedron =
    R"(<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="+10" y="0" z="1e-400"/>
    <vertex x='0' y='10' z='0'/><vertex x="0" y="0" z="10"/></vertices><triangles>
    <triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3" pid="7" p1="1"/>
    <triangle v1="0" v2="3" v3="2"/><triangle v1="1" v2="2" v3="3"/></triangles></mesh>)";
std::string model(const std::string& head, const std::string& objects, const std::string& items)
{
    return "<?xml version=\"1.0\"?><!-- by hand --><model " + head + " xmlns=\"x\"><resources>" +
           objects + "</resources><build>" + items + "</build></model>";
}
std::string object(const std::string& body)
{
    return "<object id=\"1\" type=\"model\" name=\"t\">" + body + "</object>";
}
constexpr const char* item = "<item objectid=\"1\"/>";

TEST(ThreeMf, HasAUnitAndPlaces)
{
    const std::pair<const char*, double> units[] = {{"unit=\"meter\"", 1},
                                                    {"unit=\"millimeter\"", 1e-3},
                                                    {"", 1e-3},
                                                    {"unit=\"inch\"", 0.0254}};
    for (const auto& [head, unit] : units) {
        const MeshFile file = read(model(head, object(tetrahedron), item));
        EXPECT_EQ(file.unit, unit);
        EXPECT_NEAR(volume(file.meshes.at(0)) / (1000.0 / 6 * unit * unit * unit), 1, 1e-9);
        EXPECT_EQ(file.meshes[0].name, "t");
    }
    // Mirrored and moved, twice; and as a component of another part, turned a quarter about z.
    const MeshFile two = read(model(
        "unit=\"meter\"", object(tetrahedron),
        R"(<item objectid="1"/><item objectid="1" transform="-1 0 0 0 1 0 0 0 1 100 0 0"/>)"));
    ASSERT_EQ(two.meshes.size(), 2u);
    EXPECT_NEAR(volume(two.meshes[1]), 1000.0 / 6, 1e-9);
    EXPECT_NEAR(box_of(two.meshes).high.x, 100, 1e-9);
    const MeshFile other =
        read(model("unit=\"meter\" requiredextensions=\"p\"",
                   object(R"(<components><component objectid="1" p:path="/3D/other.model"
                             transform="0 1 0 -1 0 0 0 0 1 0 0 5"/></components>)"),
                   item),
             model("unit=\"meter\"", object(tetrahedron), ""));
    EXPECT_NEAR(box_of(other.meshes).low.x, -10, 1e-9);
    EXPECT_NEAR(box_of(other.meshes).high.z, 15, 1e-9);
}

TEST(ThreeMf, HasColours)
{
    const MeshFile file =
        read(model("",
                   R"(<basematerials id="7"><base name="a" displaycolor="#FF0000"/>
                 <base name="b" displaycolor="#00FF00FF"/></basematerials>)" +
                       object(tetrahedron),
                   item));
    const auto& colours = file.meshes[0].colours;
    ASSERT_EQ(colours.size(), 4u);
    EXPECT_EQ(colours[1].y, 1);
    EXPECT_EQ(colours[1].x, 0);
    EXPECT_EQ(colours[2].x, 1) << "white where none is given";
    EXPECT_NE(refused(model("",
                            "<m:colorgroup id=\"7\"><m:color color=\"#00FF00\"/></m:colorgroup>" +
                                object(tetrahedron),
                            item))
                  .find("one of 1 colours"),
              std::string::npos);
}

TEST(ThreeMf, IsReadAsItIsWritten)
{
    const Folder folder;
    MeshFile file = read(model("unit=\"meter\"", object(tetrahedron), item));
    std::vector<Mesh> meshes = float_meshes(file, "t");
    meshes.push_back(meshes[0]);
    meshes[0].colours = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5f, 0.25f, 1}};
    meshes[1].category = 4;
    write_mesh(folder / "a.3mf", meshes, {{"a <b> & \"c\"", "lid"}, "millimetres"});
    const MeshFile again = read_mesh_file(folder / "a.3mf");
    EXPECT_EQ(again.unit, 0.001);
    ASSERT_EQ(again.meshes.size(), 2u);
    EXPECT_EQ(again.meshes[1].name, "lid");
    EXPECT_NEAR(volume(again.meshes[0]), 1000.0 / 6 * 1e-9, 1e-15);
    ASSERT_EQ(again.meshes[0].colours.size(), 4u);
    EXPECT_NEAR(again.meshes[0].colours[3].y, 0.25, 0.01);
    EXPECT_NEAR(again.meshes[1].colours.at(0).x, category_colour(4).x, 0.01);
}

TEST(ThreeMf, SaysWhatIsWrong)
{
    const std::string whole = model("", object(tetrahedron), item);
    const auto with = [&](const std::string& by, const std::string& other) {
        std::string text = whole;
        text.replace(text.find(by), by.size(), other);
        return refused(text);
    };
    EXPECT_EQ(refused(whole), "");
    EXPECT_NE(with("x=\"+10\"", "x=\"1,5\"").find("\"1,5\" (decimal comma?)"), std::string::npos);
    EXPECT_NE(with("x=\"+10\"", "").find("the attribute \"x\" of <vertex>"), std::string::npos);
    EXPECT_NE(with("v1=\"1\"", "v1=\"9\"").find("expected vertices from 0 to 3"),
              std::string::npos);
    EXPECT_NE(with("objectid=\"1\"", "objectid=\"2\"").find("an object of 3D/a.model, found \"2\""),
              std::string::npos);
    EXPECT_NE(with("<model ", "<model unit=\"yard\" ").find("found yard"), std::string::npos);
    EXPECT_NE(with("<model ", "<model requiredextensions=\"b\" ").find("found b"),
              std::string::npos);
    EXPECT_NE(with("<!--", "<!DOCTYPE x><!--").find("no document type"), std::string::npos);
    EXPECT_NE(refused(model("", object(tetrahedron), "")).find("an item"), std::string::npos);
    const std::string circle =
        object("<components><component objectid=\"1\"/><component objectid=\"1\"/></components>");
    EXPECT_NE(refused(model("", circle, item)).find("in each other"), std::string::npos);
    for (std::size_t cut = 0; cut < whole.size(); cut += 7) refused(whole.substr(0, cut));
    const std::string bytes = archive(whole);
    for (std::size_t cut = 0; cut < bytes.size(); cut += 11)
        EXPECT_NE(reason<InputError>([&] { parse_3mf(bytes.substr(0, cut), "t.3mf"); }), "");
}

}  // namespace
}  // namespace knead
