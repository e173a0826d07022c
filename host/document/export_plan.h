// What the command `export` writes. Pure: depends on the document and on the file's name.
#pragma once
#include <string>
#include <variant>
#include <vector>

#include "host/document/command.h"
#include "host/scene/names.h"

namespace knead {

inline const Names<ExportContent> export_contents = {{"surface", ExportContent::surface},
                                                     {"splats", ExportContent::splats}};
inline const Names<LengthUnit> length_units = {{"m", LengthUnit::metre},
                                               {"cm", LengthUnit::centimetre},
                                               {"mm", LengthUnit::millimetre},
                                               {"in", LengthUnit::inch}};
double per_metre(LengthUnit unit);
const char* plural(LengthUnit unit);  // "metres"

constexpr const char* nothing_to_export = "there is nothing to export";

struct ExportPlan {
    ExportContent what;
    LengthUnit unit;
    // In the document's order. Of splats only objects that have some.
    std::vector<ObjectId> objects;
    bool partial = false;  // other objects with splats are left out
};
// The plan of the command, or why it is refused.
std::variant<ExportPlan, Refusal> export_plan(const Document& document, const Export& command);

// The names of the objects of a category, joined by " + "; "category N": it has none.
std::string surface_name(const Document& document, int category);

}  // namespace knead
