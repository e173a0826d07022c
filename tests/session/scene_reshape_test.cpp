// Copy, move, reset, scale, merge and split of objects in a running scene: what they do to clay,
// splats and document, what is refused, and undo and redo to the bit.
#include <gtest/gtest.h>

#include <fstream>

#include "host/assets/procedural_object.h"
#include "host/files/splat_file.h"
#include "host/hands/motion.h"
#include "host/scene/seed.h"
#include "host/session/scene_history.h"
#include "host/solver/audit.h"
#include "tests/document/random.h"
#include "tests/folder.h"
#include "tests/sanitized.h"
#include "tests/session/clay_rows.h"
#include "tests/solver/back_ends.h"
#include "tests/solver/same_bits.h"

namespace knead {
namespace {

constexpr const char* three = R"({"name": "ball", "centre": [0.3, 0.3, 0.3], "diameter": 0.16},
    {"name": "block", "shape": "box", "centre": [0.6, 0.2, 0.6], "size": [0.2, 0.1, 0.1],
     "material": "dough", "category": 3},
    {"name": "drum", "shape": "cylinder", "centre": [0.3, 0.3, 0.6], "diameter": 0.1,
     "height": 0.1, "material": "snow"})";

// A scene with its history; each command is a step.
class Reshaped {
  public:
    Reshaped(Scene of, bool on_gpu)
        : scene(std::move(of)),
          splat_objects(load_splats(scene, std::size_t(1) << 30)),
          solver(made(scene, on_gpu)),
          splats(scene, splat_objects),
          loop(*solver, recorded_motion(nullptr, scene.hands), loop_options(scene)),
          editor({scene, splats, loop, solver.get(), [](const HandsOptions&) {}, {}},
                 std::make_shared<const Document>(document_of(scene)), ids),
          history({scene, splats, loop, solver.get(), editor, past}, "Open")
    {
    }
    CommandAnswer apply(const Command& command)
    {
        return history.apply({command, 0, Origin::script, 0});
    }
    // Applied, or a failure.
    Command applied(const Command& command)
    {
        const CommandAnswer answer = apply(command);
        if (answer.refusal) ADD_FAILURE() << answer.refusal->text();
        return answer.applied;
    }
    void refused(const Command& command, const std::string& field, const std::string& words)
    {
        const SavedState before = solver->save();
        const DocumentPtr document = editor.document();
        const CommandAnswer answer = apply(command);
        ASSERT_TRUE(answer.refusal) << row_of(command).name << " " << words;
        EXPECT_EQ(answer.refusal->field, field) << answer.refusal->why;
        EXPECT_NE(answer.refusal->why.find(words), std::string::npos) << answer.refusal->why;
        EXPECT_EQ(editor.document(), document);
        const SavedState after = solver->save();
        EXPECT_TRUE(same_bits(after.contents.particles, before.contents.particles));
        EXPECT_TRUE(same_bits(after.contents.gaussians, before.contents.gaussians));
        EXPECT_EQ(after.config.materials, before.config.materials);
        EXPECT_EQ(after.order, before.order);
    }
    void frames(int count)
    {
        for (int i = 0; i < count; ++i) {
            ASSERT_TRUE(loop.step());
            editor.after_frame(loop.last());
            history.after_frame(loop.last());
        }
    }
    std::vector<Particle<double>> clay_of(ObjectId id) const
    {
        std::vector<Particle<double>> found;
        const std::vector<int>& numbers = editor.simulated(id);
        for (const Particle<double>& p : solver->save().contents.particles)
            if (std::ranges::count(numbers, p.object)) found.push_back(p);
        return found;
    }
    double mass_of(ObjectId id) const
    {
        double mass = 0;
        for (const Particle<double>& p : clay_of(id))
            mass += solver->config().materials.at(std::size_t(p.object)).mass;
        return mass;
    }
    std::size_t splats_of(ObjectId id) const
    {
        const std::vector<int>& numbers = editor.simulated(id);
        return std::size_t(std::ranges::count_if(solver->gaussians(), [&](const auto& g) {
            return std::ranges::count(numbers, g.object) > 0;
        }));
    }
    ClayRows rows() const { return solver->rows(*solver->snapshot()); }
    ObjectId id(const std::string& name) const
    {
        return std::get<ObjectId>(resolved(*editor.document(), ObjectRef(name)));
    }

    Scene scene;
    std::vector<SplatObject> splat_objects;
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
        scene.setup.deterministic = true, scene.setup.threads = 1;
        return on_gpu ? gpu_solver(scene.setup, 0) : cpu_solver(scene.setup);
    }
};

Scene scene_of_objects(const std::string& objects, const std::string& file = "scenes/three.json")
{
    return parse_scene(R"({"schema": "knead.scene/1", "domain": {"edge": 0.96, "cells": 32},
        "gravity": [0, -9.81, 0], "frame_rate": 90, "objects": [)" +
                           objects + "]}",
                       file);
}

