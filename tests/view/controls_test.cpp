// Camera, input, scripts and the graph of times, apart from any window.
#include <gtest/gtest.h>

#include <cmath>

#include "host/base/errors.h"
#include "host/ui/time_graph.h"
#include "render/view/input.h"
#include "render/view/losses.h"
#include "render/view/orbit.h"

namespace knead {
namespace {

constexpr Vec3<float> target{0.5f, 0.3f, 0.4f};

OrbitCamera some_camera()
{
    OrbitCamera camera;
    camera.look({1.25f, 0.95f, 1.5f}, target);
    return camera;
}

void expect_near(Vec3<float> a, Vec3<float> b, float within)
{
    EXPECT_LT(length(a - b), within) << a.x << " " << a.y << " " << a.z;
}

TEST(Orbit, LooksFromWhereItWasPut)
{
    const OrbitCamera camera = some_camera();
    expect_near(camera.eye(), {1.25f, 0.95f, 1.5f}, 1e-5f);
    const EyeView view = camera.view(640, 480);
    expect_near(rotate(view.rotation, Vec3<float>{0, 0, -1}), camera.forward(), 1e-5f);
    EXPECT_NEAR(view.left, -view.right, 1e-6f);
    EXPECT_NEAR(length(camera.forward()), 1, 1e-6f);
    OrbitCamera same = camera;
    same.look(target, target);
    expect_near(same.eye(), camera.eye(), 1e-6f);
}

TEST(Orbit, GoesAroundTheTargetAndStopsBeforeThePoles)
{
    OrbitCamera camera = some_camera();
    const float far = camera.distance();
    for (int i = 0; i < 100; ++i) camera.orbit(0.1f, 0.1f);
    EXPECT_NEAR(length(camera.eye() - target), far, 1e-4f);
    EXPECT_LT(camera.forward().y, -0.99f);
    EXPECT_GT(std::abs(camera.forward().x) + std::abs(camera.forward().z), 0.01f);
    OrbitCamera turned = some_camera();
    turned.orbit(3.14159265f, 0);
    const Vec3<float> half = 0.5f * (turned.eye() + some_camera().eye());
    EXPECT_NEAR(half.x, target.x, 1e-4f);
    EXPECT_NEAR(half.z, target.z, 1e-4f);
}

// Behind a panel of 200 of 640 columns the target is in the middle of the other 440.
TEST(Orbit, ThePictureMovesAsideForWhatHidesIt)
{
    const OrbitCamera camera = some_camera();
    expect_near(camera.ray(420, 240, 640, 480, 200), camera.forward(), 1e-6f);
    const EyeView view = camera.view(640, 480, 200);
    EXPECT_NEAR(-view.left / (view.right - view.left), 420.0f / 640, 1e-5f);
    EXPECT_NEAR(view.right - view.left, 2 * camera.view(640, 480).right, 1e-5f);
}

// What is under the mouse stays under it.
TEST(Orbit, PanningFollowsTheMouse)
{
    const OrbitCamera before = some_camera();
    OrbitCamera camera = before;
    camera.pan(100, -40, 480);
    const Vec3<float> ray = camera.ray(320 + 100, 240 - 40, 640, 480);
    const Vec3<float> hit = camera.eye() + camera.distance() * ray;
    expect_near(hit, target, 1e-4f);
    EXPECT_NEAR(camera.distance(), before.distance(), 1e-5f);
}

TEST(Orbit, ARayThroughTheMiddleIsTheGazeAndOneThroughAnEdgeHasHalfTheField)
{
    const OrbitCamera camera = some_camera();
    expect_near(camera.ray(320, 240, 640, 480), camera.forward(), 1e-6f);
    const Vec3<float> top = camera.ray(320, 0, 640, 480);
    EXPECT_NEAR(dot(top, camera.forward()), 1, 1e-5f);
    EXPECT_NEAR(std::sqrt(dot(top, top) - 1), std::tan(camera.field() / 2), 1e-5f);
    EXPECT_GT(top.y, camera.forward().y);
}

TEST(Orbit, FramesABoxWhole)
{
    for (const float aspect : {0.5f, 1.0f, 2.0f}) {
        OrbitCamera camera = some_camera();
        const Vec3<float> low{0, 0, 0}, high{0.4f, 0.2f, 0.9f};
        camera.frame({low, high}, aspect);
        const int height = 400, width = int(aspect * 400);
        const float pixel = 2 * std::tan(camera.field() / 2) / float(height);
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3<float> p{corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y,
                                corner & 4 ? high.z : low.z};
            const Vec3<float> d = p - camera.eye();
            const float ahead = dot(d, camera.forward());
            const Vec3<float> right =
                camera.ray(float(width), float(height) / 2, width, height) - camera.forward();
            EXPECT_LT(std::abs(dot(d, right)) / length(right) / ahead, pixel * float(width) / 2);
        }
        EXPECT_LT(camera.distance(), 12);
    }
}

TEST(Orbit, ZoomingInAndOutComesBackAndNeverTurnsOver)
{
    OrbitCamera camera = some_camera();
    const float far = camera.distance();
    camera.zoom(3), camera.zoom(-3);
    EXPECT_NEAR(camera.distance(), far, 1e-5f);
    camera.zoom(1000);
    EXPECT_GT(camera.distance(), 0);
    camera.zoom(-10000);
    EXPECT_LT(camera.distance(), 1e4f);
}

TEST(Input, KnowsWhatIsHeldAndWhatHappenedSinceTheLastFrame)
{
    InputState input;
    for (const InputEvent& e : InputScript::parse("0 move 10 20\n0 move 15 18\n0 key a tap\n"
                                                  "0 button left down\n0 wheel -2\n0 text hi\n",
                                                  "s")
                                   .due(0))
        input.take(e);
    EXPECT_EQ(input.moved_x(), 5) << "the first place is no motion";
    EXPECT_EQ(input.moved_y(), -2);
    EXPECT_TRUE(input.went_down('A'));
    EXPECT_FALSE(input.held(Key('A')));
    EXPECT_TRUE(input.held(button_left));
    EXPECT_EQ(input.wheel(), -2);
    EXPECT_EQ(input.typed().size(), 2u);
    input.begin_frame();
    EXPECT_FALSE(input.went_down('A'));
    EXPECT_FALSE(input.clicked(button_left));
    EXPECT_TRUE(input.held(button_left));
    EXPECT_EQ(input.moved_x(), 0);
    EXPECT_EQ(input.x(), 15);
    InputEvent odd{InputEvent::key};
    odd.code = 100000, odd.down = true;
    input.take(odd);
    odd.kind = InputEvent::button;
    input.take(odd);
    EXPECT_FALSE(input.held(Key(100000)));
}

// Of one frame.
void play(InputState& input, const std::string& script)
{
    input.begin_frame();
    for (const InputEvent& e : InputScript::parse(script, "s").due(0)) input.take(e);
}

// Ctrl+R is not R, however short the chord is.
TEST(Input, AKeyWithControlIsNotTheKeyAlone)
{
    InputState input;
    play(input, "0 key r tap\n");
    EXPECT_TRUE(input.went_down('R') && input.pressed({'R'}));
    for (const std::string key : {"control", "alt", "super", "shift", "right_control"}) {
        play(input, "0 key " + key + " down\n0 key r tap\n0 key " + key + " up\n");
        EXPECT_TRUE(input.went_down('R'));
        EXPECT_FALSE(input.pressed({'R'})) << key;
        const bool control = key == "control" || key == "right_control";
        EXPECT_EQ(input.pressed({'R', true}), control) << key;
        EXPECT_EQ(input.pressed({'R', false, true}), key == "shift") << key;
        EXPECT_EQ(input.pressed({'R', false, false, true}), key == "alt") << key;
    }
    play(input, "0 key control down\n0 key e down\n");
    EXPECT_TRUE(input.control());
    EXPECT_FALSE(input.held_alone(Key('E')));
    play(input, "0 key control up\n");
    EXPECT_TRUE(input.held_alone(Key('E')));
    for (const std::string key : {"right_control", "right_alt", "right_super"}) {
        play(input, "0 key " + key + " down\n");
        EXPECT_FALSE(input.held_alone(Key('E'))) << key;
        EXPECT_EQ(input.control(), key == "right_control");
        play(input, "0 key " + key + " up\n");
    }
    play(input, "0 key shift down\n");
    EXPECT_TRUE(input.held_alone(Key('E'))) << "a capital";
}

// Both are released before the frame looks.
TEST(Input, ModifiersAreThoseOfThePress)
{
    InputState input;
    play(input, "0 key control down\n0 key z tap\n0 key control up\n");
    EXPECT_TRUE(input.pressed({'Z', true}));
    EXPECT_FALSE(input.pressed({'Z', true, true}) || input.pressed({'Y', true}));
    play(input,
         "0 key control down\n0 key shift down\n0 key z tap\n0 key shift up\n"
         "0 key control up\n");
    EXPECT_TRUE(input.pressed({'Z', true, true}));
    EXPECT_FALSE(input.pressed({'Z', true}));
    play(input, "0 key z tap\n");
    EXPECT_FALSE(input.pressed({'Z', true}) || input.pressed({'Z', true, true}));
    play(input, "0 key control down\n0 key alt down\n0 key z tap\n");
    EXPECT_FALSE(input.pressed({'Z', true})) << "another combination";
    EXPECT_TRUE(input.pressed({'Z', true, false, true}));
}

TEST(Input, NamesOfKeysInScripts)
{
    InputState input;
    play(input,
         "0 key f1 tap\n0 key f12 tap\n0 key delete tap\n0 key page_up tap\n0 key page_down tap\n"
         "0 key , tap\n0 key period tap\n0 key number_sign tap\n0 text ?\n");
    for (const int key : {290, 301, 261, 266, 267, 44, 46, 35}) EXPECT_TRUE(input.pressed({key}));
    EXPECT_TRUE(input.typed('?'));
    EXPECT_FALSE(input.typed('/'));
    EXPECT_THROW(InputScript::parse("0 key f13 tap\n", "s"), InputError);
    EXPECT_THROW(InputScript::parse("0 drop  \n", "s"), InputError);
    EXPECT_THROW(InputScript::parse("0 close now\n", "s"), InputError);
}

TEST(Input, FilesAreDroppedAndClosingIsRequested)
{
    InputState input;
    play(input, "0 drop my scenes/pot 2.json  # a comment\n0 drop b.ply\n0 close\n");
    EXPECT_EQ(input.dropped(), (std::vector<std::string>{"my scenes/pot 2.json", "b.ply"}));
    EXPECT_TRUE(input.close_requested());
    input.begin_frame();
    EXPECT_TRUE(input.dropped().empty());
    EXPECT_FALSE(input.close_requested());
}

TEST(Input, WithoutTheKeyboardNothingIsHeld)
{
    InputState input;
    play(input, "0 key control down\n0 key g down\n0 button left down\n");
    input.take({InputEvent::unfocus});
    EXPECT_FALSE(input.control() || input.held(Key('G')) || input.held(button_left));
    EXPECT_TRUE(input.inside());
    input.take({InputEvent::leave});
    EXPECT_FALSE(input.inside());
    input.take({InputEvent::enter});
    EXPECT_TRUE(input.inside());
}

// `key`: of the US keyboard at the same place.
TEST(Keys, LettersAndPunctuationAreOfTheLayoutAndDigitsOfTheirPlace)
{
    EXPECT_EQ(key_code('Q', "a"), 'A') << "French";
    EXPECT_EQ(key_code(';', "m"), 'M');
    EXPECT_EQ(key_code('M', ","), ',');
    EXPECT_EQ(key_code('1', "&"), '1');
    EXPECT_EQ(key_code('2', "\xc3\xa9"), '2');
    EXPECT_EQ(key_code('Y', "z"), 'Z') << "German";
    EXPECT_EQ(key_code('-', "\xc3\x9f"), '-');
    EXPECT_EQ(key_code('Z', "\xd1\x8f"), 'Z') << "Russian";
    EXPECT_EQ(key_code('A', nullptr), 'A');
    EXPECT_EQ(key_code(key_space, " "), key_space);
    EXPECT_EQ(key_code(key_escape, nullptr), key_escape);
    EXPECT_EQ(key_code(321, "1"), 321) << "of the keypad";
}

TEST(Keys, AreReleasedUnderTheCodeOfTheirPress)
{
    KeyCodes codes;
    EXPECT_EQ(codes.press(24, 'Q', "a"), 'A');
    EXPECT_EQ(codes.release(24, 'Q', "q"), 'A') << "the layout has changed";
    EXPECT_EQ(codes.release(24, 'Q', "q"), 'Q');
    codes.press(24, 'Q', "a");
    codes.clear();
    EXPECT_EQ(codes.release(24, 'Q', "q"), 'Q');
}

TEST(ContextLosses, AddUpOnlyWhereTheyFollowEachOther)
{
    ContextLosses rare;
    for (int i = 0; i < 100; ++i) EXPECT_FALSE(rare.too_many(4.0 * i)) << i;
    EXPECT_EQ(rare.count(), 100);
    ContextLosses often;
    for (int i = 0; i < ContextLosses::most; ++i) EXPECT_FALSE(often.too_many(0.5 * i));
    EXPECT_TRUE(often.too_many(2));
}

TEST(Script, GivesItsEventsInTime)
{
    InputScript script = InputScript::parse(
        "# a comment\n\n0.5 move 1 2  # another\n0.5 key space tap\n1 screenshot a.png\n2 lose\n",
        "s");
    EXPECT_TRUE(script.due(0.4).empty());
    EXPECT_EQ(script.due(0.5).size(), 3u);
    EXPECT_TRUE(script.due(0.6).empty());
    const std::vector<InputEvent> last = script.due(5);
    ASSERT_EQ(last.size(), 2u);
    EXPECT_EQ(last[0].file, "a.png");
    EXPECT_TRUE(script.over());
}

TEST(Script, NamesTheLineThatItDoesNotUnderstand)
{
    const char* wrong[][2] = {{"x move 1 2", "a time"},      {"0 jump", "move, button"},
                              {"0 move 1", "y in pixels"},   {"0 key spacebar tap", "a key"},
                              {"0 key a press", "down, up"}, {"0 button right", "down, up"},
                              {"0 wheel 1 2", "line's end"}, {"nan wheel 1", "a time"},
                              {"-1 wheel 1", "before"}};
    for (const auto& [line, expected] : wrong) try {
            InputScript::parse(std::string("0 wheel 1\n") + line, "my.script");
            ADD_FAILURE() << line;
        } catch (const InputError& e) {
            EXPECT_EQ(std::string(e.what()).find("my.script:2: "), 0u) << e.what();
            EXPECT_NE(std::string(e.what()).find(expected), std::string::npos) << e.what();
        }
    EXPECT_THROW(InputScript::read("no/such/script"), InputError);
}

TEST(TimeGraph, KeepsTheLastFramesStageByStage)
{
    TimeGraph graph;
    EXPECT_EQ(graph.longest(), 0);
    graph.add({{"solver", 0.010}, {"picture", 0.002}});
    graph.add({{"picture", 0.004}, {"splats", 0.001}});
    ASSERT_EQ(graph.names().size(), 3u);
    EXPECT_EQ(graph.names()[2], "splats");
    EXPECT_DOUBLE_EQ(graph.seconds(0, 0), 0);
    EXPECT_DOUBLE_EQ(graph.seconds(1, 0), 0.010);
    EXPECT_DOUBLE_EQ(graph.seconds(0, 1), 0.004);
    EXPECT_DOUBLE_EQ(graph.seconds(1, 2), 0) << "a stage that came later";
    EXPECT_DOUBLE_EQ(graph.total(0), 0.005);
    EXPECT_DOUBLE_EQ(graph.mean(1), 0.003);
    EXPECT_DOUBLE_EQ(graph.longest(), 0.012);
    for (int i = 0; i < 3 * TimeGraph::frames; ++i) graph.add({{"solver", 0.001}});
    EXPECT_EQ(graph.count(), TimeGraph::frames);
    EXPECT_DOUBLE_EQ(graph.longest(), 0.001);
}

}  // namespace
}  // namespace knead
