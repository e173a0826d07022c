// Objects that are cut or torn become several: when, once, in the hands' step, and the same again
// when a session is replayed.
#include "host/session/piece_watch.h"

#include <gtest/gtest.h>

#include "host/hands/motion.h"
#include "host/scene/presets.h"
#include "host/scene/scene_hands.h"
#include "host/scene/seed.h"
#include "host/session/scene_history.h"
#include "tests/session/clay_rows.h"
#include "tests/solver/back_ends.h"
#include "tests/solver/same_bits.h"

namespace knead {
namespace {

// A knife cuts a block in two; the lower one lies below it.
constexpr const char* cut_scene = R"({"schema": "knead.scene/1",
    "domain": {"edge": 1.0, "cells": 24}, "walls": {"min": [0.0625, 0.0625, 0.0625],
    "max": [0.9375, 0.9375, 0.9375], "contact_mode": "separate", "friction": 0.5},
    "objects": [{"name": "ball", "centre": [0.5, 0.2625, 0.5], "diameter": 0.4,
                 "material": "clay"}],
    "hands": {"recording": "cut", "zoom": 4, "left": {"present": false}},
    "contact": {"categories": "separate", "pieces": true}, "frame_rate": 60})";

class Session {
  public:
    Session(Scene of, bool on_gpu, std::vector<SessionEvent>* log = nullptr)
        : scene(std::move(of)),
          hands(std::make_unique<HandSource>(hands_of(scene), scene.hands)),
          solver(made(scene, on_gpu)),
          splats(scene, {}),
          loop(*solver, recorded_motion(hands.get(), scene.hands), loop_options(scene)),
          editor({scene, splats, loop, solver.get(), [](const HandsOptions&) {}, {}},
                 std::make_shared<const Document>(document_of(scene)), ids),
          history({scene, splats, loop, solver.get(), editor, past,
                   [log](const SessionEvent& event) {
                       if (log) log->push_back(event);
                   }},
                  "Open")
    {
    }
    // Returns the frames after which objects were split.
    std::vector<int> frames(int count)
    {
        std::vector<int> split;
        for (int i = 0; i < count; ++i) {
            if (!loop.step()) break;
            editor.after_frame(loop.last());
            if (history.after_frame(loop.last())) split.push_back(loop.last().number);
        }
        return split;
    }
    std::size_t objects() const { return editor.document()->objects.size(); }
    std::size_t clay_of(ObjectId id) const
    {
        std::size_t count = 0;
        const std::vector<int>& numbers = editor.simulated(id);
        for (const auto& p : solver->particles())
            count += std::size_t(std::ranges::count(numbers, p.object));
        return count;
    }

    Scene scene;
    std::unique_ptr<HandSource> hands;
    std::unique_ptr<EditableSimulator> solver;
    SceneSplats splats;
    SessionLoop loop;
    IdSource ids;
    SceneEditor editor;
    History past;
    SceneHistory history;

  private:
    static std::unique_ptr<EditableSimulator> made(Scene& scene, bool on_gpu)
    {
        build(scene, std::size_t(1) << 30);
        scene.setup.deterministic = true, scene.setup.threads = 2;
        return on_gpu ? gpu_solver(scene.setup, 0) : cpu_solver(scene.setup);
    }
};

class Parted : public OnBothDevices {
  protected:
    static Session begun(std::vector<SessionEvent>* log = nullptr,
                         const std::vector<std::string>& settings = {})
    {
        return {parse_scene(cut_scene, "scenes/cut.json", settings), GetParam(), log};
    }
};
INSTANTIATE_TEST_SUITE_P(Session, Parted, testing::Values(false, true), device_of);

constexpr int all_frames = 260;  // frames, more than the gesture has

