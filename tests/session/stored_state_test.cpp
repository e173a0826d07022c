// Stored states: a run that goes on from one has the bits of one that was not interrupted, each
// number is kept, and damaged bytes are refused.
#include "host/session/stored_state.h"

#include <gtest/gtest.h>
#include <xxhash.h>

#include <cstring>
#include <fstream>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "host/assets/procedural_object.h"
#include "host/document/document_text.h"
#include "host/files/splat_file.h"
#include "host/scene/presets.h"
#include "host/scene/scene_hands.h"
#include "host/scene/seed.h"
#include "host/session/scene_editor.h"
#include "tests/document/random.h"
#include "tests/folder.h"
#include "tests/reason.h"
#include "tests/sanitized.h"
#include "tests/session/filled_state.h"
#include "tests/solver/same_bits.h"

namespace knead {
namespace {

// A ball that is squeezed, a pot of splats that falls, and two objects that rest.
class StoredRun : public InFolder {
  protected:
    void SetUp() override
    {
        write_splats(path("pot.ply"), glazed_pot(1000));
        std::ofstream(path("scene.json")) << R"({"schema": "knead.scene/1",
            "domain": {"edge": 0.64, "cells": 16}, "gravity": [0, -9.81, 0], "frame_rate": 30,
            "objects": [
              {"name": "ball", "centre": [0.32, 0.1, 0.32], "diameter": 0.1},
              {"name": "pot", "shape": "splats", "file": "pot.ply", "size": 0.14, "category": 2,
               "centre": [0.17, 0.25, 0.45], "velocity": [0, -3, 0], "material": "soft-clay"},
              {"name": "block", "shape": "box", "centre": [0.46, 0.065, 0.46],
               "size": [0.1, 0.07, 0.1]},
              {"name": "drum", "shape": "cylinder", "centre": [0.46, 0.07, 0.17],
               "diameter": 0.08, "height": 0.08, "material": "snow", "category": 3}],
            "rest": {"mode": "sleep", "frames": 2},
            "splats": {"every": 3, "split": {"limit": 1.2, "budget": 50},
                       "refill": {"see_through": 0.05, "budget": 20}},
            "hands": {"recording": "squeeze", "at": [0.32, 0.1, 0.32], "zoom": 0.6}})";
    }

    struct Run {
        explicit Run(const std::string& file, int before = 0)
            : scene(read_scene(file)),
              objects(load_splats(scene, std::size_t(1) << 30)),
              frames(before)
        {
            build(scene, std::size_t(1) << 30);
            scene.setup.threads = 1;
            solver = cpu_solver(scene.setup);
            splats = std::make_unique<SceneSplats>(scene, objects);
            source = std::make_unique<HandSource>(hands_of(scene), scene.hands);
            SessionLoopOptions options = loop_options(scene);
            options.frames_before = before;
            loop = std::make_unique<SessionLoop>(
                *solver, recorded_motion(source.get(), scene.hands), options);
            loop->observe([this](const FrameResult& f) {
                splats->after(f.number, f.motion, *solver);
                ++frames;
            });
            editor = std::make_unique<SceneEditor>(
                SceneEditor::Parts{scene,
                                   *splats,
                                   *loop,
                                   solver.get(),
                                   [this](const HandsOptions& to) { hold(to); },
                                   {}},
                std::make_shared<const Document>(document_of(scene)), ids);
        }
        void hold(const HandsOptions& to)
        {
            const HandTools made = hand_tools(to);
            solver->set_tools(made.rig, made.tools);
        }
        void apply(const Command& command)
        {
            const CommandAnswer answer = editor->apply(command);
            ASSERT_FALSE(answer.refusal) << answer.refusal->text();
        }
        void step(int count)
        {
            for (; count > 0; --count) ASSERT_TRUE(loop->step());
        }
        StoredState stored() const
        {
            return {solver->save(),
                    splats->state(),
                    splats->local_state(),
                    editor->document(),
                    editor->numbers(),
                    ids.most(),
                    frames,
                    double(frames) / 30};
        }
        // Goes on from a state of the same scene.
        void load(const StoredState& from)
        {
            hold(hands_with(scene.hands, *from.document->hands, scene.origin));
            SavedState state = from.state;
            state.config = solver->config();
            state.config.materials = from.numbers.materials;
            state.config.gravity = from.document->scene->gravity;
            state.config.walls = from.document->scene->walls;
            state.config.walls.min = state.config.walls.min - scene.origin;
            state.config.walls.max = state.config.walls.max - scene.origin;
            splats->set_state(from.splats, from.local);
            solver->load(state);
        }

