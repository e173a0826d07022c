// Table of all controls of the panel: names, labels, help, keys, and where each is shown. The
// panel's model (panel_model.h), its drawing, `knead help keys`, the keys of the window and
// docs/guide/window.md are made from it. Ranges and reasons why a command is not available come
// from the table of commands (host/document/command_table.h).
#pragma once
#include <array>
#include <string>
#include <string_view>

namespace knead {

// The window shows them in the order in which the panel's model has them.
enum class PanelPart { session, clay, hands, scene, view, arrange };
constexpr std::array<const char*, 6> part_titles{"Session", "Clay", "Hands",
                                                 "Scene",   "View", "Arrange"};

enum class Control {
    undo,
    redo,
    go_to,
    new_scene,
    open,
    save,
    save_as,
    export_file,
    export_what,
    export_unit,
    export_chosen,
    recover,
    discard_log,
    hide_recoverable,
    object,
    add,
    add_text,
    place,
    choose_all,
    several,
    snap,
    rename,
    preset,
    quantity,
    lock,
    hide,
    remove,
    move,
    turn,
    scale,
    on_surface,
    duplicate,
    merge,
    split,
    centre,
    reset_object,
    colour,
    left_tool,
    right_tool,
    mouse_hand,
    posture,
    press,
    tilt,
    roll,
    curl,
    carry,
    choose,
    lay,
    nozzle,
    nozzle_section,
    nozzle_diameter,
    nozzle_ring,
    support,
    panel_side,
    recentre,
    standing,
    pause,
    advance,
    reset,
    recorded,
    gravity,
    contact,
    contact_friction,
    cells,
    surface,
    frame_view,
    frame_all,
    panels,
    help,
    screenshot,
    film,
    quit,
    answer
};
constexpr std::size_t control_count = std::size_t(Control::answer) + 1;

enum Shown : unsigned {
    not_shown = 0,
    in_window = 1,
    in_headset = 2,
    on_palm = 4,  // of the support hand, in the headset
    everywhere = in_window | in_headset
};

struct ControlRow {
    Control control;
    const char* name;   // in scripts
    const char* label;  // on a button; of a slider: before it
    const char* help;   // one sentence
    PanelPart part;
    unsigned shown;
    // Discards the current work: in the headset it must be held for one second; the window asks
    // first if work would be lost.
    bool discards = false;
    const char* keys = "";  // in the window, separated by spaces: "Ctrl+Y Ctrl+Shift+Z"
    const char* like = "";  // programs with the same keys
};

extern const std::array<ControlRow, control_count> control_rows;
inline const ControlRow& row_of(Control control) { return control_rows[std::size_t(control)]; }
// nullptr: no control has this name.
const ControlRow* control_named(std::string_view name);

// What mouse and keys do in the picture, beside the controls.
struct GestureRow {
    const char* input;
    const char* effect;
    const char* like;  // programs in which the same input does this
};
extern const std::array<GestureRow, 21> gesture_rows;

// Keys and gestures of the window: as text for a terminal, and as Markdown lists for window.md.
std::string keys_text();
std::string keys_page();

}  // namespace knead
