#include "host/ui/controls.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "host/document/command_table.h"

namespace knead {
namespace {

// Label and help of the command that the control sends.
template <class C>
constexpr ControlRow command(Control control, PanelPart part, unsigned shown, bool discards = false,
                             const char* keys = "", const char* like = "")
{
    return {
        control, Row<C>::row.name, Row<C>::row.label, Row<C>::row.help, part, shown, discards, keys,
        like};
}

using Part = PanelPart;

}  // namespace

const std::array<ControlRow, control_count> control_rows{{
    command<Undo>(Control::undo, Part::session, everywhere | on_palm, false, "Ctrl+Z",
                  "Blender, ZBrush, SuperSplat"),
    command<Redo>(Control::redo, Part::session, everywhere | on_palm, false, "Ctrl+Shift+Z Ctrl+Y",
                  "Blender, ZBrush, SuperSplat; SculptGL (Ctrl+Y)"),
    command<GoTo>(Control::go_to, Part::session, everywhere),
    {Control::new_scene, "new", "New", "Opens an empty table: floor and gravity, no clay.",
     Part::session, in_window, true, "Ctrl+N", "Blender, MeshLab"},
    command<Open>(Control::open, Part::session, everywhere, true, "Ctrl+O", "Blender, ZBrush"),
    command<Save>(Control::save, Part::session, everywhere, false, "Ctrl+S", "Blender, ZBrush"),
    {Control::save_as, "save_as", "Save as...", "Writes the session to another file.",
     Part::session, in_window, false, "Ctrl+Shift+S", "Blender"},
    command<Export>(Control::export_file, Part::session, everywhere, false, "Ctrl+E", "MeshLab"),
    {Control::export_what, "export_what", "What", "Surface or splats.", Part::session, in_window},
    {Control::export_unit, "export_unit", "Unit",
     "Of the numbers in the file; automatic: metres, in STL millimetres, as slicers read it.",
     Part::session, in_window},
    {Control::export_chosen, "export_chosen", "The chosen object alone",
     "Off: all that are not hidden.", Part::session, in_window},
    {Control::recover, "recover", "Recover",
     "Goes on with a session that ended without being saved.", Part::session, in_window, true},
    {Control::discard_log, "discard_log", "Discard", "Deletes it; it cannot be recovered then.",
     Part::session, in_window, true},
    {Control::hide_recoverable, "hide_recoverable", "Not now",
     "Hides the list until the next start.", Part::session, in_window},
    {Control::object, "object", "Object", "Chooses the objects that the controls below change.",
     Part::clay, everywhere},
    {Control::add, "add", "Add", "Adds an object of the chosen one's material above the clay.",
     Part::clay, everywhere},
    {Control::add_text, "add_text", "Text", "Letters of an object that is added as a text.",
     Part::clay, in_window},
    {Control::place, "place", "Put it down",
     "On: an added object follows the pointer or a hand until a click or a pinch puts it down. "
     "Off: it is put above the clay.",
     Part::arrange, everywhere},
    {Control::choose_all, "choose_all", "Choose all", "Chooses all objects.", Part::clay, in_window,
     false, "A", "Blender"},
    {Control::several, "several", "Several",
     "On: a click in the list adds an object to the chosen ones or removes it.", Part::arrange,
     in_headset},
    {Control::snap, "snap", "Snap",
     "On: objects move by hand in steps of 1 cm, 15 degrees about an axis, and 0.1.", Part::arrange,
     in_headset},
    command<Rename>(Control::rename, Part::clay, in_window, false, "F2", "Blender"),
    {Control::preset, "material", "Material", "Replaces the object's material.", Part::clay,
     everywhere},
    {Control::quantity, "quantity", "", "Changes a quantity of the object's material.", Part::clay,
     everywhere},
    {Control::lock, "lock", "Locked",
     "A locked object takes no command, and hands cannot carry it.", Part::clay, everywhere},
    {Control::hide, "hide", "Hidden",
     "Simulated but not drawn, once all objects of its category are hidden.", Part::clay,
     everywhere},
    command<RemoveObjects>(Control::remove, Part::clay, everywhere, false, "Delete",
                           "Blender, SuperSplat"),
    {Control::move, "move", "Move",
     "Moves the chosen objects with the mouse or by a typed number of centimetres; the clay "
     "follows "
     "when the move ends.",
     Part::arrange, in_window, false, "G", "Blender"},
    {Control::turn, "turn", "Turn",
     "Turns the chosen objects about their common centre, with the mouse or by a typed number of "
     "degrees.",
     Part::arrange, in_window, false, "R", "Blender"},
    {Control::scale, "scale", "Scale",
     "Scales each of the chosen objects about its own centre, with the mouse or by a typed factor.",
     Part::arrange, in_window, false, "S", "Blender"},
    {Control::on_surface, "on_surface", "On the surface",
     "On: a move puts the objects' lowest point on the clay or the floor below the pointer.",
     Part::arrange, in_window, false, "Shift+Tab", "Blender (snapping)"},
    {Control::duplicate, "duplicate", "Duplicate",
     "Copies the chosen objects to the next free place beside them.", Part::arrange, everywhere,
     false, "Ctrl+D", "most drawing programs"},
    {Control::merge, "merge", "Merge",
     "Merges the chosen objects into the one that was chosen last.", Part::arrange, everywhere,
     false, "Ctrl+J", "Blender"},
    {Control::split, "split", "Split", "Splits the chosen objects into their unconnected pieces.",
     Part::arrange, everywhere, false, "Shift+P", "Blender (P)"},
    {Control::centre, "centre", "Centre",
     "Moves the chosen objects to the middle of the table, or above what is there.", Part::arrange,
     everywhere, false, "Alt+G", "Blender"},
    {Control::reset_object, "reset_object", "Reset object", Row<ResetObjects>::row.help,
     Part::arrange, everywhere, false, "Alt+R"},
    {Control::colour, "colour", "Colour", Row<SetColour>::row.help, Part::arrange, everywhere},
    {Control::left_tool, "left", "Left hand", "What the left hand holds.", Part::hands, everywhere},
    {Control::right_tool, "right", "Right hand", "What the right hand holds.", Part::hands,
     everywhere},
    {Control::mouse_hand, "hand", "The mouse leads a hand",
     "On: the left button presses the hand into the clay below the pointer. Off: it turns the "
     "view.",
     Part::hands, in_window, false, "H"},
    {Control::posture, "posture", "Posture",
     "Posture of the hand that the mouse leads; the key selects the next one.", Part::hands,
     in_window, false, "P"},
    {Control::press, "press", "Press",
     "How deep a press goes below the surface; also by the wheel.", Part::hands, in_window},
    {Control::tilt, "tilt", "Tilt", "Tilts the hand that the mouse leads.", Part::hands, in_window},
    {Control::roll, "roll", "Roll", "Rolls the hand that the mouse leads.", Part::hands, in_window},
    {Control::curl, "curl", "", "Curls a finger of the hand that the mouse leads.", Part::hands,
     in_window},
    {Control::carry, "hold", "Hold",
     "On: fists carry objects, two fists move, turn and zoom the scene, and hands touch nothing. "
     "Off: hands shape.",
     Part::hands, in_headset},
    {Control::choose, "choose", "Choose",
     "On: a pinch chooses the object that it touches or points at, and moves it; hands touch "
     "nothing. Off: hands shape.",
     Part::hands, in_headset},
    {Control::lay, "lay", "Lay clay",
     "On: a pinch lays clay along its way, with the chosen object's material; hands touch nothing. "
     "Off: hands shape.",
     Part::hands, in_headset},
    {Control::nozzle, "nozzle", "The mouse lays clay",
     "On: dragging with the left button lays clay on what is below the pointer, with the chosen "
     "object's material.",
     Part::hands, in_window, false, "C"},
    {Control::nozzle_section, "section", "Section",
     "Cross-section of the clay that mouse or hand lays.", Part::hands, everywhere},
    {Control::nozzle_diameter, "diameter", "Diameter",
     "Of the clay that mouse or hand lays; with the mouse also by the wheel.", Part::hands,
     everywhere},
    {Control::nozzle_ring, "ring", "My ring",
     "On: the section is the circle that thumb and index form when they pinch.", Part::hands,
     in_headset},
    {Control::support, "support", "Undo on the left palm",
     "Which palm has undo and redo: off is the right one.", Part::hands, in_headset},
    {Control::panel_side, "side", "Panel on the left", "On which side the panel stands.",
     Part::hands, in_headset},
    {Control::recentre, "recentre", "Recentre", "Puts the clay before the head.", Part::hands,
     in_headset},
    {Control::standing, "standing", "Standing", "Places count from the floor, not from the head.",
     Part::hands, in_headset},
    command<Pause>(Control::pause, Part::scene, everywhere, false, "Space",
                   "Blender (animation), video players"),
    {Control::advance, "advance", "Step", "Computes one frame while paused.", Part::scene,
     in_window, false, "N"},
    command<Reset>(Control::reset, Part::scene, everywhere, true, "Ctrl+R"),
    command<Play>(Control::recorded, Part::scene, everywhere),
    {Control::gravity, "gravity", Row<SetGravity>::row.label, "Gravity, downwards.", Part::scene,
     everywhere},
    {Control::contact, "contact", Row<SetContact>::row.label,
     "Whether objects of different category weld where they touch, or come apart again.",
     Part::scene, everywhere},
    {Control::contact_friction, "contact_friction", "Their friction",
     "Coulomb friction between objects that are separate.", Part::scene, everywhere},
    command<SetLattice>(Control::cells, Part::scene, everywhere, true),
    command<SetSurface>(Control::surface, Part::scene, everywhere),
    {Control::frame_view, "frame", "Frame",
     "Fits the view to the chosen object's category of clay, from the same side.", Part::view,
     in_window, false, "F", "Maya, SuperSplat"},
    {Control::frame_all, "frame_all", "Frame all", "Fits the view to all clay, from the same side.",
     Part::view, in_window, false, "Home", "Blender"},
    {Control::panels, "panels", "Panels", "Shows or hides the panels.", Part::view, in_window,
     false, "Tab", "Photoshop, Substance 3D Painter"},
    {Control::help, "help", "Keys and gestures", "Lists keys and gestures.", Part::view, in_window,
     false, "F1 ?", "most programs; ? on the web"},
    {Control::screenshot, "screenshot", "Picture", "Writes a picture, knead_0001.png.", Part::view,
     in_window, false, "F12", "Blender, Steam"},
    {Control::film, "film", "Film", "Begins or ends a film, knead_0001.mp4.", Part::view, in_window,
     false, "V"},
    {Control::quit, "quit", "Quit", "Ends the session.", Part::view, everywhere, true, "Ctrl+Q",
     "Blender, programs of GNOME"},
    {Control::answer, "answer", "", "Answers a question.", Part::session, not_shown},
}};

const ControlRow* control_named(std::string_view name)
{
    const auto at = std::find_if(control_rows.begin(), control_rows.end(),
                                 [&](const ControlRow& row) { return name == row.name; });
    return at == control_rows.end() ? nullptr : &*at;
}

const std::array<GestureRow, 21> gesture_rows{{
    {"left button",
     "presses the hand into the clay below the pointer, and drags it there while it is down; "
     "without a hand, a click chooses an object, and beside all clay none",
     "Blender, SculptGL"},
    {"dragging with the left button while the mouse lays clay",
     "lays clay along its way, an object of its own; Esc undoes it", ""},
    {"Shift or Ctrl and a click, without a hand",
     "adds an object to the chosen ones, or takes it away; in the panel's list, too",
     "Blender (Shift), most programs (Ctrl)"},
    {"dragging with the left button, without a hand", "turns the view",
     "SuperSplat, SculptGL, MeshLab"},
    {"Esc",
     "closes an open list, dialog or question; else cancels a move, turn or scale, or a press, "
     "which "
     "it undoes; else closes the list of keys or the notice",
     "Blender"},
    {"X, Y or Z while moving or turning",
     "keeps the move to that axis, or turns about it; again: free", "Blender"},
    {"Shift and X, Y or Z while moving", "keeps the move to the plane across that axis", "Blender"},
    {"digits, point, minus and Backspace while moving, turning or scaling",
     "type the number: centimetres, along x without an axis; degrees; a factor", "Blender"},
    {"Ctrl, or Ctrl and Shift, while moving, turning or scaling",
     "snaps to 1 cm, 15 degrees or 0.1; with Shift, inverts *On the surface*", "Blender"},
    {"Enter or left button, Esc or right button, while moving, turning or scaling",
     "ends it; cancels it", "Blender"},
    {"middle button, right button, or Alt and left", "turns the view around the point looked at",
     "Blender (middle), Maya (Alt and left)"},
    {"Shift and middle or right, or Alt and middle", "moves the view sideways",
     "Blender (Shift and middle), Maya (Alt and middle)"},
    {"Alt and right", "moves the view nearer or farther", "Maya"},
    {"wheel",
     "moves the view nearer or farther; with the hand, presses deeper or less deep; "
     "while the mouse lays clay, makes it thicker or thinner",
     "Blender, MeshLab, SculptGL"},
    {"Ctrl and wheel", "moves the view nearer or farther while the mouse leads the hand", ""},
    {"1 to 5, G", "curl one finger while held, the thumb to the little finger; all of them", ""},
    {"Q and E", "roll the hand anticlockwise and clockwise", ""},
    {"T and B", "tilt the fingers steeper and flatter", ""},
    {"Ctrl and a click on a slider", "opens a field for a number",
     "Dear ImGui, Blender (a double click)"},
    {"a file dropped on the window", "opens a scene or a session, adds splats or a mesh",
     "Blender, MeshLab, SuperSplat"},
    {"the window's close button", "asks if work is not saved", "Blender"},
}};

namespace {

// Breaks lines between words; those after the first begin with `indent` spaces.
std::string wrapped(const std::string& text, std::size_t width, std::size_t indent)
{
    std::string lines;
    std::size_t column = 0;
    std::istringstream words(text);
    for (std::string word; words >> word;) {
        if (column > 0 && column + 1 + word.size() > width) {
            lines += "\n" + std::string(indent, ' ');
            column = indent;
        } else if (column > 0) {
            lines += ' ', ++column;
        }
        lines += word, column += word.size();
    }
    return lines + "\n";
}

std::string listed(const char* keys, const char* between)
{
    std::string list;
    std::istringstream words(keys);
    for (std::string word; words >> word;) list += (list.empty() ? "" : between) + word;
    return list;
}

}  // namespace

std::string keys_text()
{
    std::string text = "Keys and gestures of knead view:\n\n";
    for (const ControlRow& row : control_rows)
        if (*row.keys)
            text += "  " +
                    wrapped(fmt::format("{}: {}. {}", listed(row.keys, ", "), row.label, row.help),
                            78, 6);
    for (const GestureRow& row : gesture_rows)
        text += "  " + wrapped(fmt::format("{}: {}", row.input, row.effect), 78, 6);
    return text;
}

std::string keys_page()
{
    constexpr std::size_t width = 100;
    const auto same_in = [](const char* like) {
        return *like ? fmt::format(" As in: {}.", like) : std::string();
    };
    std::string text;
    for (const ControlRow& row : control_rows)
        if (*row.keys)
            text += wrapped(fmt::format("- `{}`: **{}**. {}{}", listed(row.keys, "`, `"), row.label,
                                        row.help, same_in(row.like)),
                            width, 2);
    text += "\n";
    for (const GestureRow& row : gesture_rows)
        text += wrapped(fmt::format("- *{}*: {}.{}", row.input, row.effect, same_in(row.like)),
                        width, 2);
    return text;
}

}  // namespace knead
