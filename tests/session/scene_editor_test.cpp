// The simulator follows the document: differences of random pairs of documents, refusals in the
// middle of them, and commands one by one.
#include "host/session/scene_editor.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "host/scene/seed.h"
#include "host/solver/audit.h"
#include "tests/document/random.h"
#include "tests/sanitized.h"
#include "tests/solver/same_bits.h"

namespace knead {
namespace {

// A simulator whose n-th edit fails.
class FailingEdits : public EditableSimulator {
  public:
    explicit FailingEdits(std::unique_ptr<EditableSimulator> of) : inner(std::move(of)) {}

    int left = -1;  // edits until one fails; negative: none does
    int made = 0;

    std::vector<int> add_each(const Material<double>& m, Clays clays) override
    {
        return count(), inner->add_each(m, clays);
    }
    void remove_each(std::span<const int> objects) override
    {
        count(), inner->remove_each(objects);
    }
    void set_material(int object, const Material<double>& m) override
    {
        count(), inner->set_material(object, m);
    }
    void move(int object, const RigidMotion<double>& motion) override
    {
        count(), inner->move(object, motion);
    }
    void set_gravity(Vec3<double> g) override { count(), inner->set_gravity(g); }
    void set_walls(const WallOptions& walls) override { count(), inner->set_walls(walls); }
    void set_contact(const BodyContact& contact) override { count(), inner->set_contact(contact); }
    void set_tools(const Rig& rig, const std::vector<Tool<double>>& tools) override
    {
        count(), inner->set_tools(rig, tools);
    }
    void attach(int object, const std::vector<Vec3<double>>& places) override
    {
        count(), inner->attach(object, places);
    }
    void set_gaussians(const std::vector<Gaussian<double>>& all) override
    {
        count(), inner->set_gaussians(all);
    }
    void edit_gaussians(const GaussianEdits& edits) override
    {
        count(), inner->edit_gaussians(edits);
    }
    const SimulationConfig& config() const override { return inner->config(); }
    std::shared_ptr<const Snapshot> snapshot() const override { return inner->snapshot(); }
    void restore(const Snapshot& snapshot) override { inner->restore(snapshot); }
    SnapshotData held(const Snapshot& snapshot) const override { return inner->held(snapshot); }
    void replace(const SimulationConfig& to, const ClayRows& clay) override
    {
        count(), inner->replace(to, clay);
    }
    void replace(const SimulationConfig& to, const InitialState& contents) override
    {
        count(), inner->replace(to, contents);
    }
    ClayRows rows(const Snapshot& snapshot) const override { return inner->rows(snapshot); }
    SavedState saved(const Snapshot& snapshot) const override { return inner->saved(snapshot); }
    SavedState save() const override { return inner->save(); }
    void load(const SavedState& state) override { inner->load(state); }
    FrameStats advance(const Motion& motion, double duration) override
    {
        return inner->advance(motion, duration);
    }
    long version() const override { return inner->version(); }
    std::vector<Particle<double>> particles() const override { return inner->particles(); }
    std::vector<Vec3<double>> places(const Box3<double>& box) const override
    {
        return inner->places(box);
    }
    std::vector<double> penetration() const override { return inner->penetration(); }
    std::size_t memory() const override { return inner->memory(); }
    std::string name() const override { return inner->name(); }

  private:
    void count()
    {
        ++made;
        if (left > 0) --left;
        if (left == 0) throw std::runtime_error("the simulator refuses");
    }
    std::unique_ptr<EditableSimulator> inner;
};

Scene three_objects(const std::vector<std::string>& settings = {})
{
    return parse_scene(R"({"schema": "knead.scene/1",
        "domain": {"edge": 0.64, "cells": 16}, "gravity": [0, -9.81, 0], "frame_rate": 90,
        "objects": [
          {"name": "ball", "shape": "sphere", "centre": [0.2, 0.25, 0.2], "diameter": 0.1},
          {"name": "block", "shape": "box", "centre": [0.4, 0.25, 0.4], "size": [0.1, 0.1, 0.1],
           "rotation": [0.9238795325112867, 0, 0.3826834323650898, 0], "material": "dough"},
          {"name": "drum", "shape": "cylinder", "centre": [0.2, 0.25, 0.42], "diameter": 0.08,
           "height": 0.1, "material": "snow", "category": 3}],
        "hands": {"recording": "squeeze", "zoom": 0.4}, "surface": {"nodes": 24}})",
                       "scenes/three.json", settings);
}