TEST_P(Parted, AKnifeMakesTwoObjectsInTheStepOfTheHands)
{
    std::vector<SessionEvent> log;
    Session s = begun(&log);
    const std::size_t all = s.solver->particle_count();
    const std::vector<int> split = s.frames(all_frames);
    ASSERT_EQ(split.size(), 1u);
    ASSERT_EQ(s.objects(), 2u);
    EXPECT_EQ(s.clay_of({1}) + s.clay_of({2}), all);
    EXPECT_GE(s.clay_of({1}), s.clay_of({2}));
    EXPECT_GT(s.clay_of({2}), all / 3);
    const auto& objects = s.editor.document()->objects;
    EXPECT_EQ(objects[0]->name, "ball");
    EXPECT_EQ(objects[1]->name, "ball 2");
    EXPECT_EQ(objects[0]->category, 0);
    EXPECT_EQ(objects[1]->category, 1);
    for (const ObjectId id : {ObjectId{1}, ObjectId{2}})
        for (const int number : s.editor.simulated(id))
            EXPECT_EQ(s.solver->config().materials[std::size_t(number)].category,
                      int(id.value) - 1);
    // Logged as a command, with all that a replay needs; no step of its own.
    long commands = 0, steps = 0;
    for (const SessionEvent& event : log) {
        if (const auto* command = std::get_if<CommandEvent>(&event)) {
            const auto* as = std::get_if<SplitObject>(&command->issued.command);
            ASSERT_TRUE(as);
            EXPECT_EQ(as->ids.size(), 2u);
            EXPECT_EQ(as->categories.size(), 2u);
            ++commands;
        }
        if (const auto* begun = std::get_if<StepBegun>(&event)) {
            EXPECT_EQ(begun->label, "Press");
            ++steps;
        }
    }
    EXPECT_EQ(commands, 1);
    EXPECT_GE(steps, 1);
    // Undone with what the hands did, and not split again.
    while (s.objects() > 1) {
        ASSERT_TRUE(s.past.undo());
        ASSERT_FALSE(s.history.apply({Undo{}, 0, Origin::script, 0}).refusal);
    }
    EXPECT_EQ(s.solver->particle_count(), all);
    EXPECT_EQ(s.frames(30).size(), 0u);
    EXPECT_EQ(s.objects(), 1u);
    while (s.past.redo()) ASSERT_FALSE(s.history.apply({Redo{}, 0, Origin::script, 0}).refusal);
    EXPECT_EQ(s.objects(), 2u);
    EXPECT_GT(s.clay_of({2}), all / 3);
}

TEST_P(Parted, AtTheSameFrameWithTheSameBitsAgain)
{
    Session one = begun(), other = begun();
    EXPECT_EQ(one.frames(all_frames), other.frames(all_frames));
    EXPECT_TRUE(
        same_bits(one.solver->save().contents.particles, other.solver->save().contents.particles));
}

TEST_P(Parted, OnlyWhereTheSceneSaysSo)
{
    Session s = begun(nullptr, {"contact.pieces=false"});
    EXPECT_EQ(s.frames(all_frames).size(), 0u);
    EXPECT_EQ(s.objects(), 1u);
}

