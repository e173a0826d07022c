// Objects of meshes: their clay, what is refused, and their way through documents and sessions.
#include "host/assets/mesh_object.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <numbers>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/document/command_text.h"
#include "host/document/document_text.h"
#include "host/live/live_session.h"
#include "host/live/session_log.h"
#include "host/scene/seed.h"
#include "host/scene/solid_mesh.h"
#include "host/session/backend.h"
#include "host/session/session_file.h"
#include "tests/folder.h"
#include "tests/reason.h"
#include "tests/scene/density_noise.h"

namespace knead {
namespace {

// A vase of revolution, z up, of `around` sides: a foot, a belly, a neck. Its lower half alone
// where it is open.
std::string vase(int around, bool open = false, double unit = 1)
{
    const int rings = around / 2;
    std::string text, faces;
    const auto line = [&](const char* kind, auto a, auto b, auto c) {
        faces += fmt::format("{} {} {} {}\n", kind, a, b, c);
    };
    for (int i = 0; i <= rings; ++i)
        for (int k = 0; k < around; ++k) {
            const double h = double(i) / rings, a = 2 * std::numbers::pi * k / around,
                         r = 0.3 + 0.2 * std::sin(1 + 4.5 * h);
            text += fmt::format("v {} {} {}\n", unit * r * std::cos(a), unit * r * std::sin(a),
                                unit * 1.2 * h);
        }
    text += fmt::format("v 0 0 0\nv 0 0 {}\n", unit * 1.2);
    const auto at = [&](int i, int k) { return 1 + i * around + k % around; };
    const int bottom = 1 + (rings + 1) * around, top = bottom + 1;
    for (int k = 0; k < around; ++k) {
        for (int i = 0; i < (open ? rings / 2 : rings); ++i) {
            line("f", at(i, k), at(i, k + 1), at(i + 1, k + 1));
            line("f", at(i, k), at(i + 1, k + 1), at(i + 1, k));
        }
        line("f", bottom, at(0, k + 1), at(0, k));
        if (!open) line("f", top, at(rings, k), at(rings, k + 1));
    }
    return text + faces;
}

class MeshObject : public InFolder {
  protected:
    void SetUp() override
    {
        if (const char* state = std::getenv("XDG_STATE_HOME")) state_before = state;
        setenv("XDG_STATE_HOME", (folder / "state").c_str(), 1);
    }
    void TearDown() override
    {
        if (state_before.empty())
            unsetenv("XDG_STATE_HOME");
        else
            setenv("XDG_STATE_HOME", state_before.c_str(), 1);
    }
    std::string state_before;