// A simulator and the editor of its document.
struct Edited {
    explicit Edited(Scene of) : scene(std::move(of))
    {
        editor = std::make_unique<SceneEditor>(
            SceneEditor::Parts{scene, splats, loop, &solver,
                               [this](const HandsOptions& to) {
                                   const HandTools made = hand_tools(to);
                                   solver.set_tools(made.rig, made.tools);
                                   hands = to;
                               },
                               [this](int count) {
                                   if (surface_fails) throw std::bad_alloc();
                                   nodes = count;
                               }},
            std::make_shared<const Document>(document_of(scene)), ids);
    }
    static Scene built(Scene scene)
    {
        build(scene, std::size_t(1) << 30);
        scene.setup.threads = 1;
        return scene;
    }
    const SimulationConfig& config() const { return solver.config(); }

    Scene scene;
    FailingEdits solver{cpu_solver(scene.setup)};
    SceneSplats splats{scene, {}};
    SessionLoop loop{solver, recorded_motion(nullptr, scene.hands), loop_options(scene)};
    IdSource ids;
    std::unique_ptr<SceneEditor> editor;
    HandsOptions hands = scene.hands;
    int nodes = -1;
    bool surface_fails = false;
};

std::string differs(const std::vector<Material<double>>& a, const std::vector<Material<double>>& b)
{
    if (a.size() != b.size()) return "number of materials";
    for (std::size_t i = 0; i < a.size(); ++i)
        if (!(a[i] == b[i])) return "material " + std::to_string(i);
    return "";
}
bool same(const Rig& a, const Rig& b)
{
    const auto sphere = [](const Binding<float>& x, const Binding<float>& y) {
        return std::ranges::equal(x.joint, y.joint) && std::ranges::equal(x.weight, y.weight) &&
               std::ranges::equal(x.offset, y.offset,
                                  [](auto u, auto v) { return length(u - v) == 0; }) &&
               x.radius == y.radius;
    };
    const auto primitive = [](const Primitive& x, const Primitive& y) {
        return x.count == y.count && x.tool == y.tool &&
               std::equal(x.sphere, x.sphere + x.count, y.sphere);
    };
    return std::ranges::equal(a.spheres, b.spheres, sphere) &&
           std::ranges::equal(a.primitives, b.primitives, primitive);
}
bool same(const std::vector<Tool<double>>& a, const std::vector<Tool<double>>& b)
{
    return std::ranges::equal(a, b, [](const Tool<double>& x, const Tool<double>& y) {
        return x.mode == y.mode && x.friction == y.friction && x.blade == y.blade;
    });
}

// What differs but walls, which are in frames of their own.
std::string differs(const SimulationConfig& a, const SimulationConfig& b)
{
    if (const std::string material = differs(a.materials, b.materials); !material.empty())
        return material;
    if (!equal(a.gravity, b.gravity)) return "gravity";
    if (a.walls.mode != b.walls.mode || a.walls.friction != b.walls.friction) return "walls";
    return !same(a.rig, b.rig) || !same(a.tools, b.tools) ? "tools" : "";
}
std::string differs_in_place(const SimulationConfig& a, const SimulationConfig& b)
{
    if (!equal(a.walls.min, b.walls.min) || !equal(a.walls.max, b.walls.max)) return "walls";
    return differs(a, b);
}

// Rules that the solver takes: walls within those of the scene, materials that are not too stiff.
DocumentPtr with_other_rules(Random& r, DocumentPtr d, const SceneSettings& first)
{
    IdSource ids(1000);
    for (int n = r.below(8); n > 0; --n) {
        const Drawing by{0, d.get()};
        const ObjectId object = d->objects.empty() ? ObjectId{1} : r.of(d->objects)->id;
        MaterialSpec m = r.of(material_specs());
        m.density = r.in(300, 3000);
        if (m.plasticity != Plasticity::fluid) m.young = r.in(1e4, 2e6);
        const double dx = 0.04;
        const Vec3<double> in{r.in(0, dx), r.in(0, dx), r.in(0, dx)};
        Command c;
        switch (r.below(8)) {
            case 0:
                c = SetMaterial{object, m};
                break;
            case 1:
                c = SetCategory{object, r.below(5)};
                break;
            case 2:
                c = SetGravity{{r.in(-9, 9), r.in(-9, 9), r.one_in(2) ? -0.0 : 0.0}};
                break;
            case 3:
                c = SetWalls{first.walls.min + in, first.walls.max - in, r.of(contact_modes).second,
                             r.in(0, 1)};
                break;
            case 4:
                c = random_fields<SetHands>(r, by);
                std::get<SetHands>(c).zoom = r.in(0.1, 2);
                break;
            case 5:
                c = SetSurface{8 + r.below(30)};
                break;
            case 6:
                c = SetFlags{object, {}, r.one_in(2)};
                break;
            default:
                c = Rename{object, r.one_in(2) ? "a" : "b"};
        }
        d = after(d, c, ids);
    }
    return d;
}