class Reshape : public OnBothDevices {
  protected:
    Reshaped begun() { return {scene_of_objects(three), GetParam()}; }
};

TEST_P(Reshape, ACopyHasTheFullStateBesideTheObject)
{
    Reshaped s = begun();
    s.frames(6);
    const auto before = s.clay_of({1});
    const Vec3<double> by{0.25, 0.125, 0};
    const auto copied =
        std::get<CopyObjects>(s.applied(CopyObjects{{ObjectRef("ball")}, by, {}, {}}));
    ASSERT_EQ(copied.ids, (std::vector<ObjectId>{{4}}));
    EXPECT_EQ(s.editor.document()->find({4})->name, "ball copy");
    const auto copy = s.clay_of({4});
    EXPECT_TRUE(same_bits(s.clay_of({1}), before));
    ASSERT_EQ(copy.size(), before.size());
    for (std::size_t i = 0; i < copy.size(); ++i) {
        ASSERT_LT(length(copy[i].x - before[i].x - by), 1e-6);
        Particle<double> there = copy[i];
        there.x = before[i].x, there.object = before[i].object;
        ASSERT_TRUE(same_bits(std::vector{there}, std::vector{before[i]})) << i;
    }
    EXPECT_EQ(s.mass_of({4}), s.mass_of({1}));
    s.refused(CopyObjects{{ObjectId{1}}, {0.05, 0, 0}, {}, {}}, "by", "in the way");
    s.refused(CopyObjects{{ObjectId{1}}, by, {}, {}}, "by", "in the way");
    s.refused(CopyObjects{{ObjectId{1}}, {0, 0.6, 0}, {}, {}}, "by", "between the walls");
    s.refused(CopyObjects{{ObjectId{1}}, {0, -0.25, 0}, {}, {}}, "by", "between the walls");
    s.applied(SetFlags{ObjectId{2}, true, {}});
    s.applied(CopyObjects{{ObjectRef("block")}, {0, 0.2, 0}, {"second"}, {}});
    EXPECT_EQ(s.editor.document()->find({5})->name, "second");
    s.frames(3);
}

TEST_P(Reshape, MovedObjectsKeepTheirStateAndTheirDistances)
{
    Reshaped s = begun();
    s.frames(6);
    const auto ball = s.clay_of({1}), drum = s.clay_of({3});
    const Vec3<double> by{0.125, 0.25, 0};
    const auto moved = std::get<MoveObjects>(
        s.applied(MoveObjects{{ObjectRef("ball"), ObjectRef("drum")}, by, {}, {}}));
    EXPECT_FALSE(moved.about);
    for (const auto& [id, before] : {std::pair{1u, &ball}, {3u, &drum}}) {
        const auto after = s.clay_of({id});
        ASSERT_EQ(after.size(), before->size());
        for (std::size_t i = 0; i < after.size(); ++i) {
            ASSERT_LT(length(after[i].x - (*before)[i].x - by), 1e-6);
            ASSERT_LT(length(after[i].v - (*before)[i].v), 1e-6);
        }
    }
    const Vec3<double> pose = s.editor.document()->find({1})->pose.p;
    EXPECT_LT(length(pose - Vec3<double>{0.425, 0.55, 0.3}), 1e-12);
    // A quarter turn about the vertical through the middle of both, there and back.
    const double h = std::sqrt(0.5);
    const auto lifted = s.clay_of({1});
    const auto turned = std::get<MoveObjects>(s.applied(
        MoveObjects{{ObjectRef("ball"), ObjectRef("drum")}, {}, Quat<double>{h, 0, h, 0}, {}}));
    ASSERT_TRUE(turned.about) << "a log has the point";
    EXPECT_NEAR(turned.about->z, 0.45, 0.01);
    EXPECT_NEAR(s.editor.document()->find({1})->pose.q.y, h, 1e-12);
    s.refused(MoveObjects{{ObjectId{1}}, Vec3<double>{5, 0, 0}, {}, {}}, "by", "between the walls");
    s.refused(MoveObjects{{ObjectId{1}, ObjectId{3}}, Vec3<double>{0, -0.6, 0}, {}, {}}, "by",
              "between the walls");
    s.applied(MoveObjects{
        {ObjectRef("drum"), ObjectRef("ball")}, {}, Quat<double>{h, 0, -h, 0}, turned.about});
    const auto back = s.clay_of({1});
    for (std::size_t i = 0; i < back.size(); ++i) ASSERT_LT(length(back[i].x - lifted[i].x), 1e-6);
    // Into another object, by the clay, not by the document; beside it is free.
    const Vec3<double> to_block = Vec3<double>{0.6, 0.2, 0.6} - Vec3<double>{0.425, 0.55, 0.3};
    s.refused(MoveObjects{{ObjectId{1}}, to_block, {}, {}}, "by", "in the way");
    s.refused(MoveObjects{{ObjectId{1}}, Vec3<double>{}, Quat<double>{h, h, h, 0}, {}}, "turn",
              "length 1");
    s.applied(SetFlags{ObjectId{3}, true, {}});
    s.refused(MoveObjects{{ObjectId{1}, ObjectId{3}}, by, {}, {}}, "objects", "locked");
    s.refused(MoveObjects{{}, by, {}, {}}, "objects", "at least one");
    s.refused(MoveObjects{{ObjectId{1}, ObjectId{1}}, by, {}, {}}, "objects", "named twice");
    s.frames(2);
}