        Scene scene;
        std::vector<SplatObject> objects;
        long frames;
        std::unique_ptr<EditableSimulator> solver;
        std::unique_ptr<SceneSplats> splats;
        std::unique_ptr<HandSource> source;
        std::unique_ptr<SessionLoop> loop;
        IdSource ids;
        std::unique_ptr<SceneEditor> editor;
    };
    static void expect_same(const Run& a, const Run& b)
    {
        EXPECT_TRUE(same_bits(a.solver->particles(), b.solver->particles()));
        EXPECT_TRUE(same_bits(a.solver->gaussians(), b.solver->gaussians()));
        EXPECT_TRUE(same_bits(a.splats->state().cloud.centre, b.splats->state().cloud.centre));
        EXPECT_TRUE(same_bits(a.splats->state().cloud.scale, b.splats->state().cloud.scale));
        EXPECT_TRUE(same_bits(a.splats->state().cloud.sh, b.splats->state().cloud.sh));
        EXPECT_TRUE(same_bits(a.splats->state().extent, b.splats->state().extent));
        EXPECT_EQ(a.solver->config().materials, b.solver->config().materials);
        const FrameStats &x = a.loop->last().stats, &y = b.loop->last().stats;
        EXPECT_EQ(x.substeps, y.substeps);
        EXPECT_EQ(x[Count::projected], y[Count::projected]);
    }
};

SceneObject box(const char* name, Vec3<double> at)
{
    SceneObject o;
    o.name = name, o.material = material_spec("dough");
    o.source.shape = ShapeKind::box, o.source.size = {0.07, 0.07, 0.07};
    o.pose.p = at;
    return o;
}

TEST_F(StoredRun, GoesOnWithTheBitsOfOneThatWasNotInterrupted)
{
    Run whole(path("scene.json"));
    long projected = 0;
    const auto goes_on = [&](int frames) {
        const StoredState before = whole.stored();
        const std::string bytes = to_bytes(before);
        Run resumed(path("scene.json"), int(whole.frames));
        const StoredState read = state_from(bytes, "x");
        EXPECT_TRUE(to_bytes(read) == bytes);
        EXPECT_TRUE(equal(*read.document, *before.document));
        EXPECT_EQ(hash(*read.document), hash(*before.document));
        EXPECT_EQ(read.numbers.number, before.numbers.number);
        EXPECT_EQ(read.numbers.materials, before.numbers.materials);
        EXPECT_EQ(read.ids_used, before.ids_used);
        EXPECT_EQ(read.frames, whole.frames);
        EXPECT_EQ(read.time, before.time);
        resumed.load(read);
        for (; frames > 0; --frames) {
            SCOPED_TRACE(whole.frames);
            whole.step(1), resumed.step(1);
            expect_same(whole, resumed);
            projected += whole.loop->last().stats[Count::projected];
        }
    };
    goes_on(2);
    whole.apply(RemoveObjects{{ObjectRef("block")}});
    whole.apply(AddObject{box("late", {0.5, 0.3, 0.15})});
    whole.apply(SetHands{{{}, "rod"}, {}, {}, {}});
    goes_on(sanitized ? 2 : 8);
    whole.apply(SetMaterial{ObjectRef("ball"), material_spec("plasticine")});
    whole.apply(AddObject{box("later", {0.15, 0.4, 0.15})});
    whole.apply(RemoveObjects{{ObjectRef("late")}});
    whole.apply(SetWalls{{}, {}, ContactMode::separate, 0.2});
    whole.apply(SetGravity{{0, -8, 0.5}});
    goes_on(sanitized ? 2 : 14);
    whole.apply(PlaceObject{ObjectRef("drum"), Vec3<double>{0.46, 0.1, 0.2}, {}});
    goes_on(sanitized ? 2 : 14);
    // All that a state is made of was there.
    const StoredState last = whole.stored();
    EXPECT_EQ(last.numbers.materials.size(), 6u);
    EXPECT_EQ(last.numbers.number.size(), 4u);
    EXPECT_EQ(last.ids_used, 6u);
    EXPECT_GT(last.splats.count(), whole.scene.setup.gaussians.size()) << "some were split";
    EXPECT_EQ(last.splats.count(), last.state.contents.gaussians.size());
    EXPECT_TRUE(std::ranges::any_of(last.state.quiet, [](int frames) { return frames > 1; }));
    EXPECT_GT(projected, 0) << "hands pressed clay";
}