// From document to document and back, the rules come back to the bit; and those of each are those
// of a simulator that is made of it.
TEST(SceneEditor, OfAnyTwoDocumentsMakesTheRulesOfEach)
{
    const long pairs = repeats(sanitized ? 10 : 60, 10000);
    const std::uint64_t seed = std::getenv("KNEAD_LONG") ? std::random_device{}() : 58;
    SCOPED_TRACE(seed);
    Random r(seed);
    for (const auto& settings : {std::vector<std::string>{}, {"step.soften_beyond=12"}}) {
        const Scene read = three_objects(settings);
        Edited e(Edited::built(read));
        const DocumentPtr first = e.editor->document();
        long skipped = 0;
        const auto as_built = [&](const DocumentPtr& d) {
            Scene built{};
            try {
                built = Edited::built(scene_of(read, *d));
            } catch (const InputError& refused) {
                // The reader of scenes refuses clay that would hardly flow once it is softened.
                EXPECT_NE(std::string(refused.what()).find("/step/soften_beyond"),
                          std::string::npos);
                return (void)++skipped;
            }
            const std::unique_ptr<EditableSimulator> other = cpu_solver(built.setup);
            EXPECT_EQ(differs(e.config(), other->config()), "");
            for (const auto side : {&WallOptions::min, &WallOptions::max})
                EXPECT_LT(length(e.config().walls.*side + e.scene.origin -
                                 other->config().walls.*side - built.origin),
                          1e-12);
        };
        for (long pair = 0; pair < pairs / 2 && !testing::Test::HasFailure(); ++pair) {
            SCOPED_TRACE(pair);
            const DocumentPtr a =
                with_other_rules(r, r.one_in(2) ? first : e.editor->document(), *first->scene);
            const DocumentPtr b = with_other_rules(r, r.one_in(2) ? first : a, *first->scene);
            e.editor->synchronise(a);
            EXPECT_EQ(e.editor->document(), a);
            if (pair % 8 == 0) as_built(a);
            const SimulationConfig rules = e.config();
            const HandsOptions hands = e.hands;
            e.editor->synchronise(b);
            EXPECT_EQ(e.editor->document(), b);
            as_built(b);
            e.editor->synchronise(a);
            EXPECT_EQ(differs_in_place(e.config(), rules), "");
            EXPECT_EQ(e.hands.zoom, hands.zoom);
            EXPECT_TRUE(equal(e.hands.at, hands.at));
            if (e.nodes >= 0) {
                EXPECT_EQ(e.nodes, a->scene->surface_nodes);
            }
        }
        EXPECT_LE(skipped, pairs / 20);
        e.editor->synchronise(first);
        EXPECT_EQ(differs_in_place(e.config(), e.scene.setup), "");
    }
}

// Mass of the clay of each object.
std::vector<std::pair<std::size_t, double>> clay_of(const Edited& e)
{
    std::vector<std::pair<std::size_t, double>> all;
    const std::vector<Particle<double>> particles = e.solver.particles();
    for (const auto& o : e.editor->document()->objects) {
        const int number = e.editor->simulated(o->id).at(0);
        const auto count = std::size_t(
            std::ranges::count(particles, number, [](const auto& p) { return p.object; }));
        all.emplace_back(count, double(count) * e.config().materials.at(std::size_t(number)).mass);
    }
    return all;
}

