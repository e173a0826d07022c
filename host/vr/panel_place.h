// Where the panels of the headset stand: the main panel beside the clay, and a strip on the palm of
// a hand. Independent of OpenGL and the simulation.
#pragma once
#include <optional>

#include "cuda/math/box.h"
#include "host/vr/headset_view.h"

namespace knead {

struct PanelSize {
    float width = 0.4f, height = 0.4f;  // [m]
};

struct PanelPlace {
    // Of its centre, in the frame of the hands: x right, y up, z towards the head.
    Joint<float> pose{{1, 0, 0, 0}, {0, 0, 0}};
    float distance = 0;          // from the head to the centre [m]
    bool reached = false;        // all of it is within `panel_reach` of the shoulder
    bool clear_of_clay = false;  // it does not enter the box of the clay
};

// Assumed shoulder of a side relative to the eyes, for an adult who sits upright: x to that side,
// y up, z backwards [m]; and the distance from it that a fingertip reaches without leaning forward.
constexpr Vec3<float> shoulder_from_eyes{0.19f, -0.2f, 0.1f};
constexpr float panel_reach = 0.65f;  // [m]
// Distance of the panel from every joint sphere of shaping hands, at least [m]
// (tests/vr/panel_place_test.cpp, all recordings of scenes/).
constexpr float panel_clearance = 0.03f;

// Pose left or right of the clay, facing the head: the usual one, beside all shaping hands, if it
// is within reach and outside the clay, which is larger if hands.zoom is small; else the nearest of
// others for which both hold; else the usual one. `clay`: bounds of the clay in the simulation's
// frame [m]; may be empty. Costs a fraction of a millisecond if the usual pose cannot be used.
PanelPlace main_panel_pose(const Workplace& workplace, Side side, const Box3<double>& clay,
                           const HandsOptions& hands, const PanelSize& size = {});

// Least height of a letter that is seen under an angle of `degrees` anywhere on a panel at
// `distance` from the head, which it faces [m]; at its corners letters appear smallest.
float panel_letter_height(float distance, const PanelSize& size, float degrees = 1);

// Distance from a point to the rectangle of a panel [m].
float distance_to_panel(const Joint<float>& pose, const PanelSize& size, Vec3<float> point);

// Pose of a strip on the palm: `above` the skin, facing away from it, its upper edge towards the
// fingers, so that controls keep their places on the hand. Frame and unit as the hand's. None if
// the palm is not tracked.
std::optional<Joint<float>> palm_pose(const Hand& hand, float above = 0.03f);

// Whether the strip on a palm is shown: only while the palm is turned to the head and the hand
// neither shapes nor holds anything.
class PalmStrip {
  public:
    static constexpr float shown_below = 45;   // angle from the palm's normal to the head [deg]
    static constexpr float hidden_above = 60;  // the same, once it is shown [deg]
    static constexpr double rest = 0.7;        // time without contact before it is shown [s]

    // Call for each frame; `time` [s] ascends. `head` in the frame of the hand. `contact`: the hand
    // touches clay. `busy`: it holds a tool, or carries.
    bool frame(double time, const Hand& hand, Vec3<float> head, bool contact, bool busy);

  private:
    bool shown = false;
    double touched = -1e30;  // last contact [s]
};

}  // namespace knead
