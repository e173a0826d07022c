// The one table of commands. A row has a command's name in files, its texts, its fields with units
// and ranges, its receiver, whether commands of a drag merge, and when it is available. The JSON
// codec (command_text.h), `knead help commands`, docs/reference/commands.md, random generators and
// the fuzzer's dictionary are made from it. A command without a row, and a member without a field,
// do not compile.
#pragma once
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "host/base/json_reader.h"
#include "host/document/command.h"
#include "host/hands/hands.h"

namespace knead {

enum class Receiver { document, session };
// How a command is undone. Waiting commands of a drag, of the document, are dropped for later ones
// (Issued::drag), except with `step`.
enum class UndoRule {
    step,   // each is a step
    merge,  // the commands of a drag are one step
    none    // changes nothing that undo restores
};

// What availability depends on.
struct Situation {
    const Document* document = nullptr;
    bool simulation = true;  // there is one
    bool editable = true;    // its simulator is an EditableSimulator
    bool live = true;        // real or stepped time; false: a batch run
    // What another lattice, or another scene, would discard; "": nothing.
    std::string work;
    // Why there is nothing to undo, to redo, to go to, to save; "": there is.
    std::string no_undo, no_redo, no_steps, no_save;
};

template <class T>
struct CommandField {
    const char* key;
    T member;          // pointer to member
    const char* help;  // one line, in lower case, without a full stop
    Bounds range{};    // of numbers, and of the components of vectors; unit ""
};
template <class C, class M>
constexpr CommandField<M C::*> command_field(const char* key, M C::*member, const char* help,
                                             Bounds range = {})
{
    return {key, member, help, range};
}

struct CommandRow {
    const char* name;   // in files
    const char* label;  // in messages on panels
    const char* help;   // one sentence
    Receiver receiver;
    UndoRule undo;
    std::string (*why_not)(const Situation&);  // why it is not available; "": it is
};

std::string always_available(const Situation&);
std::string needs_edits(const Situation&);
std::string needs_simulation(const Situation&);
std::string needs_live(const Situation&);
std::string needs_no_work(const Situation&);
std::string needs_undo(const Situation&);
std::string needs_redo(const Situation&);
std::string needs_steps(const Situation&);
std::string needs_log(const Situation&);
std::string needs_contents(const Situation&);

inline constexpr Bounds anywhere{-1000, 1000, "m"};
inline constexpr Bounds turn_range{-1.001, 1.001};

template <class C>
struct Row;

template <>
struct Row<AddObject> {
    static constexpr CommandRow row{"add_object",
                                    "Add object",
                                    "Adds an object of clay, with the keys of a scene's objects.",
                                    Receiver::document,
                                    UndoRule::step,
                                    needs_edits};
    static constexpr std::tuple fields{command_field(
        "object", &AddObject::object,
        "as in a scene's `objects`; also `id`, of a log: the number that was given to it")};
};
template <>
struct Row<RemoveObjects> {
    static constexpr CommandRow row{
        "remove_objects",   "Delete",       "Removes objects and their clay.",
        Receiver::document, UndoRule::step, needs_edits};
    static constexpr std::tuple fields{
        command_field("objects", &RemoveObjects::objects, "the objects, at least one")};
};
template <>
struct Row<PlaceObject> {
    static constexpr CommandRow row{"place_object",
                                    "Place",
                                    "Moves an object as a rigid body to a place, with its clay.",
                                    Receiver::document,
                                    UndoRule::merge,
                                    needs_edits};
    static constexpr std::tuple fields{
        command_field("object", &PlaceObject::object, "the object"),
        command_field(
            "centre", &PlaceObject::centre,
            "new origin of the object's frame, in the frame of the scene's file; absent: unchanged",
            anywhere),
        command_field("rotation", &PlaceObject::rotation,
                      "quaternion [w, x, y, z] from the object's frame; absent: unchanged",
                      turn_range)};
};
template <>
struct Row<SetMaterial> {
    static constexpr CommandRow row{
        "set_material",     "Material",      "Changes the material of an object.",
        Receiver::document, UndoRule::merge, needs_edits};
    static constexpr std::tuple fields{
        command_field("object", &SetMaterial::object, "the object"),
        command_field("material", &SetMaterial::material,
                      "a preset's name, or an object as in a scene; replaces the whole material")};
};
template <>
struct Row<SetCategory> {
    static constexpr CommandRow row{
        "set_category",
        "Category",
        "Changes the category of an object: clay of one category has one surface.",
        Receiver::document,
        UndoRule::step,
        needs_edits};
    static constexpr std::tuple fields{
        command_field("object", &SetCategory::object, "the object"),
        command_field("category", &SetCategory::category, "of its clay", {0, 255})};
};
template <>
struct Row<Rename> {
    static constexpr CommandRow row{
        "rename",           "Rename",       "Changes the name of an object.",
        Receiver::document, UndoRule::step, needs_simulation};
    static constexpr std::tuple fields{command_field("object", &Rename::object, "the object"),
                                       command_field("name", &Rename::name, "its new name")};
};
template <>
struct Row<SetFlags> {
    static constexpr CommandRow row{
        "set_flags",        "Lock, hide",   "Locks, unlocks, hides or shows an object.",
        Receiver::document, UndoRule::step, needs_simulation};
    static constexpr std::tuple fields{
        command_field("object", &SetFlags::object, "the object"),
        command_field("locked", &SetFlags::locked,
                      "every command on it is refused, except set_flags and the end of carry; "
                      "absent: unchanged"),
        command_field("hidden", &SetFlags::hidden,
                      "its category is not drawn if all objects of the category are hidden; "
                      "absent: unchanged")};
};
template <>
struct Row<SetColour> {
    static constexpr CommandRow row{
        "set_colour",       "Colour",       "Changes the colour in which objects are drawn.",
        Receiver::document, UndoRule::step, needs_simulation};
    static constexpr std::tuple fields{
        command_field("objects", &SetColour::objects, "the objects, at least one"),
        command_field("colour", &SetColour::colour,
                      "[red, green, blue] in sRGB; absent: that of their category", {0, 1})};
};
template <>
struct Row<CopyObjects> {
    static constexpr CommandRow row{"copy_objects",
                                    "Copy",
                                    "Copies objects with the full state of their clay and splats; "
                                    "refused where other clay is in the way.",
                                    Receiver::document,
                                    UndoRule::step,
                                    needs_edits};
    static constexpr std::tuple fields{
        command_field("objects", &CopyObjects::objects, "the objects, at least one"),
        command_field("by", &CopyObjects::by, "from each object to its copy", anywhere),
        command_field("names", &CopyObjects::names,
                      "of the copies; those without one are named \"NAME copy\""),
        command_field("ids", &CopyObjects::ids, "set in logs: the numbers given to the copies")};
};
template <>
struct Row<MoveObjects> {
    static constexpr CommandRow row{
        "move_objects",
        "Move",
        "Turns objects as one rigid body and displaces them, with their clay; refused where a wall "
        "or other clay is in the way.",
        Receiver::document,
        UndoRule::step,
        needs_edits};
    static constexpr std::tuple fields{
        command_field("objects", &MoveObjects::objects, "the objects, at least one"),
        command_field("by", &MoveObjects::by, "displacement; absent: 0", anywhere),
        command_field("turn", &MoveObjects::turn,
                      "quaternion [w, x, y, z], applied before the displacement; absent: none",
                      turn_range),
        command_field("about", &MoveObjects::about,
                      "point that the turn leaves in place, in the frame of the scene's file; "
                      "absent: the middle of the objects' centres of mass",
                      anywhere)};
};
template <>
struct Row<ResetObjects> {
    static constexpr CommandRow row{
        "reset_objects",
        "Reset object",
        "Replaces the clay of objects by new clay at the place and size that commands have given "
        "them; refused for splats, and where the volume has changed by more than 15 %.",
        Receiver::document,
        UndoRule::step,
        needs_edits};
    static constexpr std::tuple fields{
        command_field("objects", &ResetObjects::objects, "the objects, at least one")};
};
template <>
struct Row<ScaleObjects> {
    static constexpr CommandRow row{
        "scale_objects",
        "Scale",
        "Scales each object about its centre of mass, its mass by the cube of the factor; an "
        "object that would cross a wall is shifted, and one that does not fit or would touch other "
        "clay is refused.",
        Receiver::document,
        UndoRule::step,
        needs_edits};
    static constexpr std::tuple fields{
        command_field("objects", &ScaleObjects::objects, "the objects, at least one"),
        command_field("factor", &ScaleObjects::factor, "of lengths; of volume and mass its cube",
                      {0.1, 10})};
};
template <>
struct Row<MergeObjects> {
    static constexpr CommandRow row{
        "merge_objects",
        "Merge",
        "Merges objects into one; their clay keeps its state and materials and takes the category "
        "of the first object.",
        Receiver::document,
        UndoRule::step,
        needs_edits};
    static constexpr std::tuple fields{
        command_field(
            "objects", &MergeObjects::objects,
            "the objects, at least two; the first keeps its number, the others are removed"),
        command_field("name", &MergeObjects::name, "new name; absent: that of the first")};
};
template <>
struct Row<SplitPlane> {
    static constexpr std::tuple fields{
        command_field("point", &SplitPlane::point,
                      "a point of it, in the frame of the scene's file", anywhere),
        command_field("normal", &SplitPlane::normal,
                      "of any length but 0; points to the first part", {-1000, 1000})};
};
template <>
struct Row<SplitObject> {
    static constexpr CommandRow row{
        "split_object",
        "Split",
        "Splits an object in two by a plane, or into its unconnected pieces; a plane is refused "
        "with fewer than 64 particles on one side, a smaller piece is added to the nearest one.",
        Receiver::document,
        UndoRule::step,
        needs_edits};
    static constexpr std::tuple fields{
        command_field("object", &SplitObject::object, "the object"),
        command_field("plane", &SplitObject::plane, "the plane; exactly one of this and `pieces`"),
        command_field("pieces", &SplitObject::pieces, "true: into unconnected pieces"),
        command_field("names", &SplitObject::names,
                      "of the part before the plane and the one behind it, or of pieces from the "
                      "largest; without one the largest part keeps its name NAME, and others are "
                      "named \"NAME 2\", \"NAME 3\""),
        command_field("ids", &SplitObject::ids, "of a log: the numbers of the parts in this order"),
        command_field("categories", &SplitObject::categories,
                      "of the parts in this order; absent: with `contact.categories` `separate`, "
                      "pieces but the largest get unused ones, else all have that of the object",
                      {0, 255})};
};
template <>
struct Row<SourceBegin> {
    static constexpr CommandRow row{
        "source_begin",
        "Extrude",
        "Begins an object of clay from a nozzle. Commands from here to source_end are one step.",
        Receiver::document,
        UndoRule::step,
        needs_edits};
    static constexpr std::tuple fields{
        command_field("name", &SourceBegin::name, "of the object"),
        command_field("section", &SourceBegin::section,
                      "cross-section of the clay; absent: circle"),
        command_field(
            "diameter", &SourceBegin::diameter,
            "of the circle, side of the square, or longest extent of the star or the outline",
            {0, 10, "m", true}),
        command_field("outline", &SourceBegin::outline,
                      "of section `outline`: a closed polygon [[x, y], ...] in any unit"),
        command_field("material", &SourceBegin::material,
                      "a preset's name, or an object as in a scene; absent: clay"),
        command_field("category", &SourceBegin::category, "of its clay; absent: 0", {0, 255}),
        command_field("at", &SourceBegin::at, "the nozzle, in the frame of the scene's file",
                      anywhere),
        command_field("axis", &SourceBegin::axis,
                      "the section faces along it where it is within 45 degrees of the motion, "
                      "otherwise along the motion; of any length; absent or 0: along the motion",
                      {-1000, 1000}),
        command_field("ids", &SourceBegin::ids, "set in logs: the number given to the object")};
};
template <>
struct Row<SourceMove> {
    static constexpr CommandRow row{
        "source_move",
        "Extrude",
        "Moves a nozzle on a straight line and lays clay on the way, where there is none and "
        "between the walls.",
        Receiver::document,
        UndoRule::step,
        needs_edits};
    static constexpr std::tuple fields{
        command_field("name", &SourceMove::object, "the object"),
        command_field("at", &SourceMove::at, "to this place", anywhere),
        command_field("axis", &SourceMove::axis, "as in source_begin; absent: unchanged",
                      {-1000, 1000})};
};
template <>
struct Row<SourceEnd> {
    static constexpr CommandRow row{
        "source_end",
        "Extrude",
        "Ends a nozzle; an object whose nozzle was not moved is removed.",
        Receiver::document,
        UndoRule::step,
        needs_edits};
    static constexpr std::tuple fields{command_field("name", &SourceEnd::object, "the object")};
};
template <>
struct Row<SetGravity> {
    static constexpr CommandRow row{"set_gravity",      "Gravity",       "Changes gravity.",
                                    Receiver::document, UndoRule::merge, needs_edits};
    static constexpr std::tuple fields{command_field(
        "gravity", &SetGravity::gravity, "acceleration", {-most_gravity, most_gravity, "m/s^2"})};
};
template <>
struct Row<SetWalls> {
    static constexpr CommandRow row{
        "set_walls",        "Walls",         "Changes the walls; absent keys are unchanged.",
        Receiver::document, UndoRule::merge, needs_edits};
    static constexpr std::tuple fields{
        command_field("min", &SetWalls::min, "low corner", {-1000, 1000, "m"}),
        command_field("max", &SetWalls::max, "high corner", {-1000, 1000, "m"}),
        command_field("contact_mode", &SetWalls::contact_mode, "how clay touches them"),
        command_field("friction", &SetWalls::friction, "Coulomb coefficient", {0, 10})};
};
template <>
struct Row<SetContact> {
    static constexpr CommandRow row{
        "set_contact",
        "Objects",
        "Sets whether touching objects of different category weld, or touch with friction and come "
        "apart again; absent keys are unchanged.",
        Receiver::document,
        UndoRule::merge,
        needs_edits};
    static constexpr std::tuple fields{
        command_field("categories", &SetContact::categories, "what touching objects do"),
        command_field("friction", &SetContact::friction, "Coulomb coefficient of separate objects",
                      {0, most_body_friction})};
};
template <>
struct Row<SetHand> {
    static constexpr std::tuple fields{
        command_field("present", &SetHand::present, "whether it acts"),
        command_field("held", &SetHand::held, "a tool, or \"\": the bare hand")};
};
template <>
struct Row<SetHands> {
    static constexpr CommandRow row{
        "set_hands",
        "Tools",
        "Changes tools, presence, zoom and position of the hands; absent keys are unchanged.",
        Receiver::document,
        UndoRule::none,
        needs_edits};
    static constexpr std::tuple fields{
        command_field("left", &SetHands::left, "what the left hand holds, and whether it acts"),
        command_field("right", &SetHands::right, "the same of the right hand"),
        command_field("zoom", &SetHands::zoom, "simulation metres per real metre", {0.01, 1000}),
        command_field("at", &SetHands::at,
                      "position of the tracker's origin, in the frame of the scene's file",
                      anywhere)};
};
template <>
struct Row<SetSurface> {
    static constexpr CommandRow row{
        "set_surface",      "Surface",      "Changes the number of nodes of the surface's lattice.",
        Receiver::document, UndoRule::none, needs_simulation};
    static constexpr std::tuple fields{command_field("nodes", &SetSurface::nodes,
                                                     "along its longest side",
                                                     {fewest_surface_nodes, most_surface_nodes})};
};
template <>
struct Row<SetLattice> {
    static constexpr CommandRow row{
        "set_lattice",
        "Cells",
        "Begins the scene again on another lattice; refused when clay or settings would be lost.",
        Receiver::session,
        UndoRule::none,
        needs_no_work};
    static constexpr std::tuple fields{
        command_field("cells", &SetLattice::cells, "along the longest axis", {8, 1024})};
};
template <>
struct Row<Carry> {
    static constexpr CommandRow row{
        "carry",
        "Carry",
        "Starts or stops carrying objects with a hand; while carried they move with its palm.",
        Receiver::session,
        UndoRule::step,
        needs_edits};
    static constexpr std::tuple fields{
        command_field("objects", &Carry::objects, "the objects"),
        command_field("side", &Carry::side, "the hand; without effect on stopping"),
        command_field("begins", &Carry::begins, "true: start; false: stop")};
};
template <>
struct Row<Open> {
    static constexpr CommandRow row{"open",
                                    "Open",
                                    "Opens a scene or a session in place of the current one.",
                                    Receiver::session,
                                    UndoRule::none,
                                    needs_live};
    static constexpr std::tuple fields{
        command_field("file", &Open::file,
                      "a scene (.json), a session (.knead), or \"new\": an empty table"),
        command_field("settings", &Open::settings,
                      "as by --set; those that do not fit are left out"),
        command_field("cells", &Open::cells, "along the longest axis; absent: as in the file",
                      {8, 1024})};
};
template <>
struct Row<Save> {
    static constexpr CommandRow row{"save",
                                    "Save",
                                    "Writes the session, with its steps, to a file.",
                                    Receiver::session,
                                    UndoRule::none,
                                    needs_log};
    static constexpr std::tuple fields{
        command_field("file", &Save::file, "to be written, *.knead; one that is there is replaced"),
        command_field("input", &Save::input,
                      "with the recorded hands, which are personal data; absent: true")};
};
template <>
struct Row<Export> {
    static constexpr CommandRow row{
        "export",
        "Export",
        "Writes the surface or the splats to a file, in the frame of the scene's file. Export is "
        "not a step, and a replay does not write the file.",
        Receiver::session,
        UndoRule::none,
        needs_contents};
    static constexpr std::tuple fields{
        command_field(
            "file", &Export::file,
            "to be written; one that is there is replaced. A surface: .glb, .obj, .ply, "
            ".stl, .3mf, with one mesh per category named after its objects; splats: .glb, "
            ".ply, .sog, .splat, .spz"),
        command_field(
            "what", &Export::what,
            "absent: the surface; the splats if the format, or all objects, are of splats"),
        command_field(
            "unit", &Export::unit,
            "of lengths in the file; absent: mm for .3mf, and for .stl, which has no unit "
            "and is read as millimetres by slicers; m for the others, as glTF specifies"),
        command_field("objects", &Export::objects,
                      "those whose categories, or splats, are written; absent: all but hidden "
                      "ones")};
};
template <>
struct Row<Undo> {
    static constexpr CommandRow row{
        "undo",
        "Undo",
        "Restores clay and document as they were before the last step; redo reverses that.",
        Receiver::session,
        UndoRule::none,
        needs_undo};
    static constexpr std::tuple<> fields{};
};
template <>
struct Row<Redo> {
    static constexpr CommandRow row{
        "redo", "Redo", "Reverses the last undo.", Receiver::session, UndoRule::none, needs_redo};
    static constexpr std::tuple<> fields{};
};
template <>
struct Row<GoTo> {
    static constexpr CommandRow row{
        "go_to",           "Go to step",   "Restores clay and document of a step.",
        Receiver::session, UndoRule::none, needs_steps};
    static constexpr std::tuple fields{
        command_field("step", &GoTo::step, "its number; 0: the beginning", {0, 2147483647})};
};
template <>
struct Row<Reset> {
    static constexpr CommandRow row{"reset",
                                    "Reset",
                                    "Begins the scene again from its file; undo reverses that.",
                                    Receiver::session,
                                    UndoRule::step,
                                    needs_live};
    static constexpr std::tuple<> fields{};
};
template <>
struct Row<Pause> {
    static constexpr CommandRow row{"pause",
                                    "Pause",
                                    "Pauses or continues the simulation. No effect in `knead run`.",
                                    Receiver::session,
                                    UndoRule::none,
                                    always_available};
    static constexpr std::tuple fields{command_field("on", &Pause::on, "false: goes on")};
};
template <>
struct Row<Advance> {
    static constexpr CommandRow row{
        "advance",
        "Step",
        "Computes frames while the session is paused. No effect in a run.",
        Receiver::session,
        UndoRule::none,
        always_available};
    static constexpr std::tuple fields{
        command_field("frames", &Advance::frames, "how many", {1, 1000000})};
};
template <>
struct Row<Play> {
    static constexpr CommandRow row{
        "play",
        "Recorded hands",
        "Plays the scene's recorded hands from their start, or stops. No effect in a run.",
        Receiver::session,
        UndoRule::none,
        always_available};
    static constexpr std::tuple fields{
        command_field("recorded", &Play::recorded, "false: the hands of the tracker or the mouse")};
};
template <>
struct Row<Mark> {
    static constexpr CommandRow row{"mark",
                                    "Mark",
                                    "Puts a text into the log; changes nothing.",
                                    Receiver::session,
                                    UndoRule::none,
                                    always_available};
    static constexpr std::tuple fields{command_field("text", &Mark::text, "the text")};
};

// Number of members of an aggregate.
namespace arity_detail {
struct Any {
    std::size_t unused;
    template <class T>
    operator T() const;
};
template <class T, std::size_t... I>
constexpr bool takes(std::index_sequence<I...>)
{
    return requires { T{Any{I}...}; };
}
}  // namespace arity_detail
template <class T, std::size_t most = 10>
constexpr std::size_t arity()
{
    if constexpr (most == 0 || arity_detail::takes<T>(std::make_index_sequence<most>{}))
        return most;
    else
        return arity<T, most - 1>();
}

template <class C>
constexpr const auto& fields_of()
{
    constexpr auto count = std::tuple_size_v<std::remove_cvref_t<decltype(Row<C>::fields)>>;
    static_assert(count == arity<C>(), "a member without a field, or a field too many");
    return Row<C>::fields;
}

// Calls visit(field, member) for each field of a command, or of a part of one.
template <class C, class Visit>
void for_each_field(C& command, const Visit& visit)
{
    std::apply([&](const auto&... f) { (visit(f, command.*(f.member)), ...); },
               fields_of<std::remove_const_t<C>>());
}

// The rows, in the order of the variant's alternatives.
template <class V>
struct RowsOf;
template <class... C>
struct RowsOf<std::variant<C...>> {
    static constexpr std::array<CommandRow, sizeof...(C)> all{Row<C>::row...};
};
inline constexpr auto& command_rows = RowsOf<Command>::all;

inline const CommandRow& row_of(const Command& command) { return command_rows[command.index()]; }

// Calls visit(std::in_place_type<C>) for the alternative of that name; false: there is none.
template <class Visit, std::size_t... I>
bool visit_command_type(std::string_view name, const Visit& visit, std::index_sequence<I...>)
{
    return ((name == command_rows[I].name
                 ? (visit(std::in_place_type<std::variant_alternative_t<I, Command>>), true)
                 : false) ||
            ...);
}
template <class Visit>
bool visit_command_type(std::string_view name, const Visit& visit)
{
    return visit_command_type(name, visit,
                              std::make_index_sequence<std::variant_size_v<Command>>{});
}

}  // namespace knead