DocumentPtr with_other_objects(Random& r, DocumentPtr d, IdSource& ids)
{
    for (int n = 1 + r.below(3); n > 0; --n) {
        const auto& all = d->objects;
        if (!all.empty() && r.one_in(2)) {
            d = after(d, RemoveObjects{{r.of(all)->id}}, ids);
            continue;
        }
        SceneObject o;
        o.source.shape = r.of(std::vector{ShapeKind::sphere, ShapeKind::box, ShapeKind::cylinder});
        o.source.size = {0.09, 0.09, 0.09};
        o.material = r.of(material_specs()), o.category = r.below(3);
        o.pose = {random_rotation(r), {r.in(0.2, 0.44), r.in(0.2, 0.44), r.in(0.2, 0.44)}};
        d = after(d, AddObject{o}, ids);
    }
    return d;
}

TEST(SceneEditor, AddsAndRemovesTheClayOfObjects)
{
    const long pairs = repeats(sanitized ? 5 : 40, 3000);
    Random r(5);
    Edited e(Edited::built(three_objects()));
    long refused = 0, added = 0;
    for (long pair = 0; pair < pairs; ++pair) {
        SCOPED_TRACE(pair);
        const DocumentPtr a = e.editor->document();
        const auto before = clay_of(e);
        const std::vector<Particle<double>> particles = e.solver.particles();
        const DocumentPtr b = with_other_objects(r, a, e.ids);
        try {
            e.editor->synchronise(b);
        } catch (const std::invalid_argument& why) {
            EXPECT_NE(std::string(why.what()).find("other clay fills"), std::string::npos)
                << why.what();
            EXPECT_EQ(e.editor->document(), a);
            EXPECT_TRUE(same_bits(e.solver.particles(), particles));
            EXPECT_EQ(clay_of(e), before);
            ++refused;
            continue;
        }
        ASSERT_EQ(e.editor->document(), b);
        const auto now = clay_of(e);
        std::size_t sum = 0;
        for (const auto& [count, mass] : now) {
            sum += count;
            EXPECT_GT(mass, 0);
        }
        EXPECT_EQ(sum, e.solver.particles().size()) << "clay of no object";
        for (std::size_t i = 0; i < b->objects.size(); ++i) {
            const SceneObject& o = *b->objects[i];
            if (a->find(o.id)) {
                const auto at =
                    std::ranges::find(a->objects, o.id, &SceneObject::id) - a->objects.begin();
                EXPECT_EQ(now[i], before[std::size_t(at)]) << "that of others stays";
                continue;
            }
            ++added;
            // As much as there would be alone, but for room that other clay has.
            const double volume = shape_volume(object_of(o));
            const double most = o.material.density * volume;
            EXPECT_LT(now[i].second, 1.1 * most);
            const Material<double>& m =
                e.config().materials.at(std::size_t(e.editor->simulated(o.id).at(0)));
            EXPECT_EQ(m.category, o.category);
            EXPECT_EQ(m.density, o.material.density);
            EXPECT_EQ(m.mu, made(o.material).mu);
        }
    }
    EXPECT_GT(added, pairs / 4);
    EXPECT_LT(refused, pairs / 2);
}

// An object that comes alone into an empty place is the one that a scene has of it.
TEST(SceneEditor, NewClayIsThatOfAScene)
{
    Edited e(Edited::built(three_objects()));
    SceneObject o;
    o.source.size = {0.12, 0.12, 0.12}, o.material = material_spec("clay");
    o.pose = {{1, 0, 0, 0}, {0.42, 0.4, 0.2}};
    const CommandAnswer answer = e.editor->apply(AddObject{o});
    ASSERT_FALSE(answer.refusal) << answer.refusal->text();
    EXPECT_EQ(std::get<AddObject>(answer.applied).object.id.value, 4u);
    const Scene built = Edited::built(scene_of(three_objects(), *e.editor->document()));
    ASSERT_EQ(built.setup.particles.size(), e.solver.particles().size());
    const int number = e.editor->simulated({4}).at(0);
    EXPECT_EQ(number, 3);
    EXPECT_EQ(differs(e.config(), cpu_solver(built.setup)->config()), "");
}

