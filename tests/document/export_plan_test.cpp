// What `export` writes, by document and file name: content, unit, objects, and why it is refused.
#include "host/document/export_plan.h"

#include <gtest/gtest.h>

#include "host/document/command_table.h"
#include "host/document/reduce.h"
#include "tests/document/random.h"

namespace knead {
namespace {

std::shared_ptr<const SceneObject> object(std::uint32_t id, const std::string& name, int category,
                                          ShapeKind shape = ShapeKind::sphere, bool hidden = false)
{
    SceneObject o;
    o.id = {id}, o.name = name, o.category = category, o.hidden = hidden;
    o.source.shape = shape;
    return std::make_shared<const SceneObject>(o);
}

template <class... Names>
std::optional<std::vector<ObjectRef>> named(Names... names)
{
    return std::vector<ObjectRef>{ObjectRef(std::string(names))...};
}

class ExportPlans : public testing::Test {
  protected:
    ExportPlans()
    {
        d.objects = {object(1, "ball", 0), object(2, "block", 1), object(3, "lid", 1),
                     object(4, "mould", 2, ShapeKind::box, true),
                     object(5, "pot", 3, ShapeKind::splats)};
    }
    ExportPlan plan(const Export& command) const
    {
        const auto made = export_plan(d, command);
        const Refusal* refusal = std::get_if<Refusal>(&made);
        EXPECT_FALSE(refusal) << command.file << ": " << refusal->text();
        return refusal ? ExportPlan{} : std::get<ExportPlan>(made);
    }
    // By reduce(), which the session, runs and replays call.
    std::string refused(const Export& command) const
    {
        IdSource ids;
        const auto found = reduce(std::make_shared<const Document>(d), command, ids);
        const Refusal* refusal = std::get_if<Refusal>(&found);
        return refusal ? refusal->text() : "";
    }
    static std::vector<std::uint32_t> ids(const ExportPlan& plan)
    {
        std::vector<std::uint32_t> all;
        for (const ObjectId id : plan.objects) all.push_back(id.value);
        return all;
    }
    using Ids = std::vector<std::uint32_t>;

    Document d;
};

TEST_F(ExportPlans, TheEndingDecidesContentAndUnit)
{
    const auto expect = [&](const char* file, ExportContent what, LengthUnit unit) {
        const ExportPlan made = plan({file, {}, {}, {}});
        EXPECT_EQ(made.what, what) << file;
        EXPECT_EQ(made.unit, unit) << file;
    };
    const auto surface = ExportContent::surface, splats = ExportContent::splats;
    expect("a.stl", surface, LengthUnit::millimetre);
    expect("a.STL", surface, LengthUnit::millimetre);
    for (const char* file : {"a.glb", "a.obj", "a.ply"}) expect(file, surface, LengthUnit::metre);
    for (const char* file : {"a.splat", "a.spz"}) expect(file, splats, LengthUnit::metre);
    EXPECT_EQ(plan({"a.ply", splats, LengthUnit::inch, {}}).what, splats);
    EXPECT_EQ(plan({"a.ply", splats, LengthUnit::inch, {}}).unit, LengthUnit::inch);
    // Of splats only.
    EXPECT_EQ(plan({"a.ply", {}, {}, named("pot")}).what, splats);
    EXPECT_EQ(plan({"a.stl", {}, {}, named("pot")}).what, surface) << "the clay of the splats";
    d.objects = {d.objects.back()};
    expect("a.glb", splats, LengthUnit::metre);
}

TEST_F(ExportPlans, HiddenObjectsAreLeftOutUnlessNamed)
{
    EXPECT_EQ(ids(plan({"a.glb", {}, {}, {}})), (Ids{1, 2, 3, 5}));
    EXPECT_EQ(ids(plan({"a.glb",
                        {},
                        {},
                        std::vector<ObjectRef>{ObjectId{4}, named("ball")->at(0), ObjectId{1}}})),
              (Ids{1, 4}));
    EXPECT_EQ(ids(plan({"a.spz", {}, {}, {}})), Ids{5});
    EXPECT_FALSE(plan({"a.spz", {}, {}, {}}).partial);
    d.objects.push_back(object(6, "jug", 3, ShapeKind::splats, true));
    EXPECT_TRUE(plan({"a.spz", {}, {}, {}}).partial);
    EXPECT_FALSE(plan({"a.spz", {}, {}, named("pot", "jug")}).partial);
}

TEST_F(ExportPlans, SurfacesHaveTheNamesOfTheirObjects)
{
    EXPECT_EQ(surface_name(d, 0), "ball");
    EXPECT_EQ(surface_name(d, 1), "block + lid");
    EXPECT_EQ(surface_name(d, 9), "category 9");
}

TEST_F(ExportPlans, RefusalsSayWhatIsExpected)
{
    const auto surface = ExportContent::surface, splats = ExportContent::splats;
    for (const char* file : {"", "ball", "ball.step", "ball.knead", ".glb/ball"})
        EXPECT_EQ(
            refused({file, {}, {}, {}}),
            "file: expected a name that ends in .3mf, .glb, .obj, .ply or .stl for the surface, in "
            ".glb, .ply, .sog, .splat or .spz for splats");
    EXPECT_EQ(refused({"a.obj", splats, {}, {}}),
              "file: expected a name that ends in .glb, .ply, .sog, .splat or .spz for splats");
    EXPECT_EQ(refused({"a.spz", surface, {}, {}}),
              "file: expected a name that ends in .3mf, .glb, .obj, .ply or .stl for the surface");
    EXPECT_EQ(refused({"a.spz", {}, {}, named("ball")}), "objects: expected an object of splats");
    EXPECT_EQ(refused({"a.glb", {}, {}, named("bal")}),
              "objects: there is no object \"bal\"; the nearest name is \"ball\"");
    EXPECT_EQ(refused({"a.glb", {}, {}, std::vector<ObjectRef>{ObjectId{9}}}),
              "objects: there is no object 9");
    EXPECT_EQ(refused({"a.glb", {}, {}, std::vector<ObjectRef>{}}),
              "objects: expected at least one object");
    EXPECT_EQ(refused({"a.glb", {}, {}, std::vector<ObjectRef>(100000, ObjectId{1})}),
              "objects: expected at most 256 objects");
    d.objects = {object(1, "ball", 0)};
    EXPECT_EQ(refused({"a.spz", {}, {}, {}}), "there are no splats to export");
    d.objects = {object(1, "ball", 0, ShapeKind::sphere, true)};
    EXPECT_EQ(refused({"a.glb", {}, {}, {}}),
              "objects: all objects are hidden; expected the objects to export");
    EXPECT_EQ(refused({"a.glb", {}, {}, named("ball")}), "") << "it is named";
}

TEST_F(ExportPlans, ItNeedsObjectsAndASimulation)
{
    Situation s;
    s.document = &d;
    const auto why_not = [&] { return row_of(Export{}).why_not(s); };
    s.editable = false, s.live = false;
    EXPECT_EQ(why_not(), "");
    s.simulation = false;
    EXPECT_EQ(why_not(), "there is no simulation");
    s.simulation = true;
    d.objects.clear();
    EXPECT_EQ(why_not(), "there is nothing to export");
    EXPECT_EQ(refused({"a.glb", {}, {}, {}}), "there is nothing to export");
}

}  // namespace
}  // namespace knead