// Each number another one.
StoredState filled()
{
    Next next;
    StoredState s;
    fill_state(s, next);
    Random r(7);
    IdSource ids(40);
    DocumentPtr d = empty_room();
    for (const char* name : {"a", "b", "\"ä\""}) {
        SceneObject o = random_object(r, {0, d.get()});
        o.id = {}, o.name = name, o.locked = name[0] == 'b';
        d = after(d, AddObject{o}, ids);
    }
    SceneObject pot = box("pot", {0.4, 0.5, 0.6});
    pot.source = {
        ShapeKind::splats, {}, {0, -0.0, 1}, 8, {"a/../pot.ply", UpAxis::z, 0.3, 4, 0}, 0, {}};
    pot.category = 9;
    d = after(d, AddObject{pot}, ids);
    s.document = d;
    s.numbers.materials.resize(7);
    for (std::size_t i = 0; i < 7; ++i) {
        if (i == 2) continue;  // removed
        Material<double>& m = s.numbers.materials[i];
        m.elasticity = elasticities[i % 3].second, m.plasticity = plasticities[i % 6].second;
        next.all(m.density, m.mu, m.lambda, m.bulk, m.yield, m.hardening, m.yield_floor, m.friction,
                 m.cohesion, m.compress, m.stretch, m.snow, m.viscosity, m.exponent, m.mass,
                 m.volume);
        m.category = int(250 + i % 6);
        m.mu = 1 / m.mu, m.bulk = -0.0, m.lambda = std::numeric_limits<double>::denorm_min();
    }
    s.numbers.number = {{{41}, {6}}, {{42}, {0, 1}}, {{43}, {3}}, {{44}, {5}}};
    s.ids_used = 50, s.frames = 123456789012, s.time = 1 / 3.0;
    return s;
}

bool same_numbers(const ObjectNumbers& a, const ObjectNumbers& b)
{
    // -0 and 0 differ in text.
    return a.number == b.number && a.materials == b.materials &&
           json_of(a).dump() == json_of(b).dump();
}

TEST(StoredState, HoldsEachNumber)
{
    const StoredState wrote = filled();
    ASSERT_EQ(wrote.document->objects.size(), 4u);
    const std::string bytes = to_bytes(wrote);
    const StoredState read = state_from(bytes, "x");
    EXPECT_TRUE(to_bytes(read) == bytes);
    EXPECT_TRUE(equal(*read.document, *wrote.document)) << document_text(*read.document);
    EXPECT_TRUE(same_numbers(read.numbers, wrote.numbers));
    EXPECT_TRUE(std::signbit(read.numbers.materials[0].bulk));
    EXPECT_EQ(read.ids_used, wrote.ids_used);
    EXPECT_EQ(read.frames, wrote.frames);
    EXPECT_EQ(read.time, wrote.time);
    EXPECT_TRUE(same_bits(read.state.contents.particles, wrote.state.contents.particles));
    EXPECT_TRUE(same_bits(read.state.contents.gaussians, wrote.state.contents.gaussians));
    EXPECT_EQ(read.state.order, wrote.state.order);
    EXPECT_EQ(read.state.quiet, wrote.state.quiet);
    EXPECT_EQ(read.state.quiet_low, wrote.state.quiet_low);
    EXPECT_EQ(read.state.quiet_stored, wrote.state.quiet_stored);
    EXPECT_TRUE(same_bits(read.state.sliding, wrote.state.sliding));
    EXPECT_EQ(read.state.speed_squared, wrote.state.speed_squared);
    EXPECT_EQ(read.state.stiffness, wrote.state.stiffness);
    EXPECT_EQ(read.state.drift, wrote.state.drift);
    EXPECT_EQ(read.state.covered, wrote.state.covered);
    EXPECT_EQ(read.splats.cloud.degree, 1);
    EXPECT_TRUE(read.splats.cloud.antialiased);
    EXPECT_TRUE(same_bits(read.splats.cloud.sh, wrote.splats.cloud.sh));
    EXPECT_EQ(read.splats.extent, wrote.splats.extent);
    EXPECT_TRUE(same_bits(read.local.cloud.centre, wrote.local.cloud.centre));
    EXPECT_TRUE(same_bits(read.local.cloud.sh, wrote.local.cloud.sh));
    EXPECT_TRUE(read.local.cloud.antialiased);
    EXPECT_EQ(read.local.active, wrote.local.active);
    EXPECT_TRUE(same_bits(read.local.normal, wrote.local.normal));
    EXPECT_EQ(read.local.slot_of, wrote.local.slot_of);
    EXPECT_EQ(read.local.clay, wrote.local.clay);
    EXPECT_EQ(read.local.objects, wrote.local.objects);
    // An empty one.
    StoredState empty;
    empty.document = empty_room();
    EXPECT_TRUE(to_bytes(state_from(to_bytes(empty), "x")) == to_bytes(empty));
}

