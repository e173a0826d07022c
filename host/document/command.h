// Commands: the only way to change a document, or the session that it is in. Those that set values
// hold absolute ones: the last of several decides, and repeating one has no effect. Each has one
// row, with its fields, in command_table.h.
#pragma once
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "host/document/document.h"

namespace knead {

// An object by its id or by its name. A name that no object or several objects have is refused.
struct ObjectRef {
    std::variant<ObjectId, std::string> by;
    ObjectRef() = default;
    ObjectRef(ObjectId id) : by(id) {}
    ObjectRef(std::string name) : by(std::move(name)) {}
};

// Of the document. An absent optional value is unchanged.
struct AddObject {
    SceneObject object;  // id 0: a new one is given to it
};
struct RemoveObjects {
    std::vector<ObjectRef> objects;
};
struct PlaceObject {
    ObjectRef object;
    std::optional<Vec3<double>> centre;    // [m]
    std::optional<Quat<double>> rotation;  // from the object's frame
};
struct SetMaterial {
    ObjectRef object;
    MaterialSpec material;
};
struct SetCategory {
    ObjectRef object;
    int category = 0;
};
struct Rename {
    ObjectRef object;
    std::string name;
};
struct SetFlags {
    ObjectRef object;
    std::optional<bool> locked, hidden;
};
struct SetColour {
    std::vector<ObjectRef> objects;
    std::optional<Vec3<double>> colour;  // sRGB, 0 to 1; absent: that of their category
};
// Copies have the full state of their objects' clay, and its splats.
struct CopyObjects {
    std::vector<ObjectRef> objects;
    Vec3<double> by{};               // [m]
    std::vector<std::string> names;  // of the first copies; the others: "NAME copy"
    std::vector<ObjectId> ids;       // of the copies; empty: new ones are given to them
};
// Rigid motion of several objects as one: turned about a point, then displaced.
struct MoveObjects {
    std::vector<ObjectRef> objects;
    std::optional<Vec3<double>> by;     // [m]; absent: 0
    std::optional<Quat<double>> turn;   // absent: none
    std::optional<Vec3<double>> about;  // [m]; absent: the middle of their centres of mass
};
// New clay in place of that of objects, as they were made: where commands have placed them.
struct ResetObjects {
    std::vector<ObjectRef> objects;
};
// True rescale: size, volume and mass of the clay change, not the view of it.
struct ScaleObjects {
    std::vector<ObjectRef> objects;  // each about its own centre of mass
    double factor = 1;
};
struct MergeObjects {
    std::vector<ObjectRef> objects;   // the first stays, and has the clay of all
    std::optional<std::string> name;  // absent: that of the first
};
struct SplitPlane {
    Vec3<double> point{}, normal{};  // [m]; of any length
};
// Either by a plane, or by pieces that are not connected. The largest part keeps the number.
struct SplitObject {
    ObjectRef object;
    std::optional<SplitPlane> plane;
    std::optional<bool> pieces;
    // Of the part before the plane, which its normal points into, and of the one behind it; of
    // pieces, from the largest.
    std::vector<std::string> names;
    std::vector<ObjectId>
        ids;  // of the parts in this order; empty: new ones, one of them is the object's
    // Of the parts in this order; empty: that of the object.
    std::vector<int> categories{};
};
// Begins an object of clay from a nozzle, which source_move lays and source_end ends.
struct SourceBegin {
    std::string name;
    std::optional<SectionKind> section;          // absent: a circle
    double diameter = 0;                         // of the section [m]
    std::optional<std::vector<Point2>> outline;  // of section `outline`, in any unit
    std::optional<MaterialSpec> material;        // absent: clay
    std::optional<int> category;                 // absent: 0
    Vec3<double> at{};                           // of the nozzle [m]
    std::optional<Vec3<double>> axis;            // of any length; absent: along the motion
    std::vector<ObjectId> ids;                   // of the object; empty: a new one is given to it
};
struct SourceMove {
    ObjectRef object;
    Vec3<double> at{};                 // [m]
    std::optional<Vec3<double>> axis;  // absent: as before
};
struct SourceEnd {
    ObjectRef object;
};
struct SetGravity {
    Vec3<double> gravity{};  // [m/s^2]
};
struct SetWalls {
    std::optional<Vec3<double>> min, max;  // [m]
    std::optional<ContactMode> contact_mode;
    std::optional<double> friction;
};
enum class CategoryContact { weld, separate };
struct SetContact {
    std::optional<CategoryContact> categories;
    std::optional<double> friction;  // Coulomb [1]
};
struct SetHand {
    std::optional<bool> present;
    std::optional<std::string> held;
};
struct SetHands {
    SetHand left, right;
    std::optional<double> zoom;
    std::optional<Vec3<double>> at;  // [m]
};
struct SetSurface {
    int nodes = 0;  // along the longest side
};
struct SetLattice {
    int cells = 0;  // along the longest axis
};

// Of the session.
struct Carry {
    std::vector<ObjectRef> objects;
    Side side = right;
    bool begins = false;  // true: start; false: stop. While carried, objects move with the palm
};
struct Open {
    std::string file;
    std::vector<std::string> settings;  // --set
    std::optional<int> cells;           // along the longest axis; absent: as in the file
};
struct Save {
    std::string file;
    std::optional<bool> input;  // recordings of the hands, too; absent: yes
};
enum class ExportContent { surface, splats };
enum class LengthUnit { metre, centimetre, millimetre, inch };
struct Export {
    std::string file;                   // its ending is the format
    std::optional<ExportContent> what;  // absent: the surface if there is one, else the splats
    std::optional<LengthUnit> unit;  // of numbers in the file; absent: mm for .stl and .3mf, else m
    std::optional<std::vector<ObjectRef>> objects;  // absent: all that are not hidden
};
struct Undo {};
struct Redo {};
struct GoTo {
    int step = 0;  // 0: the beginning
};
struct Reset {};
struct Pause {
    bool on = false;
};
struct Advance {
    int frames = 1;
};
struct Play {
    bool recorded = false;
};
struct Mark {
    std::string text;
};

using Command =
    std::variant<AddObject, RemoveObjects, PlaceObject, SetMaterial, SetCategory, Rename, SetFlags,
                 SetColour, CopyObjects, MoveObjects, ResetObjects, ScaleObjects, MergeObjects,
                 SplitObject, SourceBegin, SourceMove, SourceEnd, SetGravity, SetWalls, SetContact,
                 SetHands, SetSurface, SetLattice, Carry, Open, Save, Export, Undo, Redo, GoTo,
                 Reset, Pause, Advance, Play, Mark>;

// Whether it is of a nozzle.
inline bool of_source(const Command& command)
{
    return std::holds_alternative<SourceBegin>(command) ||
           std::holds_alternative<SourceMove>(command) ||
           std::holds_alternative<SourceEnd>(command);
}
// Whether the clay of the scene decides what the command does: it is not made from the document,
// and is more than the difference of two documents.
inline bool reads_clay(const Command& command)
{
    return std::holds_alternative<CopyObjects>(command) ||
           std::holds_alternative<MoveObjects>(command) ||
           std::holds_alternative<ResetObjects>(command) ||
           std::holds_alternative<ScaleObjects>(command) ||
           std::holds_alternative<MergeObjects>(command) ||
           std::holds_alternative<SplitObject>(command) || of_source(command);
}
// Whether it gives numbers to new objects.
inline bool adds_objects(const Command& command)
{
    return std::holds_alternative<AddObject>(command) ||
           std::holds_alternative<CopyObjects>(command) ||
           std::holds_alternative<SplitObject>(command) ||
           std::holds_alternative<SourceBegin>(command);
}

// The numbers that it has given to objects, as it was applied.
inline std::vector<ObjectId> new_ids(const Command& command)
{
    if (const AddObject* adds = std::get_if<AddObject>(&command)) return {adds->object.id};
    if (const CopyObjects* copies = std::get_if<CopyObjects>(&command)) return copies->ids;
    if (const SplitObject* splits = std::get_if<SplitObject>(&command)) return splits->ids;
    if (const SourceBegin* begins = std::get_if<SourceBegin>(&command)) return begins->ids;
    return {};
}

enum class Origin { window, headset, script, replay };

// A command as it was sent.
struct Issued {
    Command command;
    long serial = 0;
    Origin origin = Origin::window;
    // Not 0: number of the drag of a control. A waiting command is dropped if a later one of the
    // same drag, type and object sets all its values. Not for rows with UndoRule::step.
    unsigned drag = 0;
};

// Why a command was refused. It has changed neither document nor clay.
struct Refusal {
    std::string why;
    std::string field;  // of the command; "": the command as a whole
    std::string text() const { return field.empty() ? why : field + ": " + why; }
};

// What became of a command.
struct CommandAnswer {
    std::optional<Refusal> refusal;
    Command applied;  // with ids in place of names, and the id given to a new object
};

}  // namespace knead