// Wherever an edit fails, the document, the rules and the clay are as before.
TEST(SceneEditor, AFailureInTheMiddleLeavesAllAsItWas)
{
    const long pairs = repeats(sanitized ? 10 : 25, 1000);
    Random r(11);
    Edited e(Edited::built(three_objects()));
    const DocumentPtr first = e.editor->document();
    long failures = 0;
    for (long pair = 0; pair < pairs && !testing::Test::HasFailure(); ++pair) {
        SCOPED_TRACE(pair);
        const DocumentPtr a = e.editor->document();
        DocumentPtr b = with_other_rules(r, a, *first->scene);
        if (r.one_in(2)) b = with_other_objects(r, b, e.ids);
        if (r.one_in(2) && !b->objects.empty())
            b = after(b,
                      PlaceObject{b->objects[0]->id, Vec3<double>{0.3, r.in(0.25, 0.4), 0.3},
                                  random_rotation(r)},
                      e.ids);
        const SimulationConfig rules = e.config();
        const std::vector<Particle<double>> particles = e.solver.particles();
        const auto clay = clay_of(e);
        const HandsOptions hands = e.hands;
        const auto as_before = [&] {
            EXPECT_EQ(e.editor->document(), a);
            EXPECT_EQ(differs_in_place(e.config(), rules), "");
            EXPECT_TRUE(same_bits(e.solver.particles(), particles));
            EXPECT_EQ(clay_of(e), clay);
            EXPECT_EQ(e.hands.zoom, hands.zoom);
            EXPECT_TRUE(std::ranges::equal(e.hands.held, hands.held));
        };
        for (int n = 1; n < 20; ++n) {
            e.solver.left = n;
            try {
                e.editor->synchronise(b);
                break;
            } catch (const std::exception& why) {
                e.solver.left = -1;
                as_before();
                if (std::string(why.what()) != "the simulator refuses") break;
                ++failures;
            }
        }
        e.solver.left = -1;
        if (e.editor->document() != b) continue;
        // The surface is the last to change.
        const DocumentPtr c =
            after(with_other_rules(r, b, *first->scene), SetSurface{50 + int(pair % 2)}, e.ids);
        const SimulationConfig of_b = e.config();
        const int nodes = e.nodes;
        const HandsOptions hands_of_b = e.hands;
        e.surface_fails = true;
        EXPECT_THROW(e.editor->synchronise(c), std::bad_alloc);
        e.surface_fails = false;
        EXPECT_EQ(e.editor->document(), b);
        EXPECT_EQ(differs_in_place(e.config(), of_b), "");
        EXPECT_EQ(e.nodes, nodes);
        EXPECT_EQ(e.hands.zoom, hands_of_b.zoom);
        EXPECT_TRUE(equal(e.hands.at, hands_of_b.at));
    }
    EXPECT_GT(failures, pairs);
}

// Walls that the lattice has no room for, behind changes that the simulator takes.
TEST(SceneEditor, WallsThatDoNotFitLeaveWhatPrecedesThem)
{
    Edited e(Edited::built(three_objects()));
    const DocumentPtr a = e.editor->document();
    const SimulationConfig rules = e.config();
    IdSource ids(100);
    DocumentPtr b = after(a, SetMaterial{ObjectId{1}, material_spec("snow")}, ids);
    b = after(b, SetGravity{{1, 2, 3}}, ids);
    b = after(b, SetWalls{Vec3<double>{-5, -5, -5}, {}, {}, {}}, ids);
    EXPECT_THROW(e.editor->synchronise(b), std::invalid_argument);
    EXPECT_EQ(e.editor->document(), a);
    EXPECT_EQ(differs_in_place(e.config(), rules), "");
    // As a command: with its field.
    const CommandAnswer answer = e.editor->apply(SetWalls{Vec3<double>{-5, -5, -5}, {}, {}, {}});
    ASSERT_TRUE(answer.refusal);
    EXPECT_NE(answer.refusal->why.find("the walls need"), std::string::npos)
        << answer.refusal->text();
    EXPECT_EQ(e.editor->document(), a);
}

// One frame of the right hand's palm at a place [m of the simulation].
FrameResult palm_at(Vec3<double> at)
{
    FrameResult frame;
    frame.motion.to.resize(2 * joint_count, {{1, 0, 0, 0}, {0, 0, 0}});
    frame.motion.to[std::size_t(int(right) * int(joint_count) + int(palm))] = {{1, 0, 0, 0}, at};
    return frame;
}