TEST(StoredState, NumbersOfObjectsReadAsTheyWereWritten)
{
    const ObjectNumbers wrote = filled().numbers;
    const Json json = json_of(wrote);
    EXPECT_TRUE(same_numbers(numbers_in(json, "x"), wrote));
    EXPECT_TRUE(same_numbers(numbers_in(parse_json(json.dump(), "x"), "x"), wrote));
    EXPECT_TRUE(same_numbers(numbers_in(Json::from_cbor(Json::to_cbor(json)), "x"), wrote));
    const std::pair<const char*, Json> all[] = {
        {"/materials", 7},
        {"/materials/1", 7},
        {"/materials/1/density", "7"},
        {"/materials/1/density", std::numeric_limits<double>::infinity()},
        {"/materials/1/density", std::nan("")},
        {"/materials/1/elasticity", 0},
        {"/materials/1/elasticity", "soft"},
        {"/materials/1/plasticity", "soft"},
        {"/materials/1/category", 256},
        {"/materials/1/category", 1.5},
        {"/materials/1/colour", 1},
        {"/objects", nullptr},
        {"/objects", Json::array({7})},
        {"/objects", Json::array({Json::array()})},
        {"/objects", Json::array({Json::array({1, 2, 2})})},
        {"/objects", Json::array({Json::array({0, 2})})},
        {"/objects", Json::array({Json::array({2147483648u, 2})})},
        {"/objects", Json::array({Json::array({1, 7})})},
        {"/objects", Json::array({Json::array({1, -1})})},
        {"/objects", Json::array({Json::array({1, 1.5})})},
        {"/objects", Json::array({Json::array({1, 2}), Json::array({1, 3})})},
        {"/objects", Json::array({Json::array({1, 2}), Json::array({2, 2})})},
        {"/colour", 1}};
    for (const auto& [pointer, value] : all) {
        Json bad = json;
        bad[Json::json_pointer(pointer)] = value;
        const std::string why = reason<InputError>([&] { numbers_in(bad, "x"); });
        EXPECT_EQ(why.find("x: " + std::string(pointer)), 0u) << value << ": " << why;
    }
    for (const auto& [key, value] : json["materials"][1].items()) {
        Json bad = json;
        bad["materials"][1].erase(key);
        const std::string why = reason<InputError>([&] { numbers_in(bad, "x"); });
        EXPECT_EQ(why.find("x: /materials/1/" + key + ": expected"), 0u) << why;
    }
    EXPECT_NE(reason<InputError>([&] { numbers_in(Json::array(), "x"); }), "");
}

// With the checksum of its other bytes in the last eight.
std::string summed(std::string bytes)
{
    const std::uint64_t sum = XXH64(bytes.data(), bytes.size() - 8, 0);
    std::memcpy(bytes.data() + bytes.size() - 8, &sum, 8);
    return bytes;
}
std::size_t facts_length(const std::string& bytes)
{
    std::uint64_t length;
    std::memcpy(&length, bytes.data(), 8);
    return length;
}
Json facts_of(const std::string& bytes)
{
    return Json::from_cbor(bytes.begin() + 8, bytes.begin() + 8 + long(facts_length(bytes)));
}
std::string body_of(const std::string& bytes)
{
    return bytes.substr(8 + facts_length(bytes), bytes.size() - 16 - facts_length(bytes));
}
std::string with_facts(const std::string& bytes, const std::string& facts)
{
    const std::uint64_t length = facts.size();
    std::string all(reinterpret_cast<const char*>(&length), 8);
    return summed(all + facts + bytes.substr(8 + facts_length(bytes)));
}
std::string with_facts(const std::string& bytes, const Json& facts)
{
    std::string text;
    Json::to_cbor(facts, text);
    return with_facts(bytes, text);
}
std::string refused(const std::string& bytes)
{
    return reason<InputError>([&] { state_from(bytes, "x"); });
}