    // Cells of 1 / `cells` m.
    Scene scene(const std::string& object, int cells)
    {
        Scene s = parse_scene(
            R"({"schema": "knead.scene/1", "domain": {"cells": )" + std::to_string(cells) +
                R"(}, "walls": {"min": [0, 0, 0], "max": [1, 1, 1]}, "objects": [{"shape": "mesh",
                "centre": [0.503, 0.497, 0.506], )" +
                object + "}]}",
            path("scene.json"));
        load_meshes(s);
        build(s, std::size_t(1) << 33);
        return s;
    }
    std::string refused(const std::string& object)
    {
        return reason<InputError>([&] { scene(object, 32); });
    }
};

TEST_F(MeshObject, IsFilledWithItsVolumeEvenly)
{
    write_whole(path("vase.obj"), vase(64));
    for (const char* rotation : {"[1, 0, 0, 0]", "[0.8, 0.36, 0, 0.48]"}) {
        const Scene s = scene(std::string(R"("file": "vase.obj", "up": "z", "size": 0.7,
            "rotation": )") + rotation,
                              48);
        const double volume = double(s.setup.particles.size()) * s.setup.materials[0].volume;
        EXPECT_NEAR(volume / shape_volume(s.objects[0]), 1, 0.002);
        EXPECT_LE(density_noise(s), 0.006);
        for (const Particle<double>& p : s.setup.particles)
            ASSERT_GE(depth(s.objects[0], p.x), -0.0015);
    }
}

TEST_F(MeshObject, HasTheSizeTheScaleOrTheUnitThatIsAskedFor)
{
    write_whole(path("vase.obj"), vase(48, false, 300));  // 360 high: millimetres
    const auto box = [&](const std::string& keys) {
        const Scene s = scene(R"("file": "vase.obj", )" + keys, 40);
        const Box3<double> found = box_of(s.objects[0]);
        return Box3<double>{found.low + s.origin, found.high + s.origin};
    };
    const Box3<double> sized = box(R"("up": "z", "size": 0.36)"),
                       unit = box(R"("up": "z", "unit": "mm")"),
                       scaled = box(R"("up": "z", "scale": 0.001)");
    EXPECT_NEAR(sized.high.y - sized.low.y, 0.36, 1e-9);
    EXPECT_NEAR(unit.high.y - unit.low.y, 0.36, 1e-9);
    EXPECT_NEAR(scaled.high.x, unit.high.x, 1e-12);
    EXPECT_NEAR((sized.low.y + sized.high.y) / 2, 0.497, 1e-9) << "its centre is that of its box";
    const Box3<double> lying = box(R"("size": 0.36, "up": "x")");
    EXPECT_NEAR(lying.high.z - lying.low.z, 0.36, 1e-9);
    const Box3<double> turned = box(R"("size": 0.36, "up": "x", "turn": 90)");
    EXPECT_NEAR(turned.high.x - turned.low.x, 0.36, 1e-9);
    EXPECT_NE(refused(R"("file": "vase.obj", "scale": 10)").find("a mesh of at most 1000 m"),
              std::string::npos);
    EXPECT_NE(refused(R"("file": "vase.obj", "size": 2)").find("between the walls"),
              std::string::npos);
}

TEST_F(MeshObject, MayBeHollow)
{
    write_whole(path("vase.obj"), vase(64));
    const Scene s = scene(R"("file": "vase.obj", "up": "z", "size": 0.7, "hollow": 0.06)", 48);
    const Object& o = s.objects[0];
    EXPECT_FALSE(inside(o, o.centre));
    const double volume = double(s.setup.particles.size()) * s.setup.materials[0].volume;
    EXPECT_NEAR(volume / shape_volume(o), 1, 0.02);
    for (const Particle<double>& p : s.setup.particles) ASSERT_GE(depth(o, p.x), -0.002);
    const Scene full = scene(R"("file": "vase.obj", "up": "z", "size": 0.7)", 48);
    EXPECT_LT(s.setup.particles.size(), 0.8 * double(full.setup.particles.size()));
}

TEST_F(MeshObject, IsRefusedWithThePlaceWhereItIsOpen)
{
    write_whole(path("open.obj"), vase(32, true, 100));
    const std::string why = refused(R"("file": "open.obj", "size": 0.5)");
    EXPECT_NE(why.find("scene.json: /objects/0: "), std::string::npos) << why;
    EXPECT_NE(why.find("open.obj: expected a closed surface, found one with holes of"),
              std::string::npos)
        << why;
    EXPECT_NE(why.find(", 60)"), std::string::npos) << "an edge of its top: " << why;
    EXPECT_NE(refused(R"("file": "gone.obj", "size": 0.5)").find("gone.obj"), std::string::npos);
    EXPECT_NE(refused(R"("file": "../open.obj", "size": 0.5)").find("folder"), std::string::npos);
    write_whole(path("notes.txt"), "text");
    EXPECT_NE(refused(R"("file": "notes.txt", "size": 0.5)").find("expected a mesh ending in"),
              std::string::npos);
}

TEST_F(MeshObject, IsReadAgainOnlyWhereItsFileChanged)
{
    write_whole(path("vase.obj"), vase(32));
    const char* const keys = R"("file": "vase.obj", "size": 0.5)";
    const auto first = scene(keys, 32).objects[0].solid, second = scene(keys, 32).objects[0].solid;
    EXPECT_EQ(first, second);
    write_whole(path("vase.obj"), vase(36));
    EXPECT_NE(scene(keys, 32).objects[0].solid, first);
}

// Added by a line of a script, undone, redone, scaled, saved and opened again: the document keeps
// its file, and a replay makes the same clay.
TEST_F(MeshObject, GoesThroughASession)
{
    write_whole(path("vase.obj"), vase(32));
    write_whole(path("scene.json"), R"({"schema": "knead.scene/1", "frame_rate": 60,
        "domain": {"edge": 1, "cells": 24}, "surface": {"nodes": 32}, "objects": []})");
    LiveOptions options;
    options.make_solver = [](const knead::Setup& setup) { return cpu_solver(setup); };
    options.stepped = true, options.recorded = false, options.protects = true;
    const CommandLog log = parse_command_log(
        R"({"frame": 0, "add_object": {"object": {"shape": "mesh", "file": "vase.obj", "up": "z", )"
        R"("size": 0.4, "hollow": 0, "centre": [0.5, 0.3, 0.5], "name": "vase"}}})",
        path("script.commands"), folder.string());
    ASSERT_EQ(log.commands.size(), 1u);
    const std::string saved = path("saved.knead");
    std::size_t particles = 0;
    std::string text;
    {
        LiveSession session(load_live_scene(path("scene.json")), options);
        const auto apply = [&](Command command) {
            session.send(std::move(command));
            session.wait_for_commands();
            EXPECT_EQ(session.state()->refusal, "");
            return session.state();
        };
        auto state = apply(log.commands[0].command);
        ASSERT_EQ(state->document->objects.size(), 1u);
        const SceneObject added = *state->document->objects[0];
        EXPECT_EQ(added.source.mesh.file, path("vase.obj"));
        EXPECT_NEAR(own_extents(added).y, 0.4, 1e-9);
        particles = session.digest().particles;
        EXPECT_GT(particles, 1000u);
        EXPECT_TRUE(apply(Undo{})->document->objects.empty());
        state = apply(Redo{});
        EXPECT_TRUE(equal(*state->document->objects.at(0), added));
        session.advance_to(0.1);
        ScaleObjects smaller;
        smaller.objects = {added.id}, smaller.factor = 0.5;
        state = apply(smaller);
        EXPECT_NEAR(own_extents(*state->document->objects[0]).y, 0.2, 1e-9);
        apply(Undo{});
        apply(Save{saved, {}});
        for (int i = 0; i < 10000 && session.state()->saved_as != saved; ++i) apply(Pause{true});
        text = document_text(*session.state()->document);
        EXPECT_EQ(session.state()->failure, "");
        // Walls hold what is known of it.
        PlaceObject away;
        away.object = added.id, away.centre = Vec3<double>{0.95, 0.5, 0.5};
        session.send(away), session.wait_for_commands();
        EXPECT_NE(session.state()->refusal.find("between the walls"), std::string::npos);
    }
    const SessionFile file(saved);
    ReplayOptions by;
    by.make_solver = options.make_solver, by.stepped = true;
    by.stored_state = [&](std::uint64_t id) { return file.state(id); };
    by.read_history = [&](History& past) { file.read_history(past, 0); };
    SessionReplay replay(live_scene_of(file.scene()), by);
    file.each_event([&](const SessionEvent& event) { return replay.add(event); });
    EXPECT_EQ(replay.frames(), file.frames());
    LiveSession again(load_live_scene(path("scene.json")), options);
    again.send(Open{saved, {}, {}});
    again.wait_for_commands();
    EXPECT_EQ(again.state()->refusal, "");
    EXPECT_EQ(document_text(*again.state()->document), text);
    EXPECT_EQ(again.digest().particles, particles);
}

}  // namespace
}  // namespace knead
