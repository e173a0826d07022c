// What the panel shows, for window and headset alike: a pure function of the published state and of
// the state of the user interface. Independent of Dear ImGui, OpenGL and OpenXR.
#pragma once
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "host/files/image.h"
#include "host/hands/pointer.h"
#include "host/live/live_session.h"
#include "host/ui/controls.h"
#include "host/ui/new_object.h"

namespace knead {

// By type: monostate: a button; bool: a switch; double: a number; int: the index of a choice, or a
// whole number; string: a text.
using ControlValue = std::variant<std::monostate, bool, double, int, std::string>;

// `index`: the number of an object, step, quantity, finger or row; 0 of all other controls.
struct ControlId {
    Control control{};
    int index = 0;
    auto operator<=>(const ControlId&) const = default;
};

// What the user did with a control.
struct ControlEvent {
    ControlId id;
    ControlValue value;
    unsigned drag = 0;  // of a slider: number of the drag, from 1, increasing; 0: not a slider
};

struct ControlState {
    ControlId id;
    std::string label;
    ControlValue value;
    // Ends of a number's slider, extended to include the current value. Whole numbers change by
    // `step`.
    double low = 0, high = 0;
    int step = 1;
    bool logarithmic = false;
    std::string unit;
    std::vector<std::string> choices;  // of a choice
    std::string why_not;               // why it is unavailable; "": available
    std::string note;                  // a word about the value
    bool operator==(const ControlState&) const = default;
    const ControlRow& row() const { return row_of(id.control); }
};

struct PanelSection {
    PanelPart part{};
    std::vector<ControlState> controls;
    bool operator==(const PanelSection&) const = default;
};

// A session that ended without being saved.
struct RecoverRow {
    std::string file, name, text;
    std::shared_ptr<const Image> picture;  // null: none
    bool operator==(const RecoverRow&) const = default;
};

// The buttons are answered by Control::answer, with the index of the button.
struct PanelQuestion {
    std::string text;  // "": none
    std::vector<std::string> answers;
    bool operator==(const PanelQuestion&) const = default;
};

struct PanelModel {
    std::vector<PanelSection> sections;
    std::shared_ptr<const std::vector<StepInfo>> steps;  // null: none are kept
    std::vector<RecoverRow> recoverable;
    std::vector<std::string> files;    // paths that can be opened: recent ones, those beside
    std::string folder;                // where a file is looked for first
    std::string saves_as, exports_as;  // suggested paths
    std::string session;               // one line: saved, unsaved, trouble
    std::string failure, notice;       // "": none
    std::string pointing;              // beside the pointer; "": nothing
    std::vector<std::string> facts;    // lines of text: solver, renderer, frames, lag
    PanelQuestion question;
    int active = 0;                  // number of the active object; 0: none
    bool open = true, help = false;  // the panel; the list of keys
    bool operator==(const PanelModel&) const = default;

    const ControlState* find(ControlId id) const;  // nullptr: it is not shown
};

inline constexpr SliderRange nozzle_range{0.005, 0.3, true};  // diameter [m]
inline constexpr SliderRange press_range{0.001, 0.4};  // of the hand that the mouse leads [m]

// What the hands of the headset do. In all but the first they touch nothing.
enum class HandMode { shape, carry, choose, lay };

// Cross-sections of clay that mouse or hand lays.
inline constexpr std::array<SectionKind, 3> nozzle_sections{SectionKind::circle,
                                                            SectionKind::square, SectionKind::star};

// State of the user interface: neither saved nor undone.
struct UiState {
    unsigned place = in_window;  // or in_headset
    Origin origin() const { return place == in_window ? Origin::window : Origin::headset; }

