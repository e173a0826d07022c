#include "host/document/command_table.h"

#include "host/document/export_plan.h"

namespace knead {

std::string always_available(const Situation&) { return ""; }

std::string needs_simulation(const Situation& s)
{
    return s.simulation ? "" : "there is no simulation";
}

std::string needs_edits(const Situation& s)
{
    if (!s.simulation) return needs_simulation(s);
    return s.editable ? "" : "this simulator takes no edits (--device cpu:double)";
}

std::string needs_live(const Situation& s)
{
    return s.live ? "" : "a run has one scene and one beginning";
}

std::string needs_no_work(const Situation& s)
{
    if (!s.live) return "a run's lattice is given before it begins: --cells, --set domain.cells";
    if (s.work.empty()) return "";
    return "another lattice begins the scene again, and " + s.work + " would be lost; reset first";
}

std::string needs_undo(const Situation& s)
{
    if (!needs_edits(s).empty()) return needs_edits(s);
    return s.no_undo;
}

std::string needs_redo(const Situation& s)
{
    if (!needs_edits(s).empty()) return needs_edits(s);
    return s.no_redo;
}

std::string needs_steps(const Situation& s)
{
    if (!needs_edits(s).empty()) return needs_edits(s);
    return s.no_steps;
}

std::string needs_log(const Situation& s) { return s.simulation ? s.no_save : needs_simulation(s); }

std::string needs_contents(const Situation& s)
{
    if (!s.simulation) return needs_simulation(s);
    return s.document && s.document->objects.empty() ? nothing_to_export : "";
}

}  // namespace knead