TEST(SceneEditor, CarriesWithThePalmWithoutGravity)
{
    Edited e(Edited::built(three_objects()));
    const auto gravity = [&] { return e.config().gravity.y; };
    const auto centre = [&](unsigned id) { return e.editor->document()->find({id})->pose.p; };
    const Vec3<double> first = centre(1);
    ASSERT_FALSE(e.editor->apply(Carry{{ObjectRef("ball")}, right, true}).refusal);
    EXPECT_TRUE(e.editor->carries());
    EXPECT_EQ(gravity(), 0);
    EXPECT_EQ(e.editor->document()->scene->gravity.y, -9.81) << "that of the document stays";
    // From the first frame on the object moves as the palm does.
    e.editor->after_frame(palm_at({0.1, 0.1, 0.1}));
    EXPECT_TRUE(equal(centre(1), first));
    e.editor->after_frame(palm_at({0.12, 0.13, 0.1}));
    EXPECT_LT(length(centre(1) - first - Vec3<double>{0.02, 0.03, 0}), 1e-12);
    // Beyond a wall it waits until the palm is back.
    const Vec3<double> before = centre(1);
    for (double x = 0.2; x < 0.9; x += 0.08) e.editor->after_frame(palm_at({x, 0.13, 0.1}));
    const Vec3<double> at_wall = centre(1);
    EXPECT_LT(at_wall.x, 0.64);
    e.editor->after_frame(palm_at({0.88, 0.13, 0.1}));
    EXPECT_TRUE(equal(centre(1), at_wall));
    for (double x = 0.8; x > 0.15; x -= 0.08) e.editor->after_frame(palm_at({x, 0.13, 0.1}));
    e.editor->after_frame(palm_at({0.13, 0.13, 0.1}));
    EXPECT_LT(length(centre(1) - before - Vec3<double>{0.01, 0, 0}), 1e-12);
    // A hand that is lost and found elsewhere does not take it along.
    const Vec3<double> held = centre(1);
    e.editor->after_frame(palm_at({5, 0.13, 0.1}));
    e.editor->after_frame(palm_at({0.13, 0.13, 0.1}));
    EXPECT_TRUE(equal(centre(1), held));
    // Gravity that is set meanwhile comes when the last is let go.
    ASSERT_FALSE(e.editor->apply(SetGravity{{0, -5, 0}}).refusal);
    EXPECT_EQ(gravity(), 0);
    ASSERT_FALSE(e.editor->apply(Carry{{ObjectRef("block")}, left, true}).refusal);
    ASSERT_FALSE(e.editor->apply(Carry{{ObjectRef("ball")}, right, false}).refusal);
    EXPECT_EQ(gravity(), 0);
    ASSERT_FALSE(e.editor->apply(Carry{{ObjectRef("block")}, right, false}).refusal);
    EXPECT_FALSE(e.editor->carries());
    EXPECT_EQ(gravity(), -5);
    const Vec3<double> left_there = centre(1);
    e.editor->after_frame(palm_at({0.2, 0.13, 0.1}));
    EXPECT_TRUE(equal(centre(1), left_there));
    // What is carried may be removed.
    ASSERT_FALSE(e.editor->apply(Carry{{ObjectRef("drum")}, right, true}).refusal);
    EXPECT_EQ(gravity(), 0);
    ASSERT_FALSE(e.editor->apply(RemoveObjects{{ObjectRef("drum")}}).refusal);
    EXPECT_FALSE(e.editor->carries());
    EXPECT_EQ(gravity(), -5);
    // A simulator that refuses gravity leaves the hand empty.
    e.solver.left = 1;
    EXPECT_TRUE(e.editor->apply(Carry{{ObjectRef("ball")}, right, true}).refusal);
    e.solver.left = -1;
    EXPECT_FALSE(e.editor->carries());
    // A locked object is not carried.
    ASSERT_FALSE(e.editor->apply(SetFlags{ObjectRef("ball"), true, {}}).refusal);
    EXPECT_EQ(
        e.editor->apply(Carry{{ObjectRef("ball")}, right, true}).refusal.value_or(Refusal{}).field,
        "objects");
}