    // The published document with all unanswered commands applied. Null: none was published yet.
    DocumentPtr document;
    // The objects that controls change: the active one, whose name and material are shown, and
    // further ones in the order in which they were chosen. None: 0.
    ObjectId chosen;
    std::vector<ObjectId> also_chosen;
    // Where objects are; of the last time that it was needed. Null: never.
    std::shared_ptr<const ObjectPlaces> places;
    bool on_surface = false;                  // moves put objects on what is below the pointer
    bool several = false;                     // of the headset: the list adds and takes away
    std::map<ObjectId, long> appeared;        // objects that came later: number of the frame before
    std::string scene;                        // path of the scene or session that was opened
    std::string saves_as;                     // suggested path of a session
    std::vector<std::string> beside, recent;  // paths that can be opened
    std::vector<RecoverRow> recoverable;
    std::vector<std::string> settings;  // --set, for scenes that are opened
    int cells = 0;                      // for scenes that are opened; 0: the scene's
    // The hand that the mouse leads.
    bool mouse_hand = false;
    int posture = int(Posture::relaxed);
    double press = 0.05, tilt = 0, roll = 0;  // [m] of the scene, [rad]
    double curl[5] = {0, 0, 0, 0, 0};         // 0 to 1
    // The nozzle that the mouse leads, not while it leads a hand; or a hand in the headset.
    bool nozzle = false;     // of the mouse
    int section = 0;         // of nozzle_sections
    bool ring = false;       // of the headset: the circle that the hand forms instead
    double diameter = 0.05;  // [m]
    bool paused = false, filming = false;
    int export_what = 0, export_unit = 0;  // 0: automatic
    bool export_chosen = false;            // of the chosen object alone
    std::string text = usual_text;         // of an object of letters that is added
    bool puts_down = false;                // added objects are put down by pointer or hand
    std::optional<SceneObject> placing;    // the one that is not put down yet
    // Of the headset.
    HandMode hand_mode = HandMode::shape;
    bool standing = false;
    bool snaps = false;  // motions by hand
    Side support = left, panel_side = left;
    bool open = true, help = false;
    std::string notice;
    std::string pointing;  // text beside the pointer
    PanelQuestion question;
    std::vector<std::string> facts;
};

// The chosen objects of the document, the active one first.
std::vector<ObjectId> selection(const UiState& ui);
// Chooses an object alone, or adds it to the chosen ones as the active one. 0: clears.
void choose(UiState& ui, ObjectId object);
void choose_more(UiState& ui, ObjectId object);
void unchoose(UiState& ui, ObjectId object);

PanelModel panel_model(const LiveState& state, const UiState& ui);

// The commands that a control sends. Empty if it changes only the user interface, or if the event
// does not fit the control or the state.
std::vector<Command> commands_for(const LiveState& state, const UiState& ui,
                                  const ControlEvent& event);
// Applies a control that changes only `ui`. Returns false for any other control.
bool change(UiState& ui, const ControlEvent& event);

// Tools that a hand can hold; the first, the bare hand, is named "".
const std::vector<std::string>& holdable_tools();
// Colours of objects; the first is that of the category. sRGB.
struct NamedColour {
    const char* name;
    Vec3<double> colour;
};
inline constexpr std::array<NamedColour, 12> object_colours{{{"of its category", {0, 0, 0}},
                                                             {"white", {0.95, 0.95, 0.93}},
                                                             {"grey", {0.5, 0.5, 0.5}},
                                                             {"black", {0.12, 0.12, 0.13}},
                                                             {"red", {0.8, 0.16, 0.12}},
                                                             {"orange", {0.95, 0.5, 0.1}},
                                                             {"yellow", {0.95, 0.8, 0.2}},
                                                             {"green", {0.25, 0.6, 0.25}},
                                                             {"blue", {0.2, 0.4, 0.8}},
                                                             {"violet", {0.5, 0.3, 0.7}},
                                                             {"pink", {0.95, 0.6, 0.7}},
                                                             {"brown", {0.45, 0.28, 0.16}}}};
// Range of the slider of gravity; other values can be typed or given by a command.
inline constexpr SliderRange gravity_slider{0, 20};
// Whole numbers of the panel; others by a command.
struct WholeRange {
    int low, high, step;
};
inline constexpr WholeRange cells_range{16, 128, 16}, surface_range{16, 256, 16};

}  // namespace knead