// Clay that lies on other clay is as near to it as clay that is put into it.
TEST_P(Reshape, AnObjectIsTakenOffAnotherOneButNotPutDeeper)
{
    Reshaped s{scene_of_objects(R"({"name": "low", "shape": "box", "centre": [0.48, 0.2, 0.48],
        "size": [0.2, 0.1, 0.2]}, {"name": "high", "shape": "box", "centre": [0.48, 0.3, 0.48],
        "size": [0.15, 0.1, 0.15]})"),
               GetParam()};
    s.applied(SetGravity{{0, -20, 0}});
    s.frames(10);
    s.refused(MoveObjects{{ObjectRef("high")}, Vec3<double>{0, -0.03, 0}, {}, {}}, "by",
              "in the way");
    s.applied(MoveObjects{{ObjectRef("high")}, Vec3<double>{0, 0.004, 0}, {}, {}});
    s.applied(MoveObjects{{ObjectRef("high")}, Vec3<double>{0, 0.2, 0}, {}, {}});
    s.frames(2);
}

TEST_P(Reshape, ResetObjectsAreAsTheyWereMadeWhereTheyWerePlaced)
{
    Reshaped s = begun();
    const auto first = s.clay_of({2});
    const Vec3<double> centre = s.editor.places().find({2})->centre;
    s.applied(SetGravity{{0, -9, 0}});
    s.frames(12);
    EXPECT_GT(length(s.editor.places().find({2})->centre - centre), 0.01);
    const ClayRows fallen = s.rows();
    const DocumentPtr before = s.editor.document();
    s.applied(ResetObjects{{ObjectRef("block")}});
    EXPECT_TRUE(equal(*s.editor.document(), *before));
    const auto again = s.clay_of({2});
    ASSERT_EQ(again.size(), first.size());
    EXPECT_LT(length(s.editor.places().find({2})->centre - centre), 1e-3);
    for (const Particle<double>& p : again) {
        ASSERT_EQ(length(p.v), 0);
        ASSERT_EQ(p.e.xx, 0);
    }
    s.applied(Undo{});
    EXPECT_TRUE(same_rows(s.rows(), fallen));
    s.applied(Redo{});
    // Where it was moved to, in its size.
    s.applied(MoveObjects{{ObjectRef("block")}, Vec3<double>{0.0625, 0.25, 0}, {}, {}});
    s.applied(ScaleObjects{{ObjectRef("block")}, 1.25});
    s.applied(ResetObjects{{ObjectRef("block"), ObjectRef("drum")}});
    const Box3<double> box = s.editor.places().find({2})->box;
    EXPECT_NEAR(0.5 * (box.low.x + box.high.x) + s.scene.origin.x, 0.6625, 0.01);
    EXPECT_NEAR(box.high.x - box.low.x, 0.25, 0.02);
    // Not of parts, of merged ones, or into others.
    s.applied(CopyObjects{{ObjectRef("drum")}, {0.25, 0, -0.25}, {"second"}, {}});
    s.applied(
        SplitObject{ObjectRef("drum"), SplitPlane{{0.3, 0.3, 0.6}, {1, 0, 0}}, {}, {"l", "r"}, {}});
    s.refused(ResetObjects{{ObjectRef("l")}}, "objects", "merged or split");
    s.applied(MergeObjects{{ObjectRef("l"), ObjectRef("r")}, "both"});
    s.refused(ResetObjects{{ObjectRef("both")}}, "objects", "merged or split");
    s.refused(ResetObjects{{ObjectId{77}}}, "objects", "there is no object");
    s.applied(SetFlags{ObjectRef("second"), true, {}});
    s.refused(ResetObjects{{ObjectRef("second")}}, "objects", "locked");
    s.frames(1);
}