// Clay torn in two, without a blade: so many looks after it came apart. A refusal is not repeated.
TEST_P(Parted, ATornObjectIsFoundWithinATenthOfASecond)
{
    Scene scene = parse_scene(R"({"schema": "knead.scene/1",
        "domain": {"edge": 0.96, "cells": 32}, "gravity": [0, 0, 0], "frame_rate": 90,
        "objects": [{"name": "a", "centre": [0.3, 0.3, 0.3], "diameter": 0.16},
            {"name": "b", "centre": [0.52, 0.3, 0.3], "diameter": 0.16},
            {"name": "c", "centre": [0.3, 0.3, 0.7], "diameter": 0.16}],
        "hands": {"recording": "cut", "zoom": 4, "left": {"present": false}},
        "contact": {"pieces": true}})",
                              "scenes/torn.json");
    Session s(std::move(scene), GetParam());
    const auto merged =
        s.history.apply({MergeObjects{{ObjectId{1}, ObjectId{2}}, {}}, 0, Origin::script, 0});
    ASSERT_FALSE(merged.refusal);
    PieceWatch watch(s.scene);
    const FrameResult frame;
    EXPECT_EQ(watch.after_frame(frame, false, s.editor, *s.solver).size(), 0u);
    int looks = 0;
    std::vector<ObjectId> found;
    while (found.empty() && looks < 100)
        found = watch.after_frame(frame, true, s.editor, *s.solver), ++looks;
    EXPECT_EQ(found, std::vector<ObjectId>{ObjectId{1}});
    EXPECT_GE(looks, 5);
    EXPECT_LE(looks, 9);  // 0.1 s of frames
    watch.refused({1});
    for (int i = 0; i < 20; ++i)
        EXPECT_EQ(watch.after_frame(frame, true, s.editor, *s.solver).size(), 0u);
    watch.restored();
    for (int i = 0; i < 20; ++i)
        EXPECT_EQ(watch.after_frame(frame, false, s.editor, *s.solver).size(), 0u);
}

// The fast count is that of the command: blocks that are apart, touch at a corner, are cut.
TEST_P(Parted, PiecesAreCountedAsTheyAreSplit)
{
    decltype(Scene::setup) setup;
    setup.lattice = {{32, 32, 32}, 1.0 / 32};
    setup.walls = walls_inside(setup.lattice, 2, ContactMode::slip, 0);
    const double dx = setup.lattice.dx, h = dx / 2;
    Material<double> m = preset("clay");
    m.volume = h * h * h, m.mass = m.density * m.volume;
    setup.materials = {m, m, m, m};
    const auto block = [&](int object, Int3 from, Int3 size, std::uint32_t sides = uncut) {
        for (int z = 0; z < 2 * size.z; ++z)
            for (int y = 0; y < 2 * size.y; ++y)
                for (int x = 0; x < 2 * size.x; ++x) {
                    Particle<double> q{};
                    q.x = dx * Vec3<double>{from.x + (x + 0.5) / 2, from.y + (y + 0.5) / 2,
                                            from.z + (z + 0.5) / 2};
                    q.object = object, q.sides = sides;
                    setup.particles.push_back(q);
                }
    };
    block(0, {4, 4, 4}, {4, 4, 4}), block(0, {9, 4, 4}, {4, 4, 4});    // a cell apart: two
    block(0, {9, 4, 9}, {1, 1, 1});                                    // dust
    block(1, {4, 12, 4}, {4, 4, 4}), block(1, {8, 16, 8}, {3, 3, 3});  // touch at a corner: one
    block(2, {16, 4, 16}, {4, 4, 4}, above), block(2, {20, 4, 16}, {4, 4, 4}, below);  // cut
    block(3, {16, 12, 16}, {4, 4, 4}, above), block(3, {20, 12, 16}, {4, 4, 4}, below);
    block(3, {16, 12, 20}, {8, 4, 3});  // a hinge
    setup.cuts = true;
    const auto solver = GetParam() ? gpu_solver(setup, 0) : cpu_solver(setup);
    const std::vector<int> group = {0, 1, 2, 3};
    EXPECT_EQ(solver->piece_counts(group, 4), (std::vector<int>{2, 1, 2, 1}));
    const std::vector<int> merged = {0, -1, 1, 0};
    EXPECT_EQ(solver->piece_counts(merged, 2), (std::vector<int>{3, 2}));
    for (int object = 0; object < 4; ++object) {
        PartClay part{m, {}};
        for (const auto& q : setup.particles)
            if (q.object == object) part.particles.push_back(q);
        EXPECT_EQ(connected_pieces({part}, setup.lattice).count,
                  solver->piece_counts(group, 4)[std::size_t(object)]);
    }
}

}  // namespace
}  // namespace knead
