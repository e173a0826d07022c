// What is done beside the hands of a recording: its file, and that it is played to the same bits.
#include <gtest/gtest.h>

#include "host/base/errors.h"
#include "host/live/live_session.h"
#include "host/run/run.h"
#include "host/scene/seed.h"
#include "host/scene/soften.h"
#include "host/session/action_replay.h"
#include "tests/sanitized.h"
#include "tests/solver/same_bits.h"

namespace knead {
namespace {

HandActions one_of_each()
{
    HandActions actions{"scenes/ball.json", {"domain.cells=16"}, "0123", {}};
    const auto add = [&](ActionType act) -> HandAction& {
        HandAction a;
        a.act = act, a.time = double(actions.all.size()) / 3;
        actions.all.push_back(a);
        return actions.all.back();
    };
    add(ActionType::began).by = "reset";
    add(ActionType::pause).on = true;
    HandAction& material = add(ActionType::material);
    material.object = 3, material.material = preset("dough");
    add(ActionType::gravity).gravity = {0.1, -1.0 / 3, 2};
    HandsOptions& hands = add(ActionType::hands).hands;
    hands.zoom = 1.0 / 7, hands.at = {1e-17, 2, -3};
    hands.held[left] = "knife", hands.present[right] = false;
    add(ActionType::move).motion = {turn_about(Vec3<double>{0.6, 0.8, 0}, 0.3), {1.0 / 3, 0, 0}};
    return actions;
}

TEST(HandActions, AreReadAsTheyWereWrittenToTheBit)
{
    const HandActions wrote = one_of_each();
    const std::string text = to_text(wrote);
    const HandActions read = parse_actions(text, "x");
    EXPECT_EQ(to_text(read), text);
    ASSERT_EQ(read.all.size(), 6u);
    EXPECT_EQ(read.settings, wrote.settings);
    EXPECT_EQ(read.all[2].material.lambda, wrote.all[2].material.lambda);
    EXPECT_EQ(read.all[2].material.plasticity, wrote.all[2].material.plasticity);
    EXPECT_EQ(read.all[3].gravity.y, -1.0 / 3);
    EXPECT_EQ(read.all[4].hands.held[left], "knife");
    EXPECT_FALSE(read.all[4].hands.present[right]);
    EXPECT_EQ(read.all[5].motion.q.w, wrote.all[5].motion.q.w);
}

std::string swapped(std::string text, const std::string& from, const std::string& to)
{
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

TEST(HandActions, OfAHostileFileAreRefusedWithTheirPlace)
{
    const std::string good = to_text(one_of_each());
    const std::vector<std::pair<std::string, std::string>> spoilt{
        {"knead.actions/1", "knead.actions/9"},
        {"\"scene\"", "\"scheme\""},
        {"\"do\":\"pause\"", "\"do\":\"paint\""},
        {"\"object\":3", "\"object\":-3"},
        {"\"object\":3", "\"object\":3.5"},
        {"\"object\":3,", ""},
        {"\"density\":", "\"density\":-"},
        {"\"mu\":", "\"mu\":1e300,\"mo\":"},
        {"\"plasticity\":\"", "\"plasticity\":\"wishful-"},
        {"\"elasticity\":\"neo-hookean", "\"elasticity\":\"fixed-corotated"},
        {"\"knife\"", "\"../../etc/passwd\""},
        {"\"zoom\":0", "\"zoom\":-0"},
        {"\"turn_w\":0.9", "\"turn_w\":0.1"},
        {"\"time\":1.0", "\"time\":0.1"},
        {"\"time\":1.0", "\"time\":1e400"},
        {"\"by\":\"reset\"", "\"by\":\"magic\""},
        {"[0.1,", "[null,"},
        {"\"actions\": [", "\"actions\": [7,"},
        {"\n}\n", "\n"}};
    for (const auto& [from, to] : spoilt) {
        SCOPED_TRACE(from + " -> " + to);
        try {
            parse_actions(swapped(good, from, to), "my.actions");
            ADD_FAILURE() << "it was taken";
        } catch (const InputError& e) {
            EXPECT_EQ(std::string(e.what()).find("my.actions"), 0u) << e.what();
        }
    }
    for (std::size_t end = 0; end < good.size() - 2; end += 37)
        EXPECT_THROW(parse_actions(good.substr(0, end), "x"), InputError) << end;
    EXPECT_THROW(read_actions("/nowhere/at/all.actions"), InputError);
    if (sanitized) return;
    HandActions many{"", {}, "", std::vector<HandAction>(most_actions + 1)};
    for (HandAction& a : many.all) a.by = "reset";
    EXPECT_THROW(parse_actions(to_text(many), "x"), InputError);
}

// A session as a headset leads it: for each picture of the display hands are pushed and time goes
// on, and in between something is done.
struct Shaped {
    Recording hands;
    std::vector<HandAction> actions;
    std::vector<Particle<double>> particles;
    int frames = 0;
};

// With Young's modulus of 0.5 MPa.
Material<double> stiff_jelly() { return softer(preset("jelly"), 1 / 50.0); }

Shaped shaped(const std::shared_ptr<const LiveScene>& scene, double display)
{
    Shaped end;
    double now = 0;
    LiveOptions options;
    options.make_solver = [](const Setup& setup) { return cpu_solver(setup); };
    options.stepped = true, options.recorded = false;
    options.on_action = [&](HandAction done) {
        done.time = now;
        end.actions.push_back(done);
    };
    LiveSession session(scene, options);
    session.wait_for_commands();
    const HandsOptions usual = session.state()->hands;
    end.hands.name = "display", end.hands.rate = display;
    const HandStream recorded = [&] {
        HandsOptions plain = usual;
        plain.zoom = 1, plain.at = {0, 0, 0}, plain.filter = Filter::none;
        HandStream stream(plain);
        for (const HandFrame& frame : scene->recording->frames) stream.push(frame);
        return stream;
    }();
    for (int k = 1; k < int(1.3 * display); ++k) {
        const double done = double(k) / display;
        const auto at = [&](double when) { return done >= when && done < when + 1 / display; };
        HandsOptions hands = usual;
        if (at(0.3)) session.set_material(0, stiff_jelly());
        if (at(0.5)) session.set_gravity({0, -3, 1});
        if (at(0.6)) hands.held[right] = "knife", session.set_hands(hands);
        if (at(0.7)) hands.present[left] = hands.present[right] = false, session.set_hands(hands);
        if (at(0.75)) session.move_clay(0, {{1, 0, 0, 0}, {0.01, 0, 0}});
        if (at(0.8)) hands.zoom *= 1.1, session.set_hands(hands);
        if (at(0.85)) session.set_material(99, preset("snow"));
        now = done;
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
        end.hands.frames.push_back(frame);
        session.push(frame);
        session.advance_to(now);
    }
    end.frames = session.state()->frame.number;
    EXPECT_EQ(session.state()->refused, 1) << session.state()->refusal;
    session.inspect_solver([&](const Simulator& s) { end.particles = s.particles(); });
    return end;
}

TEST(HandActions, ArePlayedByARunToTheSameBits)
{
    for (const double display : {90.0, 72.0, 120.0}) {
        if (sanitized && display == 120) continue;
        SCOPED_TRACE(display);
        std::vector<std::string> settings{"domain.cells=16", "surface.nodes=16",
                                          "step.courant=0.9"};
        if (display == 72) settings.push_back("step.soften_beyond=4");
        const auto scene = load_live_scene("scenes/squeeze.json", settings);
        EXPECT_EQ(display == 72, softening(scene->scene, stiff_jelly()) > 1);
        const Shaped made = shaped(scene, display);
        ASSERT_EQ(made.actions.size(), 7u);
        EXPECT_GT(made.frames, 80);
        const auto play = [&](const std::vector<HandAction>& actions, int& refused) {
            const std::unique_ptr<EditableSimulator> solver = cpu_solver(scene->scene.setup);
            SceneSplats splats(scene->scene, scene->splats);
            ActionReplay replay(made.hands, scene->scene.hands, scene->scene.frame_rate, actions);
            const HandSource hands(made.hands, scene->scene.hands);
            BatchRunOptions options;
            options.frames = made.frames, options.audit_every = 1000000;
            RunObserver watch;
            watch.motion = [&](double from, double to) { return replay.motion(from, to); };
            watch.edits = [&](int number, SessionLoop& loop) {
                replay.before_frame(number, loop, splats, [&](const std::string&) { ++refused; });
            };
            run_frames(scene->scene, *solver, &hands, options, watch);
            return solver->particles();
        };
        int refused = 0;
        EXPECT_TRUE(same_bits(play(made.actions, refused), made.particles));
        EXPECT_EQ(refused, 1);
        // Each of them matters, but for what was refused.
        for (std::size_t i = 0; display == 90 && i < made.actions.size(); i += sanitized ? 6 : 2) {
            std::vector<HandAction> fewer = made.actions;
            fewer.erase(fewer.begin() + std::ptrdiff_t(i));
            EXPECT_EQ(same_bits(play(fewer, refused), made.particles), i == 6) << i;
        }
    }
}

}  // namespace
}  // namespace knead