TEST_P(Reshape, ScaledObjectsHaveTheFactorsThirdPowerOfTheirMass)
{
    Reshaped s = begun();
    const double mass = s.mass_of({1});
    const std::size_t count = s.clay_of({1}).size();
    s.applied(ScaleObjects{{ObjectRef("ball")}, 2});
    EXPECT_NEAR(s.mass_of({1}), 8 * mass, 1e-9 * mass);
    EXPECT_EQ(s.clay_of({1}).size(), 8 * count);
    EXPECT_DOUBLE_EQ(s.editor.document()->find({1})->source.size.x, 0.32);
    const DocumentPtr two = s.editor.document();
    s.applied(ScaleObjects{{ObjectRef("ball")}, 1});
    EXPECT_EQ(s.editor.document(), two);
    s.applied(ScaleObjects{{ObjectRef("ball")}, 0.5});
    EXPECT_NEAR(s.mass_of({1}), mass, 1e-9 * mass);
    EXPECT_EQ(s.clay_of({1}).size(), count);
    for (const double factor : {0.0, -1.0, 1000.0, double(NAN)})
        s.refused(ScaleObjects{{ObjectRef("ball")}, factor}, "factor", "expected");
    // What fits, fits.
    const CommandAnswer answer = s.apply(ScaleObjects{{ObjectRef("drum")}, 10});
    ASSERT_TRUE(answer.refusal);
    const std::string& why = answer.refusal->why;
    ASSERT_NE(why.find("largest factor that fits is "), std::string::npos) << why;
    const double largest = std::stod(why.substr(why.rfind(' ')));
    EXPECT_GT(largest, 7);
    EXPECT_LT(largest, 9);
    s.refused(ScaleObjects{{ObjectRef("drum")}, 1.02 * largest}, "factor", "largest factor");
    s.refused(ScaleObjects{{ObjectRef("drum")}, largest}, "factor", "in the way");
    s.applied(RemoveObjects{{ObjectId{1}, ObjectId{2}}});
    s.applied(ScaleObjects{{ObjectRef("drum")}, sanitized ? 2 : 4});
    s.frames(1);
}

// An object on the floor grows upwards.
TEST_P(Reshape, ScaledClayIsNotBehindAWall)
{
    Reshaped s = begun();
    s.frames(40);
    const double floor = s.solver->config().walls.min.y;
    double low = 1;
    for (const Particle<double>& p : s.clay_of({2})) low = std::min(low, p.x.y);
    s.applied(ScaleObjects{{ObjectRef("block")}, 1.5});
    double scaled_low = 1;
    for (const Particle<double>& p : s.clay_of({2})) scaled_low = std::min(scaled_low, p.x.y);
    EXPECT_GE(scaled_low, floor - 1e-6);
    EXPECT_LT(std::abs(scaled_low - low), 0.03);
    s.frames(3);
}

TEST_P(Reshape, MergingChangesNoNumberOfTheClay)
{
    Reshaped s = begun();
    s.frames(4);
    const SavedState before = s.solver->save();
    const double mass = s.mass_of({1}) + s.mass_of({2}) + s.mass_of({3});
    const std::vector<ObjectRef> all{ObjectRef("drum"), ObjectRef("ball"), ObjectRef("block")};
    s.applied(MergeObjects{all, "heap"});
    ASSERT_EQ(s.editor.document()->objects.size(), 1u);
    EXPECT_EQ(s.editor.document()->objects[0]->id.value, 3u);
    EXPECT_EQ(s.editor.document()->objects[0]->name, "heap");
    EXPECT_EQ(s.editor.simulated({3}), (std::vector<int>{2, 0, 1}));
    const SavedState after = s.solver->save();
    EXPECT_TRUE(same_bits(after.contents.particles, before.contents.particles));
    EXPECT_EQ(after.order, before.order);
    EXPECT_EQ(after.config.materials.at(1).category, 0);
    EXPECT_EQ(after.config.materials.at(1).mu, before.config.materials.at(1).mu);
    EXPECT_NEAR(s.mass_of({3}), mass, 1e-12 * mass);
    // What is done to the object is done to all of it.
    s.applied(SetCategory{ObjectRef("heap"), 5});
    for (const int number : {0, 1, 2}) {
        const Material<double>& m = s.solver->config().materials.at(std::size_t(number));
        EXPECT_EQ(m.category, 5);
        EXPECT_EQ(m.mu, before.config.materials.at(std::size_t(number)).mu);
    }
    s.applied(PlaceObject{ObjectRef("heap"), Vec3<double>{0.3, 0.35, 0.6}, {}});
    const auto moved = s.solver->save().contents.particles;
    for (std::size_t i = 0; i < moved.size(); ++i)
        ASSERT_NEAR(moved[i].x.y - before.contents.particles[i].x.y, 0.05, 1e-6);
    s.applied(SetMaterial{ObjectRef("heap"), material_spec("clay")});
    for (const int number : {0, 1, 2})
        EXPECT_EQ(s.solver->config().materials.at(std::size_t(number)).mu,
                  made(material_spec("clay")).mu);
    s.applied(SplitObject{ObjectRef("heap"), {}, true, {}, {}});
    EXPECT_EQ(s.editor.document()->objects.size(), 3u);
    s.applied(RemoveObjects{{ObjectRef("heap"), ObjectRef("heap 2"), ObjectRef("heap 3")}});
    EXPECT_EQ(s.solver->particle_count(), 0u);
}