TEST(SceneEditor, PlacesAnObjectAsARigidBody)
{
    Edited e(Edited::built(three_objects()));
    const std::vector<Particle<double>> before = e.solver.particles();
    const double half = std::sqrt(0.5);
    const Quat<double> turn{half, half, 0, 0};
    ASSERT_FALSE(
        e.editor->apply(PlaceObject{ObjectRef("ball"), Vec3<double>{0.3, 0.35, 0.25}, turn})
            .refusal);
    const std::vector<Particle<double>> now = e.solver.particles();
    ASSERT_EQ(now.size(), before.size());
    Vec3<double> sum{};
    int count = 0;
    for (const Particle<double>& p : now)
        if (p.object == 0) sum = sum + p.x, ++count;
    EXPECT_LT(length(1.0 / count * sum + e.scene.origin - Vec3<double>{0.3, 0.35, 0.25}), 2e-3);
    const CommandAnswer answer =
        e.editor->apply(PlaceObject{ObjectRef("ball"), Vec3<double>{0.3, 0.6, 0.25}, {}});
    ASSERT_TRUE(answer.refusal);
    EXPECT_EQ(answer.refusal->field, "centre");
    EXPECT_TRUE(same_bits(e.solver.particles(), now));
    // The same place again is no edit.
    const int made = e.solver.made;
    ASSERT_FALSE(
        e.editor->apply(PlaceObject{ObjectRef("ball"), Vec3<double>{0.3, 0.35, 0.25}, turn})
            .refusal);
    EXPECT_EQ(e.solver.made, made);
}

// Each command costs the edit that it stands for, and no other.
TEST(SceneEditor, MakesTheEditsOfTheDifferenceOnly)
{
    Edited e(Edited::built(three_objects()));
    const auto edits_of = [&](const Command& command) {
        const int before = e.solver.made;
        const CommandAnswer answer = e.editor->apply(command);
        EXPECT_FALSE(answer.refusal) << answer.refusal->text();
        return e.solver.made - before;
    };
    EXPECT_EQ(edits_of(SetGravity{{0, -1, 0}}), 1);
    EXPECT_EQ(edits_of(SetGravity{{0, -1, 0}}), 0);
    EXPECT_EQ(edits_of(SetMaterial{ObjectId{1}, material_spec("snow")}), 1);
    EXPECT_EQ(edits_of(SetCategory{ObjectId{1}, 7}), 1);
    EXPECT_EQ(edits_of(Rename{ObjectId{1}, "new"}), 0);
    EXPECT_EQ(edits_of(SetFlags{ObjectId{1}, {}, true}), 0);
    EXPECT_EQ(edits_of(SetSurface{30}), 0);
    EXPECT_EQ(edits_of(SetHands{{}, {{}, "knife"}, {}, {}}), 1);
    EXPECT_EQ(edits_of(SetWalls{{}, {}, ContactMode::slip, 0.1}), 1);
    EXPECT_EQ(edits_of(PlaceObject{ObjectId{1}, Vec3<double>{0.2, 0.3, 0.2}, {}}), 1);
    EXPECT_EQ(edits_of(RemoveObjects{{ObjectId{1}, ObjectId{2}}}), 1);
}

TEST(SceneEditor, OfASimulatorWithoutEditsTakesNamesFlagsAndTheSurface)
{
    Edited e(Edited::built(three_objects()));
    int nodes = 0;
    SceneEditor plain({e.scene, e.splats, e.loop, nullptr, [](const HandsOptions&) { FAIL(); },
                       [&](int n) { nodes = n; }},
                      e.editor->document(), e.ids);
    EXPECT_FALSE(plain.apply(Rename{ObjectId{1}, "new"}).refusal);
    EXPECT_FALSE(plain.apply(SetFlags{ObjectId{1}, {}, true}).refusal);
    EXPECT_FALSE(plain.apply(SetSurface{40}).refusal);
    EXPECT_EQ(nodes, 40);
    EXPECT_TRUE(plain.move({1}, {{1, 0, 0, 0}, {0, 0.01, 0}}));
    for (const Command& command :
         {Command(SetGravity{{0, 0, 0}}), Command(SetMaterial{ObjectId{1}, material_spec("snow")}),
          Command(RemoveObjects{{ObjectId{1}}}), Command(SetCategory{ObjectId{1}, 4}),
          Command(SetHands{{}, {}, 3.0, {}})}) {
        const CommandAnswer answer = plain.apply(command);
        ASSERT_TRUE(answer.refusal);
        EXPECT_NE(answer.refusal->why.find("takes no edits"), std::string::npos);
    }
    EXPECT_NE(needs_edits(plain.situation(true)), "");
}

}  // namespace
}  // namespace knead
