// `knead vr` from end to end: objects chosen, moved and scaled by pinches, clay laid by a hand, the
// scene moved by two fists, the same with controllers.
#include "host/document/command_table.h"
#include "host/document/command_text.h"
#include "host/hands/posture.h"
#include "host/live/live_session.h"
#include "host/vr/hand_act.h"
#include "host/vr/headset_view.h"
#include "tests/vr/vr_run.h"
#include "xr/hand_shape.h"

#ifdef KNEAD_XR_PROGRAM
namespace knead {
namespace {

constexpr double hertz = 90;

// A hand whose fingertips are about `place` [m].
Hand hand_at(Side side, const Fingers& fingers, Vec3<double> place)
{
    const Pose pose = posed(side, {{1, 0, 0, 0}, {0, 0, 0}}, fingers);
    const Vec3<double> shift = place - 0.5 * (pose[thumb_tip].p + pose[index_tip].p);
    Hand hand;
    for (std::size_t j = 0; j < joint_count; ++j)
        hand.joints[j] = {cast<float>(pose[j].q), cast<float>(pose[j].p + shift)};
    hand.radius = open_hand(side).radius;
    hand.tracked = true;
    hand.valid.fill(true);
    return hand;
}

class VrObjects : public KneadVr {
  protected:
    VrObjects() { panel = true; }