TEST_P(Reshape, APlaneSplitsWithoutLoss)
{
    Reshaped s = begun();
    s.frames(4);
    const auto before = s.clay_of({2});
    const double mass = s.mass_of({2});
    const SplitPlane plane{{0.58, 0, 0}, {-3, 0, 0}};
    const Command as = s.applied(SplitObject{ObjectRef("block"), plane, {}, {"l", "r"}, {}});
    // Before the plane is the smaller part.
    EXPECT_EQ(std::get<SplitObject>(as).ids, (std::vector<ObjectId>{{4}, {2}}));
    EXPECT_EQ(s.id("l").value, 4u);
    EXPECT_EQ(s.id("r").value, 2u);
    const auto l = s.clay_of({4}), r = s.clay_of({2});
    EXPECT_EQ(l.size() + r.size(), before.size());
    EXPECT_LT(l.size(), r.size());
    EXPECT_NEAR(s.mass_of({4}) + s.mass_of({2}), mass, 1e-12);
    const double at = 0.58 - s.scene.origin.x;
    for (const Particle<double>& p : l) ASSERT_LE(p.x.x, at);
    for (const Particle<double>& p : r) ASSERT_GT(p.x.x, at);
    // Nothing but the object's number has changed.
    std::vector<Particle<double>> all = l;
    all.insert(all.end(), r.begin(), r.end());
    for (Particle<double>& p : all) p.object = before[0].object;
    const auto first = [](const Particle<double>& a, const Particle<double>& b) {
        return std::tuple(a.x.x, a.x.y, a.x.z) < std::tuple(b.x.x, b.x.y, b.x.z);
    };
    auto sorted = before;
    std::ranges::sort(sorted, first), std::ranges::sort(all, first);
    EXPECT_TRUE(same_bits(all, sorted));
    s.refused(SplitObject{ObjectRef("l"), SplitPlane{{0.7, 0, 0}, {1, 0, 0}}, {}, {}, {}}, "plane",
              "on one side");
    s.refused(SplitObject{ObjectRef("ball"), SplitPlane{{0.3, 0.36, 0.3}, {0, 1, 0}}, {}, {}, {}},
              "plane", "at least 64 particles");
    s.refused(SplitObject{ObjectRef("ball"), {}, true, {}, {}}, "pieces", "no other piece");
    s.applied(SetFlags{ObjectRef("ball"), true, {}});
    s.refused(SplitObject{ObjectRef("ball"), plane, {}, {}, {}}, "object", "locked");
    s.frames(3);
}

// Each verb, then undo and redo: rows, document, numbers and materials are those of the steps.
TEST_P(Reshape, UndoAndRedoAreToTheBit)
{
    Reshaped s = begun();
    s.applied(SetGravity{{0, -5, 0}});
    s.frames(5);
    s.history.close();
    struct Kept {
        ClayRows rows;
        DocumentPtr document;
        ObjectNumbers numbers;
    };
    const auto keep = [&] { return Kept{s.rows(), s.editor.document(), s.editor.numbers()}; };
    std::vector<Kept> steps{keep()};
    for (const Command& command :
         {Command(CopyObjects{{ObjectRef("ball")}, {0.25, 0.1, 0}, {"b"}, {}}),
          Command(ScaleObjects{{ObjectRef("ball")}, 1.4}),
          Command(MergeObjects{{ObjectRef("drum"), ObjectRef("b")}, "c"}),
          Command(
              SplitObject{ObjectRef("ball"), SplitPlane{{0.3, 0.3, 0.3}, {0, 1, 1}}, {}, {}, {}}),
          Command(SplitObject{ObjectRef("c"), {}, true, {}, {}}),
          Command(ScaleObjects{{ObjectRef("c"), ObjectRef("block")}, 0.6})}) {
        s.applied(command);
        s.frames(2);
        s.history.close();
        steps.push_back(keep());
    }
    const auto check = [&](std::size_t i) {
        SCOPED_TRACE(i);
        EXPECT_TRUE(same_rows(s.rows(), steps[i].rows));
        EXPECT_TRUE(equal(*s.editor.document(), *steps[i].document));
        EXPECT_EQ(s.editor.numbers().number, steps[i].numbers.number);
        EXPECT_EQ(s.solver->config().materials, steps[i].numbers.materials);
    };
    for (int turn = 0; turn < 2; ++turn) {
        for (std::size_t i = steps.size() - 1; i > 0; --i) s.applied(Undo{}), check(i - 1);
        for (std::size_t i = 1; i < steps.size(); ++i) s.applied(Redo{}), check(i);
    }
    s.frames(2);
}

