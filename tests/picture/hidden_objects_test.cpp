// Hidden objects: they are in the simulation and in no picture.
#include <gtest/gtest.h>

#include <stdexcept>

#include "host/files/image.h"
#include "host/picture/frame_writer.h"
#include "host/picture/live_look.h"
#include "host/session/backend.h"
#include "tests/folder.h"
#if KNEAD_HAS_GL
#include "tests/render/eye_picture.h"
#endif

namespace knead {
namespace {

LiveOptions stepped_on_the_cpu()
{
    LiveOptions options;
    options.stepped = true, options.recorded = false;
    options.make_solver = [](const Setup& s) { return make_solver(s, parse_device("cpu")); };
    return options;
}

const std::vector<std::string> coarse{"domain.cells=16", "surface.nodes=16", "pictures.width=160",
                                      "pictures.height=120"};

SceneObject object_of_shape(ShapeKind shape, std::uint32_t id, bool hidden)
{
    SceneObject o;
    o.id = {id}, o.category = int(id), o.source.shape = shape, o.hidden = hidden;
    return o;
}

TEST(HiddenObjects, TakeSplatsOutOfThePictureIfAllOfThemAreHidden)
{
    const auto state = [](std::vector<SceneObject> objects) {
        auto document = std::make_shared<Document>();
        for (SceneObject& o : objects)
            document->objects.push_back(std::make_shared<const SceneObject>(std::move(o)));
        LiveState with{};
        with.splats = std::make_shared<const SplatCloud>();
        with.document = document;
        return with;
    };
    const auto splats = [](std::uint32_t id, bool hidden) {
        return object_of_shape(ShapeKind::splats, id, hidden);
    };
    const SceneObject ball = object_of_shape(ShapeKind::sphere, 9, false);
    EXPECT_TRUE(splats_hidden(state({splats(1, true), splats(2, true), ball})));
    EXPECT_FALSE(splats_hidden(state({splats(1, true), splats(2, false), ball})));
    LiveState none = state({ball});
    none.splats.reset();
    EXPECT_FALSE(splats_hidden(none)) << "there are none";
    EXPECT_FALSE(splats_hidden(LiveState{}));
}

#if KNEAD_HAS_GL

TEST(HiddenObjects, LeaveThePictureOfALiveStateAndComeBack)
{
    std::unique_ptr<Context> context;
    try {
        context = std::make_unique<Context>();
    } catch (const std::runtime_error& reason) {
        GTEST_SKIP() << reason.what();
    }
    const Context::Bound bound(*context);
    LiveSession live(load_live_scene("scenes/squeeze.json", coarse), stepped_on_the_cpu());
    live.wait_for_commands();
    const std::unique_ptr<EyePainter> painter = EyePainter::open(1, false);
    const OffscreenTarget to(GL_RGBA8);
    const auto painted = [&](const LiveState& state) {
        show_clay(*painter, state);
        painter->paint(front(), live_look(state.scene->scene), {to.frame});
        return to.colours();
    };
    const std::vector<int> before = painted(*live.state());
    const auto hide = [&](bool on) {
        live.send(SetFlags{ObjectId{1}, {}, on});
        live.wait_for_commands();
        EXPECT_EQ(live.state()->refusal, "");
    };
    hide(true);
    EXPECT_EQ(live.state()->document->hidden_categories(), std::vector<int>{0});
    const std::vector<int> hidden = painted(*live.state());
    EXPECT_NE(hidden, before);
    LiveState nothing = *live.state();
    nothing.meshes.reset(), ++nothing.mesh_version;
    EXPECT_EQ(hidden, painted(nothing)) << "neither clay nor its shadow";
    hide(false);
    EXPECT_EQ(painted(*live.state()), before);
}

TEST(HiddenObjects, AreNotInThePicturesOfARun)
{
    Scene scene = read_scene("scenes/squeeze.json", coarse);
    build(scene, std::size_t(1) << 32);
    LiveSession live(load_live_scene("scenes/squeeze.json", coarse), stepped_on_the_cpu());
    live.wait_for_commands();
    const std::vector<Mesh> clay = *meshes_of(*live.state());
    ASSERT_FALSE(clay.empty());
    const Folder folder;
    std::unique_ptr<FrameWriter> writer;
    try {
        writer = std::make_unique<FrameWriter>(scene, folder.path().string(), "", 30);
    } catch (const std::runtime_error& reason) {
        GTEST_SKIP() << reason.what();
    }
    int number = 0;
    const auto written = [&](const std::vector<Mesh>& meshes, const std::vector<int>& hidden) {
        FrameResult frame;
        frame.number = ++number;
        Document document;
        for (const int category : hidden) {
            SceneObject o = object_of_shape(ShapeKind::sphere, std::uint32_t(number), true);
            o.category = category;
            document.objects.push_back(std::make_shared<const SceneObject>(std::move(o)));
        }
        writer->add(frame, meshes, {}, {}, &document);
        return read_png(folder / picture_name(number)).rgb;
    };
    const auto bare = written({}, {}), whole = written(clay, {});
    EXPECT_NE(whole, bare);
    EXPECT_EQ(written(clay, {clay[0].category + 1}), whole) << "another category";
    EXPECT_EQ(written(clay, {clay[0].category}), bare);
}

// As `knead run --commands` does with a command that adds splats: the scene has none.
TEST(HiddenObjects, TheClayOfSplatsThatWereAddedIsNotDrawnWithThem)
{
    Scene scene = read_scene("scenes/squeeze.json", coarse);
    build(scene, std::size_t(1) << 32);
    LiveSession live(load_live_scene("scenes/squeeze.json", coarse), stepped_on_the_cpu());
    live.wait_for_commands();
    const std::vector<Mesh> clay = *meshes_of(*live.state());
    ASSERT_FALSE(clay.empty());
    const Folder folder;
    std::unique_ptr<FrameWriter> writer;
    try {
        writer = std::make_unique<FrameWriter>(scene, folder.path().string(), "", 30);
    } catch (const std::runtime_error& reason) {
        GTEST_SKIP() << reason.what();
    }
    Document document;
    const auto written = [&](bool with_document) {
        writer->add({}, clay, {}, {}, with_document ? &document : nullptr);
        return read_png(folder / picture_name(0)).rgb;
    };
    const auto as_clay = written(false);
    EXPECT_EQ(written(true), as_clay);
    SceneObject added = object_of_shape(ShapeKind::splats, 2, false);
    added.category = clay[0].category;
    document.objects.push_back(std::make_shared<const SceneObject>(added));
    EXPECT_NE(written(true), as_clay);
}

#endif

}  // namespace
}  // namespace knead