TEST(StoredState, CutOrFlippedBytesAreRefused)
{
    const std::string bytes = to_bytes(filled());
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        ASSERT_EQ(refused(bytes.substr(0, size)).find("x: "), 0u) << size;
        if (size > 8) {
            ASSERT_EQ(refused(summed(bytes.substr(0, size))).find("x: "), 0u) << size;
        }
    }
    EXPECT_NE(refused(bytes + "x"), "");
    EXPECT_NE(refused(summed(bytes + "x")), "");
    const int bits = sanitized ? 1 : 2;
    long accepted = 0;
    for (std::size_t at = 0; at < bytes.size(); ++at)
        for (int bit = 0; bit < bits; ++bit) {
            std::string other = bytes;
            other[at] = char(other[at] ^ 1 << (bit + int(at)) % 8);
            ASSERT_NE(refused(other), "") << at;
            if (at + 8 >= bytes.size()) continue;
            // With a right sum: one that could have been written. CBOR has several forms of a
            // number.
            other = summed(other);
            try {
                const std::string again = to_bytes(state_from(other, "x"));
                ASSERT_TRUE(facts_of(again) == facts_of(other)) << at;
                ASSERT_TRUE(body_of(again) == body_of(other)) << at;
                ++accepted;
            } catch (const InputError& e) {
                ASSERT_EQ(std::string(e.what()).find("x: "), 0u) << at << ": " << e.what();
                ASSERT_LT(std::string(e.what()).size(), 500u);
            }
        }
    EXPECT_GT(accepted, 500) << "numbers of the arrays";
}

TEST(StoredState, FactsThatAreNotItsOwnAreRefused)
{
    const std::string bytes = to_bytes(filled());
    const Json good = facts_of(bytes);
    ASSERT_TRUE(with_facts(bytes, good) == bytes);
    for (const auto& [key, value] : good.items()) {
        Json bad = good;
        bad.erase(key);
        EXPECT_NE(refused(with_facts(bytes, bad)), "") << key << " lacks";
        const Json others[] = {nullptr,
                               true,
                               -1,
                               0.5,
                               9e18,
                               18446744073709551615u,
                               4611686018427387904,
                               2147483648u,
                               "x",
                               Json::array(),
                               Json::object()};
        for (const Json& other : others) {
            // Numbers that may have such values.
            if (other.type() == value.type() || (key == "objects" && other == -1) ||
                (value.is_number_float() && other.is_number()))
                continue;
            bad = good, bad[key] = other;
            EXPECT_EQ(refused(with_facts(bytes, bad)).find("x: "), 0u) << key << " " << other;
        }
    }
    Json bad = good;
    bad["more"] = 1;
    EXPECT_NE(refused(with_facts(bytes, bad)), "");
    // Lengths of the arrays: huge ones, and those that only together are of the right size.
    for (const char* key :
         {"particles", "quiet", "sliding", "gaussians", "splats", "still", "home"})
        for (const std::uint64_t more :
             {std::uint64_t(1), std::uint64_t(1) << 31, std::uint64_t(1) << 61,
              std::uint64_t(1) << 63, ~std::uint64_t(0)}) {
            bad = good, bad[key] = bad[key].get<std::uint64_t>() + more;
            EXPECT_NE(refused(with_facts(bytes, bad)), "") << key << more;
        }
    bad = good, bad["home"] = 6, bad["quiet"] = 3;
    EXPECT_EQ(refused(with_facts(bytes, bad)), "") << "as many bytes";
    bad = good, bad["document"] = good["document"].get<std::string>() + " ";
    EXPECT_NE(refused(with_facts(bytes, bad)), "") << "not canonical";
    bad = good, bad["numbers"]["objects"].erase(1);
    EXPECT_EQ(refused(with_facts(bytes, bad)).find("x: expected the numbers"), 0u);
    bad = good, bad["numbers"]["objects"][1][0] = 7;
    EXPECT_EQ(refused(with_facts(bytes, bad)).find("x: expected the numbers"), 0u);
    bad = good, bad["ids_used"] = 43;
    EXPECT_EQ(refused(with_facts(bytes, bad)).find("x: /ids_used: expected"), 0u);
    bad = good, bad["clay"] = Json::array({Json::array({1, 2, 3})});
    EXPECT_NE(refused(with_facts(bytes, bad)), "");
    for (const std::string& hostile :
         {std::string(), std::string("\x80"), std::string(100000, '\x81'),
          std::string("\x9b\x7f\xff\xff\xff\xff\xff\xff\xff"), std::string(100000, '\x9f'),
          std::string("\x5b\x7f\xff\xff\xff\xff\xff\xff\xff"), std::string("\xa0")})
        EXPECT_EQ(refused(with_facts(bytes, hostile)).find("x: "), 0u);
    // Splats with numbers that are not finite.
    StoredState s = filled();
    s.splats.cloud.scale[1].y = std::numeric_limits<float>::infinity();
    EXPECT_NE(refused(to_bytes(s)).find("splats"), std::string::npos);
    s = filled(), s.splats.cloud = picked(s.splats.cloud, {0}), s.splats.extent.pop_back();
    EXPECT_NE(refused(to_bytes(s)).find("1 splats"), std::string::npos);
}

}  // namespace
}  // namespace knead