// Random verbs with undo and redo: the mass of each object, and its numbers, are those that the
// verbs say; everything that was added up is there.
TEST_P(Reshape, RandomVerbsKeepTheBooks)
{
    const std::uint64_t seed = std::getenv("KNEAD_LONG") ? std::random_device{}() : 61;
    SCOPED_TRACE(seed);
    Random r(seed);
    Reshaped s = begun();
    std::map<std::string, int> applied;
    bool undone = false;
    const long count = repeats(sanitized ? 20 : 120, 3000);
    for (long i = 0; i < count && !HasFailure(); ++i) {
        SCOPED_TRACE(i);
        const DocumentPtr before = s.editor.document();
        if (before->objects.empty()) break;
        const ObjectId one = r.of(before->objects)->id, other = r.of(before->objects)->id;
        std::map<ObjectId, double> mass;
        double sum = 0;
        for (const auto& o : before->objects) sum += mass[o->id] = s.mass_of(o->id);
        Command command = Undo{};
        const Vec3<double> centre = [&] {
            Vec3<double> c{};
            const auto clay = s.clay_of(one);
            for (const Particle<double>& p : clay) c = c + (1 / double(clay.size())) * p.x;
            return c + s.scene.origin;
        }();
        switch (r.below(15)) {
            case 10:
                command = MoveObjects{{one}, {}, random_rotation(r), {}};
                if (r.one_in(2) && one != other) {
                    auto& moves = std::get<MoveObjects>(command);
                    moves.objects.push_back(other);
                    moves.by = Vec3<double>{r.in(-0.1, 0.1), r.in(0, 0.2), r.in(-0.1, 0.1)};
                }
                break;
            case 11:
                command = MoveObjects{
                    {one}, Vec3<double>{r.in(-0.2, 0.2), r.in(-0.1, 0.2), r.in(-0.2, 0.2)}, {}, {}};
                break;
            case 12:
            case 13:
            case 14:
                command = ResetObjects{{one}};
                break;
            case 0:
            case 1:
                command =
                    CopyObjects{{one}, {r.in(-0.3, 0.3), r.in(0, 0.3), r.in(-0.3, 0.3)}, {}, {}};
                break;
            case 2:
            case 3:
                command = ScaleObjects{{one}, sum > 12 ? r.in(0.4, 1) : r.in(0.6, 1.6)};
                break;
            case 4:
                command = MergeObjects{{one, other}, {}};
                break;
            case 5:
            case 6:
                command = SplitObject{
                    one, SplitPlane{centre, {r.in(-1, 1), r.in(-1, 1), r.in(-1, 1)}}, {}, {}, {}};
                break;
            case 7:
                command = SplitObject{one, {}, true, {}, {}};
                break;
            case 8:
                command = Redo{};
                break;
            default:
                break;
        }
        if (undone && r.one_in(2)) command = Redo{};
        const ClayRows rows = s.rows();
        const CommandAnswer answer = s.apply(command);
        undone = std::holds_alternative<Undo>(command);
        const DocumentPtr after = s.editor.document();
        double now = 0, all = 0;
        for (const auto& o : after->objects) now += s.mass_of(o->id);
        for (const Particle<double>& p : s.solver->save().contents.particles)
            all += s.solver->config().materials.at(std::size_t(p.object)).mass;
        EXPECT_NEAR(now, all, 1e-9 * all) << "clay of no object";
        if (answer.refusal) {
            EXPECT_TRUE(same_rows(s.rows(), rows)) << answer.refusal->text();
            EXPECT_EQ(after, before);
            continue;
        }
        ++applied[row_of(command).name];
        if (std::holds_alternative<CopyObjects>(command)) {
            EXPECT_NEAR(now, sum + mass[one], 1e-9 * sum);
        } else if (const auto* scales = std::get_if<ScaleObjects>(&command)) {
            const double cube = scales->factor * scales->factor * scales->factor;
            EXPECT_NEAR(now, sum + (cube - 1) * mass[one], 1e-9 * sum);
        } else if (std::holds_alternative<ResetObjects>(command)) {
            EXPECT_NEAR(now - s.mass_of(one), sum - mass[one], 1e-9 * sum);
        } else if (reads_clay(command)) {
            EXPECT_NEAR(now, sum, 1e-9 * sum);
        }
        IdSource ids;
        if (reads_clay(command)) {
            EXPECT_TRUE(equal(*knead::after(before, answer.applied, ids), *after));
        }
        if (r.one_in(3)) s.frames(1);
    }
    EXPECT_EQ(applied.size(), 8u) << testing::PrintToString(applied);
}

INSTANTIATE_TEST_SUITE_P(Devices, Reshape, testing::Bool(), device_of);

// A pot of splats: they go with the clay, and undo brings them back.
SourceBegin nozzle(const std::string& name, Vec3<double> at)
{
    SourceBegin begins;
    begins.name = name, begins.diameter = 0.08, begins.at = at;
    return begins;
}

