// What was done beside the hands of a recording: older files of it are read, and a log of commands,
// and an older file, is played by a run to the same bits.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/document/actions_file.h"
#include "host/document/document_text.h"
#include "host/live/live_session.h"
#include "host/live/session_record.h"
#include "host/run/run.h"
#include "host/scene/names.h"
#include "host/scene/presets.h"
#include "host/scene/seed.h"
#include "host/scene/soften.h"
#include "host/session/command_replay.h"
#include "tests/sanitized.h"
#include "tests/solver/same_bits.h"

namespace knead {
namespace {

// A material as older files have it: names with dashes, and the solver's constants.
Json old_json(const Material<double>& m)
{
    const auto dashed = [](std::string name) {
        for (char& c : name) c = c == '_' ? '-' : c;
        return name;
    };
    return {{"elasticity", dashed(name_of(elasticities, m.elasticity))},
            {"plasticity", dashed(name_of(plasticities, m.plasticity))},
            {"density", m.density},
            {"mu", m.mu},
            {"lambda", m.lambda},
            {"bulk", m.bulk},
            {"yield", m.yield},
            {"hardening", m.hardening},
            {"yield_floor", m.yield_floor},
            {"friction", m.friction},
            {"cohesion", m.cohesion},
            {"compress", m.compress},
            {"stretch", m.stretch},
            {"snow", m.snow},
            {"viscosity", m.viscosity},
            {"exponent", m.exponent}};
}

std::string old_file(const std::vector<Json>& actions)
{
    return Json{{"schema", "knead.actions/1"},
                {"scene", "scenes/ball.json"},
                {"settings", {"domain.cells=16"}},
                {"recording", "0123"},
                {"actions", actions}}
               .dump(1) +
           "\n";
}

std::string one_of_each()
{
    const Quat<double> turn = turn_about(Vec3<double>{0.6, 0.8, 0}, 0.3);
    return old_file({{{"time", 0.0}, {"do", "began"}, {"by", "reset"}},
                     {{"time", 1.0 / 3}, {"do", "pause"}, {"on", true}},
                     {{"time", 2.0 / 3},
                      {"do", "material"},
                      {"object", 3},
                      {"material", old_json(preset("dough"))}},
                     {{"time", 1.0}, {"do", "gravity"}, {"gravity", {0.1, -1.0 / 3, 2}}},
                     {{"time", 4.0 / 3},
                      {"do", "hands"},
                      {"hands",
                       {{"zoom", 1.0 / 7},
                        {"at", {1e-17, 2, -3}},
                        {"left", {{"present", true}, {"held", "knife"}}},
                        {"right", {{"present", false}, {"held", ""}}}}}},
                     {{"time", 5.0 / 3},
                      {"do", "move"},
                      {"object", 0},
                      {"turn", {turn.x, turn.y, turn.z}},
                      {"turn_w", turn.w},
                      {"shift", {1.0 / 3, 0, 0}}}});
}

template <class C>
const C& command_of(const LogEntry& entry)
{
    return std::get<C>(std::get<Command>(entry.done));
}

TEST(OldActions, AreReadToTheBitAtTheirFrames)
{
    const ActionsFile read = parse_actions(one_of_each(), "x", 90, {0, 0, 0.5});
    ASSERT_EQ(read.all.size(), 6u);
    EXPECT_EQ(read.scene, "scenes/ball.json");
    EXPECT_EQ(read.settings, std::vector<std::string>{"domain.cells=16"});
    EXPECT_EQ(read.recording, "0123");
    // Each before the first frame that ends later.
    for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(read.all[i].frame, long(30 * i)) << i;
    EXPECT_EQ(command_of<Mark>(read.all[0]).text, "reset");
    EXPECT_TRUE(command_of<Pause>(read.all[1]).on);
    const auto& material = command_of<SetMaterial>(read.all[2]);
    EXPECT_EQ(std::get<ObjectId>(material.object.by).value, 4u);
    EXPECT_TRUE(made(material.material) == preset("dough"));
    EXPECT_EQ(command_of<SetGravity>(read.all[3]).gravity.y, -1.0 / 3);
    const auto& hands = command_of<SetHands>(read.all[4]);
    EXPECT_EQ(hands.zoom, 1.0 / 7);
    EXPECT_EQ(hands.at.value().z, -2.5) << "in the frame of the scene's file";
    EXPECT_EQ(hands.left.held, "knife");
    EXPECT_EQ(hands.left.present, true);
    EXPECT_EQ(hands.right.held, "");
    EXPECT_EQ(hands.right.present, false);
    const auto& moved = std::get<Moved>(read.all[5].done);
    EXPECT_EQ(moved.object.value, 1u);
    EXPECT_EQ(moved.motion.q.w, turn_about(Vec3<double>{0.6, 0.8, 0}, 0.3).w);
    EXPECT_EQ(moved.motion.p.x, 1.0 / 3);
    EXPECT_EQ(actions_file("a.hands"), "a.hands.actions");
}

// The constants of a material come back to the bit, though a document states other quantities.
TEST(OldActions, KeepTheConstantsOfMaterials)
{
    int exact = 0, all = 0;
    for (const MaterialSpec& first : material_specs())
        for (int i = 0; i < 40; ++i) {
            MaterialSpec m = first;
            m.young *= 1 + 0.613 * i, m.poisson *= 1 - 0.011 * i, m.friction_angle *= 1 + 0.01 * i;
            m.density += i;
            if (fault_of(m)) continue;
            const Json action = {
                {"time", 0}, {"do", "material"}, {"object", 0}, {"material", old_json(made(m))}};
            const auto read = parse_actions(old_file({action}), "x", 90, {});
            exact += made(command_of<SetMaterial>(read.all.at(0)).material) == made(m), ++all;
        }
    EXPECT_GT(all, 300);
    EXPECT_EQ(exact, all);
}

std::string swapped(std::string text, const std::string& from, const std::string& to)
{
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

TEST(OldActions, OfAHostileFileAreRefusedWithTheirPlace)
{
    const auto read = [](const std::string& text, const std::string& file) {
        parse_actions(text, file, 90, {});
    };
    const std::string good = one_of_each();
    const std::vector<std::pair<std::string, std::string>> spoilt{
        {"knead.actions/1", "knead.actions/9"},
        {"\"scene\"", "\"scheme\""},
        {"\"do\": \"pause\"", "\"do\": \"paint\""},
        {"\"object\": 3", "\"object\": -3"},
        {"\"object\": 3", "\"object\": 3.5"},
        {"\"object\": 3,", ""},
        {"\"density\": ", "\"density\": -"},
        {"\"mu\": ", "\"mu\": 1e300,\"mo\": "},
        {"\"plasticity\": \"", "\"plasticity\": \"wishful-"},
        {"\"elasticity\": \"neo-hookean", "\"elasticity\": \"fixed-corotated"},
        {"\"knife\"", "\"../../etc/passwd\""},
        {"\"zoom\": 0", "\"zoom\": -0"},
        {"\"turn_w\": 0.9", "\"turn_w\": 0.1"},
        {"\"time\": 1.0", "\"time\": 0.1"},
        {"\"time\": 1.0", "\"time\": 1e400"},
        {"\"by\": \"reset\"", "\"by\": \"magic\""},
        {"    0.1,", "    null,"},
        {"\"actions\": [", "\"actions\": [7,"},
        {"\n}\n", "\n"}};
    for (const auto& [from, to] : spoilt) {
        SCOPED_TRACE(from + " -> " + to);
        try {
            read(swapped(good, from, to), "my.actions");
            ADD_FAILURE() << "it was taken";
        } catch (const InputError& e) {
            EXPECT_EQ(std::string(e.what()).find("my.actions"), 0u) << e.what();
        }
    }
    for (std::size_t end = 0; end < good.size() - 2; end += 37)
        EXPECT_THROW(read(good.substr(0, end), "x"), InputError) << end;
    EXPECT_THROW(read_actions("/nowhere/at/all.actions", 90, {}), InputError);
    if (sanitized) return;
    const Json began = {{"time", 0}, {"do", "began"}, {"by", "reset"}};
    EXPECT_THROW(read(old_file(std::vector<Json>(most_actions + 1, began)), "x"), InputError);
}

// A session as a headset leads it: for each picture of the display hands are pushed and time goes
// on, and in between something is done.
struct Shaped {
    Recording hands;
    CommandLog log;
    DocumentPtr document;
    std::vector<Particle<double>> particles;
    int frames = 0;
};

// With Young's modulus of 0.5 MPa.
MaterialSpec stiff_jelly()
{
    MaterialSpec m = material_spec("jelly");
    m.young *= 50;
    return m;
}

SceneObject pea()
{
    SceneObject o;
    o.name = "pea", o.material = material_spec("dough");
    o.source.size = {0.1, 0.1, 0.1};
    return o;
}

LiveOptions stepped()
{
    LiveOptions options;
    options.make_solver = cpu_solver;
    options.stepped = true, options.recorded = false;
    return options;
}

Shaped shaped(const std::shared_ptr<const LiveScene>& scene, double display)
{
    Shaped end;
    LiveSession session(scene, stepped());
    session.wait_for_commands();
    SessionRecord record([](const std::string& text) { ADD_FAILURE() << text; });
    record.begin(*scene, session.state()->history, 0);
    const HandsOptions usual = session.state()->hands;
    const HandStream recorded = [&] {
        HandsOptions plain = usual;
        plain.zoom = 1, plain.at = {0, 0, 0}, plain.filter = Filter::none;
        HandStream stream(plain);
        for (const HandFrame& frame : scene->recording->frames) stream.push(frame);
        return stream;
    }();
    const ObjectRef ball = ObjectId{1};
    const SetHands absent{{false, {}}, {false, {}}, {}, {}};
    SceneObject more = pea();
    const WallOptions walls = session.state()->document->scene->walls;
    more.pose.p = {walls.min.x + 0.12, walls.max.y - 0.12, walls.min.z + 0.12};
    for (int k = 1; k < int(1.3 * display); ++k) {
        const double now = double(k) / display;
        const auto at = [&](double when) { return k == int(when * display + 0.5); };
        const auto send = [&](const Command& command) { session.send(command); };
        if (at(0.05)) send(Mark{"begin"});
        if (at(0.1)) send(SetSurface{30});
        if (at(0.2)) send(AddObject{more});
        if (at(0.25))
            send(SetCategory{ObjectRef("pea"), 3}), send(Rename{ObjectRef("pea"), "small"});
        if (at(0.3)) send(SetMaterial{ball, stiff_jelly()});
        if (at(0.4)) send(absent), send(Carry{{ball, ObjectRef("small")}, right, true});
        if (at(0.45)) send(SetGravity{{0, -3, 1}});
        if (at(0.5)) send(Carry{{ball}, right, false});
        if (at(0.55)) send(Carry{{ObjectRef("small")}, right, false});
        if (at(0.6)) send(SetHands{{true, {}}, {true, "knife"}, {}, {}});
        if (at(0.7)) send(absent);
        if (at(0.75)) {
            session.wait_for_commands();
            const Vec3<double> centre = session.state()->document->find({1})->pose.p;
            send(PlaceObject{ball, centre + Vec3<double>{0.01, 0, 0}, {}});
        }
        if (at(0.8)) send(SetHands{{true, {}}, {}, usual.zoom * 1.1, {}});
        if (at(0.85)) send(SetMaterial{ObjectId{99}, material_spec("snow")});
        if (at(0.9)) send(SetWalls{{}, {}, ContactMode::slip, 0.2});
        if (at(1.0)) send(RemoveObjects{{ObjectRef("small")}});
        if (at(1.1)) send(SetFlags{ball, true, {}});
        HandFrame frame;
        frame.time = now;
        Joint<double> joints[2 * joint_count];
        float size[side_count];
        recorded.sample(now, joints, size);
        for (int side = 0; side < side_count; ++side) {
            frame.hand[side] = open_hand(Side(side));
            for (int j = 0; j < joint_count; ++j) {
                const Joint<double>& from = joints[side * joint_count + j];
                frame.hand[side].joints[j] = {unit(cast<float>(from.q)), cast<float>(from.p)};
            }
            frame.hand[side].tracked = true;
            frame.hand[side].valid.fill(true);
        }
        EXPECT_TRUE(record.frame(frame, now));
        session.push(frame);
        session.advance_to(now);
        record.add(session.take_applied());
    }
    end.hands = record.hands, end.log = record.commands;
    end.hands.name = "display", end.hands.rate = display;
    end.frames = session.state()->frame.number;
    end.document = session.state()->document;
    EXPECT_EQ(session.state()->refused, 1) << session.state()->refusal;
    EXPECT_EQ(session.state()->failure, "");
    session.inspect_solver([&](const Simulator& s) { end.particles = s.particles(); });
    return end;
}

// A run of the scene with these hands and these entries, as `knead run` plays them.
struct Played {
    std::vector<Particle<double>> particles;
    DocumentPtr document;
    std::vector<std::string> refused;
};
using Watch = std::function<void(int number, SessionLoop&, SceneSplats&, RecordedHands&)>;
Played played(const LiveScene& scene, const Recording& recording, int frames,
              const std::vector<LogEntry>& entries, const Watch& by_hand = {})
{
    Played end;
    const std::unique_ptr<EditableSimulator> solver = cpu_solver(scene.scene.setup);
    SceneSplats splats(scene.scene, scene.splats);
    const HandSource source(recording, scene.scene.hands);
    RecordedHands hands(recording, scene.scene.hands, scene.scene.frame_rate);
    CommandReplay replay(entries);
    IdSource ids;
    std::unique_ptr<SceneEditor> editor;
    BatchRunOptions options;
    options.frames = frames, options.audit_every = 1000000;
    RunObserver watch;
    watch.motion = [&](double from, double to) { return hands.motion(from, to); };
    watch.edits = [&](int number, SessionLoop& loop) {
        if (by_hand) return by_hand(number, loop, splats, hands);
        const auto set_hands = [&](const HandsOptions& to) {
            const HandTools tools = hand_tools(to);
            solver->set_tools(tools.rig, tools.tools);
            splats.set_rig(tools.rig);
            hands.set(to, loop.last().number);
        };
        if (!editor)
            editor = std::make_unique<SceneEditor>(
                SceneEditor::Parts{scene.scene, splats, loop, solver.get(), set_hands, {}},
                std::make_shared<const Document>(document_of(scene.scene)), ids);
        loop.edit([&, number](EditableSimulator&) {
            editor->after_frame(loop.last());
            replay.after_frame(
                number, *editor,
                {[&](const Command& command) { return apply_in_run(*editor, command); },
                 [&](const LogEntry&, const Refusal& why) { end.refused.push_back(why.text()); }});
        });
    };
    run_frames(scene.scene, *solver, &source, options, watch);
    end.particles = solver->particles();
    if (editor) end.document = editor->document();
    return end;
}

std::vector<LogEntry> entries_of(const CommandLog& log)
{
    std::vector<LogEntry> entries;
    for (const LoggedCommand& one : log.commands)
        entries.push_back({one.frame, one.command, one.line});
    return entries;
}

TEST(LoggedCommands, ArePlayedByARunToTheSameBits)
{
    for (const double display : {90.0, 72.0, 120.0}) {
        if (sanitized && display == 120) continue;
        SCOPED_TRACE(display);
        std::vector<std::string> settings{"domain.cells=16", "surface.nodes=16",
                                          "step.courant=0.9"};
        if (display == 72) settings.push_back("step.soften_beyond=4");
        const auto scene = load_live_scene("scenes/squeeze.json", settings);
        EXPECT_EQ(display == 72, softening(scene->scene, made(stiff_jelly())) > 1);
        const Shaped live = shaped(scene, display);
        ASSERT_EQ(live.log.commands.size(), 18u);
        EXPECT_GT(live.frames, 80);
        // Through the text of the log.
        const CommandLog log = parse_command_log(to_text(live.log), "x", ".");
        EXPECT_EQ(log.scene, "scenes/squeeze.json");
        EXPECT_EQ(log.settings, settings);
        const std::vector<LogEntry> entries = entries_of(log);
        const Played run = played(*scene, live.hands, live.frames, entries);
        EXPECT_TRUE(same_bits(run.particles, live.particles));
        EXPECT_TRUE(equal(*run.document, *live.document)) << document_text(*run.document) << "\n"
                                                          << document_text(*live.document);
        EXPECT_TRUE(run.refused.empty()) << run.refused.front();
        // Each of them matters, but those that no particle feels.
        for (std::size_t i = 0; display == 90 && i < entries.size(); i += sanitized ? 6 : 2) {
            const std::string name = row_of(std::get<Command>(entries[i].done)).name;
            std::vector<LogEntry> fewer = entries;
            fewer.erase(fewer.begin() + std::ptrdiff_t(i));
            const Played other = played(*scene, live.hands, live.frames, fewer);
            const bool felt = name != "mark" && name != "set_surface" && name != "set_category" &&
                              name != "set_flags" && name != "rename";
            EXPECT_EQ(!same_bits(other.particles, live.particles), felt) << i << " " << name;
        }
    }
}

// What a headset kept of a session after a reset begins with that: a run begins by itself.
TEST(LoggedCommands, OfASessionAfterAResetArePlayedFromTheBeginning)
{
    const auto scene = load_live_scene("scenes/squeeze.json",
                                       {"domain.cells=16", "surface.nodes=16", "step.courant=0.9"});
    LiveOptions options = stepped();
    options.restarts_time = true;
    LiveSession session(scene, options);
    SessionRecord record([](const std::string& text) { ADD_FAILURE() << text; });
    session.wait_for_commands();
    record.begin(*scene, session.state()->history, 0);
    session.send(SetGravity{{3, 0, 0}});
    session.advance_to(0.2);
    session.send(Reset{});
    session.send(SetGravity{{0, -4, 0}});
    session.wait_for_commands();
    // The commands come before the session's user notices its new history.
    record.add(session.take_applied());
    ASSERT_EQ(record.commands.commands.size(), 1u);
    record.begin(*scene, session.state()->history, 0);
    HandFrame none;
    record.frame(none, 0.01);
    session.advance_to(0.1);
    session.send(PlaceObject{
        ObjectId{1}, session.state()->document->find({1})->pose.p + Vec3<double>{0.01, 0, 0}, {}});
    session.advance_to(0.2);
    record.add(session.take_applied());
    ASSERT_EQ(record.commands.commands.size(), 3u);
    EXPECT_EQ(std::get<Mark>(record.commands.commands[0].command).text, "reset");
    EXPECT_EQ(record.commands.commands[2].frame, 9);
    record.hands.name = "none", record.hands.rate = 90;
    const Played run =
        played(*scene, record.hands, session.state()->frame.number, entries_of(record.commands));
    EXPECT_TRUE(run.refused.empty()) << run.refused.front();
    std::vector<Particle<double>> particles;
    session.inspect_solver([&](const Simulator& s) { particles = s.particles(); });
    EXPECT_TRUE(same_bits(run.particles, particles));
}

// An older file gives the bits of the simulator's edits at the same frames.
TEST(OldActions, ArePlayedAsTheSimulatorsEdits)
{
    const auto scene = load_live_scene("scenes/squeeze.json",
                                       {"domain.cells=16", "surface.nodes=16", "step.courant=0.9"});
    const Material<double> snow = preset("snow");
    const Quat<double> turn = turn_about(Vec3<double>{0, 1, 0}, 0.2);
    const Vec3<double> shift{0.02, 0.01, 0};
    const std::string text = old_file(
        {{{"time", 0.0}, {"do", "began"}, {"by", "scene"}},
         {{"time", 0.1}, {"do", "gravity"}, {"gravity", {0.5, -3, 0}}},
         {{"time", 0.2}, {"do", "material"}, {"object", 0}, {"material", old_json(snow)}},
         {{"time", 0.25}, {"do", "pause"}, {"on", true}},
         {{"time", 0.3},
          {"do", "move"},
          {"object", 0},
          {"turn", {turn.x, turn.y, turn.z}},
          {"turn_w", turn.w},
          {"shift", {shift.x, shift.y, shift.z}}},
         {{"time", 0.35}, {"do", "material"}, {"object", 7}, {"material", old_json(snow)}},
         {{"time", 0.4},
          {"do", "hands"},
          {"hands",
           {{"zoom", 0.9 * scene->scene.hands.zoom},
            {"at", {scene->scene.hands.at.x, scene->scene.hands.at.y, scene->scene.hands.at.z}},
            {"left", {{"present", true}, {"held", ""}}},
            {"right", {{"present", true}, {"held", "rod"}}}}}}});
    const auto read = parse_actions(text, "x", scene->scene.frame_rate, scene->scene.origin);
    const int frames = 100;
    const Played run = played(*scene, *scene->recording, frames, read.all);
    ASSERT_EQ(run.refused.size(), 1u) << "an object that there is not";
    const auto by_hand = [&](int number, SessionLoop& loop, SceneSplats& splats,
                             RecordedHands& hands) {
        loop.edit([&, number](EditableSimulator& s) {
            if (number == 9) s.set_gravity({0.5, -3, 0});
            if (number == 18) splats.set_material(0, snow, s);
            if (number == 27) s.move(0, {turn, shift});
            if (number != 36) return;
            HandsOptions to = scene->scene.hands;
            to.zoom *= 0.9, to.held[right] = "rod";
            const HandTools tools = hand_tools(to);
            s.set_tools(tools.rig, tools.tools);
            hands.set(to, number);
        });
    };
    const Played other = played(*scene, *scene->recording, frames, {}, by_hand);
    EXPECT_TRUE(same_bits(run.particles, other.particles));
    const Played nothing = played(*scene, *scene->recording, frames, {});
    EXPECT_FALSE(same_bits(run.particles, nothing.particles));
    // The document says where the object is now.
    const RigidMotion<double> pose = run.document->find({1})->pose;
    const Vec3<double> first = document_of(scene->scene).objects[0]->pose.p - scene->scene.origin;
    EXPECT_LT(length(pose.p - scene->scene.origin - rotate(turn, first) - shift), 1e-12);
    EXPECT_NEAR(pose.q.y, turn.y, 1e-12);
}

}  // namespace
}  // namespace knead