    struct Pose {
        Fingers fingers;
        Vec3<double> from, to;
    };
    Recording recording;
    // Both hands for a time; of one that is not given, nothing is tracked.
    void act(int frames, const std::optional<Pose>& right_hand,
             const std::optional<Pose>& left_hand = {})
    {
        for (int k = 0; k < frames; ++k) {
            HandFrame frame;
            frame.time = double(recording.frames.size()) / hertz;
            const auto set = [&](Side side, const std::optional<Pose>& pose) {
                if (pose)
                    frame.hand[side] =
                        hand_at(side, pose->fingers,
                                pose->from + (double(k) / frames) * (pose->to - pose->from));
                else
                    for (auto& joint : frame.hand[side].joints) joint = {{0, 0, 0, 0}, {0, 0, 0}};
            };
            set(right, right_hand), set(left, left_hand);
            recording.frames.push_back(frame);
        }
    }
    std::vector<LoggedCommand> played(Json script = squeeze())
    {
        if (!recording.frames.empty()) {
            write_recording(path("in.hands"), recording);
            script["hands"] = path("in.hands");
        } else {
            script.erase("hands");
        }
        script["render_every"] = 1000;
        fs::remove(path("r.hands")), fs::remove(path("r.hands.commands"));
        const std::string frames =
            std::to_string(recording.frames.empty() ? 200 : recording.frames.size() + 5);
        EXPECT_EQ(vr(script, {"--frames", frames, "--record", path("r.hands")}), exit_ok);
        expect_sound();
        EXPECT_EQ(report["simulation"]["trouble"], "");
        if (!fs::exists(path("r.hands.commands"))) return {};
        return read_command_log(path("r.hands.commands"), "").commands;
    }
    static std::vector<std::string> names(const std::vector<LoggedCommand>& all)
    {
        std::vector<std::string> found;
        for (const LoggedCommand& one : all) found.push_back(row_of(one.command).name);
        return found;
    }
    void expect_replayed()
    {
        EXPECT_EQ(report["simulation"]["state_hash"], replayed(path("r.hands")));
    }
    const HandsOptions options = live_hands(load_live_scene("scenes/squeeze.json")->scene);
    // Of the ball, in the frame of the hands.
    const double radius = 0.25 / options.zoom;
    const Fingers open = gripped(0.1), pinch = pinched(right), fist = gripped(1);
};

using Names = std::vector<std::string>;

TEST_F(VrObjects, a_pinch_takes_the_ball_and_puts_it_down_elsewhere)
{
    recording = poking(Control::choose);
    const Vec3<double> top{0, radius + 0.005, 0}, higher = top + Vec3<double>{0.03, 0.04, 0};
    act(20, Pose{open, top, top}), act(10, Pose{pinch, top, top});
    act(40, Pose{pinch, top, higher}), act(10, Pose{pinch, higher, higher});
    act(20, Pose{open, higher, higher});
    const auto done = played();
    ASSERT_EQ(names(done), (Names{"set_hands", "move_objects"}));
    const MoveObjects& moves = std::get<MoveObjects>(done[1].command);
    EXPECT_EQ(moves.objects.size(), 1u);
    ASSERT_TRUE(moves.by);
    const Vec3<double> by = options.zoom * (higher - top);
    EXPECT_LT(length(*moves.by - by), 0.05 * length(by)) << moves.by->x << " " << moves.by->y;
    EXPECT_FALSE(moves.turn);
    expect_replayed();
}

TEST_F(VrObjects, a_ray_takes_what_is_out_of_reach)
{
    recording = poking(Control::choose);
    // Between the shoulder of a head at the origin and the ball.
    const Vec3<double> shoulder{0.19, 0, 0.46}, from = 0.35 * shoulder,
                                                to = from + Vec3<double>{0, 0.05, 0};
    act(20, Pose{open, from, from}), act(10, Pose{pinch, from, from});
    act(30, Pose{pinch, from, to}), act(20, Pose{open, to, to});
    EXPECT_EQ(names(played()), (Names{"set_hands", "move_objects"}));
}

TEST_F(VrObjects, two_pinches_scale_it_and_the_other_fist_cancels)
{
    recording = poking(Control::choose);
    const Vec3<double> l{-0.045, radius, 0}, r{0.045, radius, 0}, near_l{-0.03, radius, 0},
        near_r{0.03, radius, 0};
    const Fingers pinch_left = pinched(left);
    act(20, Pose{open, r, r}, Pose{open, l, l}), act(10, Pose{pinch, r, r}, Pose{open, l, l});
    act(10, Pose{pinch, r, r}, Pose{pinch_left, l, l});
    act(30, Pose{pinch, r, near_r}, Pose{pinch_left, l, near_l});
    act(10, Pose{pinch, near_r, near_r}, Pose{pinch_left, near_l, near_l});
    act(20, Pose{open, near_r, near_r}, Pose{open, near_l, near_l});
    const auto done = played();
    ASSERT_GE(done.size(), 2u);
    const ScaleObjects* scaled = nullptr;
    for (const LoggedCommand& one : done)
        if (const auto* scale = std::get_if<ScaleObjects>(&one.command)) scaled = scale;
    ASSERT_TRUE(scaled) << testing::PrintToString(names(done));
    EXPECT_NEAR(scaled->factor, 1 / 1.5, 0.04);
    expect_replayed();

    recording = poking(Control::choose);
    act(20, Pose{open, r, r}, Pose{open, l, l}), act(10, Pose{pinch, r, r}, Pose{open, l, l});
    act(20, Pose{pinch, r, r + Vec3<double>{0, 0.1, 0}}, Pose{open, l, l});
    act(20, Pose{pinch, r + Vec3<double>{0, 0.1, 0}, r + Vec3<double>{0, 0.1, 0}},
        Pose{fist, l, l});
    act(20, Pose{open, r, r}, Pose{open, l, l});
    EXPECT_EQ(names(played()), Names{"set_hands"}) << "nothing was moved";
}

TEST_F(VrObjects, a_pinch_lays_clay_along_its_way)
{
    recording = poking(Control::lay);
    const Vec3<double> from{-0.08, radius + 0.06, 0}, to{0.08, radius + 0.06, 0};
    act(20, Pose{open, from, from}), act(10, Pose{pinch, from, from});
    act(60, Pose{pinch, from, to}), act(20, Pose{open, to, to});
    const auto done = played();
    const Names found = names(done);
    ASSERT_GT(found.size(), 6u);
    EXPECT_EQ(found[0], "set_hands");
    EXPECT_EQ(found[1], "source_begin");
    for (std::size_t i = 2; i + 1 < found.size(); ++i) EXPECT_EQ(found[i], "source_move") << i;
    EXPECT_EQ(found.back(), "source_end");
    const SourceBegin& begins = std::get<SourceBegin>(done[1].command);
    const Vec3<double> at = options.at + options.zoom * from;
    EXPECT_LT(length(begins.at - at), 0.05 * length(options.zoom * (to - from)));
    EXPECT_EQ(begins.diameter, UiState().diameter);
    const int with = report["simulation"]["particles"];
    expect_replayed();
    recording = poking(Control::lay);
    played();
    EXPECT_GT(with, report["simulation"]["particles"].get<int>());
}

TEST_F(VrObjects, two_fists_turn_and_zoom_the_scene_and_leave_the_clay)
{
    recording = poking(Control::choose);
    const Vec3<double> l{-0.15, 0.2, 0}, r{0.15, 0.2, 0};
    act(20, Pose{open, r, r}, Pose{open, l, l}), act(10, Pose{fist, r, r}, Pose{fist, l, l});
    act(40, Pose{fist, r, r + Vec3<double>{0.1, 0, 0.1}},
        Pose{fist, l, l - Vec3<double>{0.1, 0, 0.1}});
    act(30, Pose{open, r, r}, Pose{open, l, l});
    const auto done = played();
    ASSERT_EQ(names(done), (Names{"set_hands", "set_hands"}));
    const SetHands& zoomed = std::get<SetHands>(done[1].command);
    ASSERT_TRUE(zoomed.zoom);
    EXPECT_LT(*zoomed.zoom, 0.75 * options.zoom);
    EXPECT_GT(*zoomed.zoom, 0.5 * options.zoom);
    expect_replayed();
}

// Added from the panel, it is with the hand until that pinches; a fist cancels.
TEST_F(VrObjects, a_pinch_puts_down_what_is_added)
{
    const auto adding = [&] {
        return poking([](PanelDriver& finger, PanelSession&) {
            finger.choose({Control::add, 0}, 2);
        });
    };
    const Vec3<double> aside{0.13, 0.05, 0}, higher{0.13, 0.1, 0};
    recording = adding();
    act(20, Pose{open, aside, aside}), act(10, Pose{pinch, aside, aside});
    act(20, Pose{pinch, aside, higher}), act(10, Pose{pinch, higher, higher});
    act(20, Pose{open, higher, higher});
    const auto done = played();
    ASSERT_EQ(names(done), (Names{"set_hands", "add_object", "set_hands"}));
    const SceneObject& box = std::get<AddObject>(done[1].command).object;
    EXPECT_EQ(box.source.shape, ShapeKind::box);
    EXPECT_LT(length(box.pose.p - options.at - options.zoom * higher), 0.03);
    expect_replayed();

    recording = adding();
    act(20, Pose{open, aside, aside}), act(20, Pose{fist, aside, aside});
    EXPECT_EQ(names(played()), (Names{"set_hands", "set_hands"}));
}

class VrControllers : public VrObjects {
  protected:
    VrControllers()
    {
        panel = false;
        HandReader reader;
        TrackedHand held;
        held.hand = xr::hand_around(right, {{1, 0, 0, 0}, {0, 0, 0}}, 0, 0);
        held.from = HandFrom::posed;
        offset = reader.frame(right, held, {{1, 0, 0, 0}, {0, 0, 0}}).at.p;
    }
    // A controller that holds what is at `tips` between the fingertips for a time [s].
    Json part(double from, double to, Vec3<double> tips, const Json& more = Json::object()) const
    {
        const Vec3<double> grip = tips - offset;
        Json one{{"side", "right"}, {"from", from}, {"to", to}, {"at", {grip.x, grip.y, grip.z}}};
        one.update(more);
        return one;
    }
    Vec3<double> offset;
};

// The lower button of the right controller begins to choose, the trigger takes the ball.
TEST_F(VrControllers, do_what_hands_do)
{
    const Vec3<double> at{0, radius + 0.005, 0}, up = at + Vec3<double>{0, 0.05, 0};
    Json script = squeeze();
    script["controllers"] = {part(0, 0.2, at),
                             part(0.2, 0.3, at, {{"lower", 1}}),
                             part(0.3, 0.6, at),
                             part(0.6, 0.8, at, {{"trigger", 1}}),
                             part(0.8, 1.3, at, {{"trigger", 1}, {"velocity", {0, 0.1, 0}}}),
                             part(1.3, 1.5, up, {{"trigger", 1}}),
                             part(1.5, 2.2, up)};
    const auto done = played(script);
    ASSERT_EQ(names(done), (Names{"set_hands", "move_objects"}));
    const MoveObjects& moves = std::get<MoveObjects>(done[1].command);
    ASSERT_TRUE(moves.by);
    EXPECT_NEAR(moves.by->y, options.zoom * 0.05, 0.05 * options.zoom * 0.05);
    // The left one undoes, as the left palm does.
    Json left_one = part(1.7, 1.8, {-0.3, 0, 0}, {{"lower", 1}});
    left_one["side"] = "left";
    script["controllers"].push_back(left_one);
    EXPECT_EQ(names(played(script)), (Names{"set_hands", "move_objects", "undo"}));
}

// In the ball nothing can be laid.
TEST_F(VrControllers, pulse_while_the_nozzle_is_clogged)
{
    const Vec3<double> at{-0.03, 0, 0}, higher{-0.03, 0.2, 0};
    const auto lays = [&](Vec3<double> from) {
        Json script = squeeze();
        script["controllers"] = {part(0, 0.2, from),
                                 part(0.2, 0.3, from, {{"upper", 1}}),
                                 part(0.3, 0.6, from),
                                 part(0.6, 0.8, from, {{"trigger", 1}}),
                                 part(0.8, 1.6, from, {{"trigger", 1}, {"velocity", {0.1, 0, 0}}}),
                                 part(1.6, 2.2, from + Vec3<double>{0.08, 0, 0})};
        const Names found = names(played(script));
        EXPECT_GT(found.size(), 3u);
        EXPECT_EQ(found.at(1), "source_begin");
        int pulses = 0;
        for (const Json& line : log) pulses += line.contains("haptic") && line["strength"] > 0.55;
        return pulses;
    };
    EXPECT_EQ(lays(higher), 0);
    EXPECT_GT(lays(at), 10);
}

}  // namespace
}  // namespace knead
#endif