TEST_P(Reshape, ANozzleLaysClayAtRestAndItIsOneStep)
{
    Reshaped s = begun();
    const ClayRows before = s.rows();
    const DocumentPtr document = s.editor.document();
    const std::size_t steps = s.past.count();
    const auto begins = std::get<SourceBegin>(s.applied(nozzle("rope", {0.2, 0.7, 0.8})));
    ASSERT_EQ(begins.ids, (std::vector<ObjectId>{{4}}));
    EXPECT_TRUE(s.clay_of({4}).empty());
    std::vector<Particle<double>> clay;
    for (int i = 1; i <= 40; ++i) {
        s.applied(SourceMove{ObjectRef("rope"), {0.2 + 0.01 * i, 0.7, 0.8}, {}});
        clay = s.clay_of({4});
        if (i == 1) {
            EXPECT_EQ(clay.back().v.y, 0);
        }
        if (i < 40) s.frames(1);
    }
    const double mass = made(material_spec("clay")).density * 3.141592653589793 * 0.0016 * 0.4;
    EXPECT_NEAR(s.mass_of({4}), mass, 0.03 * mass);
    EXPECT_LT(clay.front().v.y, -0.5);
    s.applied(SourceEnd{ObjectRef("rope")});
    EXPECT_FALSE(has_nozzle(*s.editor.document()));
    s.frames(150);
    s.history.close();
    EXPECT_EQ(s.past.count(), steps + 1);
    s.applied(Undo{});
    EXPECT_TRUE(same_rows(s.rows(), before));
    EXPECT_TRUE(equal(*s.editor.document(), *document));
    s.applied(Redo{});
    const ClayRows laid = s.rows();
    EXPECT_EQ(s.clay_of({4}).size(), clay.size());
    s.frames(3);
    s.applied(Undo{});
    s.applied(Redo{});
    EXPECT_TRUE(same_rows(s.rows(), laid));
    s.applied(PlaceObject{ObjectRef("rope"), Vec3<double>{0.2, 0.8, 0.3}, {}});
    s.frames(2);
}

TEST_P(Reshape, ANozzleLaysNothingIntoClayAndBeyondWalls)
{
    Reshaped s = begun();
    s.applied(nozzle("bar", {0.3, 0.3, 0.1}));
    s.applied(SourceMove{ObjectRef("bar"), {0.3, 0.3, 1.4}, {}});
    const auto laid = s.clay_of({4});
    double nearest = 1;
    for (const auto& p : laid) {
        EXPECT_LE(p.x.z, s.solver->config().walls.max.z);
        for (const ObjectId other : {ObjectId{1}, ObjectId{3}})
            for (const auto& q : s.clay_of(other)) nearest = std::min(nearest, length(p.x - q.x));
    }
    EXPECT_GT(nearest, 0.0112);  // 3/4 of a spacing
    EXPECT_LT(nearest, 0.03);
    EXPECT_GT(laid.size(), 100u);
    s.applied(SourceMove{ObjectRef("bar"), {0.3, 0.3, 0.1}, {}});
    EXPECT_LE(s.clay_of({4}).size(), laid.size() + laid.size() / 50);  // all of it is filled
    s.frames(5);
}

TEST_P(Reshape, SourcesThatCannotBeAreRefused)
{
    Reshaped s = begun();
    s.refused(SourceMove{ObjectRef("ball"), {0.5, 0.5, 0.5}, {}}, "name", "no nozzle lays");
    s.refused(SourceEnd{ObjectRef("ball")}, "name", "no nozzle lays");
    s.refused(SourceEnd{ObjectRef("none")}, "name", "no object");
    SourceBegin thin = nozzle("thin", {0.5, 0.5, 0.5});
    thin.diameter = 0.012;
    s.refused(thin, "diameter", "at least a particle");
    thin.diameter = 0;
    s.refused(thin, "diameter", "above 0");
    SourceBegin flat = nozzle("flat", {0.5, 0.5, 0.5});
    flat.section = SectionKind::outline;
    s.refused(flat, "outline", "3 to 1000 points");
    flat.outline = {{0, 0}, {1, 1}, {2, 2}};
    s.refused(flat, "outline", "an area");
    s.applied(nozzle("rope", {0.5, 0.6, 0.5}));
    s.refused(CopyObjects{{ObjectRef("rope")}, {0.1, 0, 0}, {}, {}}, "objects", "a nozzle lays");
    s.refused(ScaleObjects{{ObjectRef("rope")}, 1.5}, "objects", "no clay");
    s.refused(SourceMove{ObjectRef("rope"), {0.5, 2000, 0.5}, {}}, "at", "1000");
    s.applied(SetFlags{ObjectRef("rope"), true, {}});
    s.refused(SourceMove{ObjectRef("rope"), {0.5, 0.7, 0.5}, {}}, "name", "locked");
    s.applied(SetFlags{ObjectRef("rope"), false, {}});
    s.applied(SourceEnd{ObjectRef("rope")});  // it was not moved
    EXPECT_EQ(s.editor.document()->objects.size(), 3u);
    s.refused(SourceMove{ObjectId{4}, {0.5, 0.7, 0.5}, {}}, "name", "no object");
}

// A nozzle that was undone is gone; one that undo has interrupted goes on after redo.
TEST_P(Reshape, UndoOfANozzleUnderWayTakesAllOfItsClay)
{
    Reshaped s = begun();
    s.applied(nozzle("rope", {0.2, 0.7, 0.8}));
    s.applied(SourceMove{ObjectRef("rope"), {0.4, 0.7, 0.8}, {}});
    s.frames(3);
    const std::size_t count = s.clay_of({4}).size();
    ASSERT_GT(count, 50u);
    s.applied(Undo{});
    EXPECT_FALSE(s.editor.document()->find({4}));
    s.refused(SourceMove{ObjectId{4}, {0.6, 0.7, 0.8}, {}}, "name", "no object");
    s.frames(2);
    s.applied(Redo{});
    EXPECT_EQ(s.clay_of({4}).size(), count);
    s.applied(SourceMove{ObjectId{4}, {0.6, 0.7, 0.8}, {}});
    EXPECT_GT(s.clay_of({4}).size(), 2 * count - 60);
    s.applied(SourceEnd{ObjectId{4}});
    s.applied(Undo{});
    s.applied(Undo{});
    EXPECT_FALSE(s.editor.document()->find({4}));
    // Undone to an object without clay and back.
    const auto other = std::get<SourceBegin>(s.applied(nozzle("rope", {0.2, 0.7, 0.8})));
    s.applied(Undo{});
    s.applied(Redo{});
    EXPECT_TRUE(s.clay_of(other.ids.at(0)).empty());
    s.applied(RemoveObjects{{other.ids.at(0)}});
    s.applied(Undo{});
    s.applied(SourceMove{other.ids.at(0), {0.4, 0.7, 0.8}, {}});
    s.frames(2);
}

class ReshapedSplats : public InFolder {
  protected:
    void SetUp() override { write_splats(path("pot.ply"), glazed_pot(1000)); }
    Reshaped begun()
    {
        return {scene_of_objects(R"({"name": "pot", "shape": "splats", "file": "pot.ply",
            "size": 0.2, "centre": [0.4, 0.3, 0.4], "material": "soft-clay"})",
                                 path("scene.json")),
                false};
    }
};

TEST_F(ReshapedSplats, GoWithTheClay)
{
    Reshaped s = begun();
    s.applied(SetGravity{{0, -5, 0}});
    s.frames(3);
    s.history.close();
    const std::size_t count = s.splats_of({1});
    ASSERT_GT(count, 100u);
    const CarriedSplats first = s.splats.state();
    const ClayRows rows = s.rows();
    s.applied(CopyObjects{{ObjectRef("pot")}, {0.3, 0, 0}, {"second"}, {}});
    EXPECT_EQ(s.splats_of({1}), count);
    EXPECT_EQ(s.splats_of({2}), count);
    ASSERT_EQ(s.splats.state().count(), 2 * count);
    const auto gaussians = s.solver->gaussians();
    for (std::size_t i = 0; i < count; ++i) {
        ASSERT_LT(length(gaussians[count + i].x - gaussians[i].x - Vec3<double>{0.3, 0, 0}), 1e-6);
        ASSERT_TRUE(same_bits(std::vector{gaussians[count + i].F}, std::vector{gaussians[i].F}));
    }
    s.frames(2), s.history.close();
    s.applied(ScaleObjects{{ObjectRef("second")}, 0.5});
    EXPECT_EQ(s.splats_of({2}), count);
    EXPECT_FLOAT_EQ(s.splats.state().cloud.scale[count].x, 0.5f * first.cloud.scale[0].x);
    EXPECT_FLOAT_EQ(s.splats.state().extent[count], 0.5f * first.extent[0]);
    EXPECT_EQ(s.splats.state().cloud.scale[0].x, first.cloud.scale[0].x);
    s.frames(2), s.history.close();
    const ClayRows scaled = s.rows();
    const CarriedSplats scaled_splats = s.splats.state();
    const SplitPlane plane{{0.4, 0.31, 0.4}, {0, 1, 0}};
    s.applied(SplitObject{ObjectRef("pot"), plane, {}, {"l", "r"}, {}});
    EXPECT_EQ(s.splats_of(s.id("l")) + s.splats_of(s.id("r")), count);
    EXPECT_GT(s.splats_of(s.id("l")), 0u);
    EXPECT_GT(s.splats_of(s.id("r")), 0u);
    s.frames(2), s.history.close();
    s.applied(MergeObjects{{ObjectRef("l"), ObjectRef("r")}, "pot"});
    EXPECT_EQ(s.splats_of(s.id("pot")), count);
    s.frames(2), s.history.close();
    for (int i = 0; i < 2; ++i) s.applied(Undo{});
    EXPECT_TRUE(same_rows(s.rows(), scaled));
    EXPECT_TRUE(same_bits(s.splats.state().cloud.scale, scaled_splats.cloud.scale));
    EXPECT_TRUE(same_bits(s.splats.state().extent, scaled_splats.extent));
    for (int i = 0; i < 2; ++i) s.applied(Undo{});
    EXPECT_TRUE(same_rows(s.rows(), rows));
    EXPECT_TRUE(same_bits(s.splats.state().cloud.scale, first.cloud.scale));
    EXPECT_TRUE(same_bits(s.splats.state().cloud.centre, first.cloud.centre));
    s.frames(2);
}

}  // namespace
}  // namespace knead
