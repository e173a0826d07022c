#include "host/document/export_plan.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/base/paths.h"
#include "host/document/reduce.h"

namespace knead {
namespace {

bool has_splats(const SceneObject& object) { return object.source.shape == ShapeKind::splats; }

bool among(const std::string& form, std::initializer_list<const char*> forms)
{
    return std::ranges::find(forms, form) != forms.end();
}

}  // namespace

double per_metre(LengthUnit unit)
{
    switch (unit) {
        case LengthUnit::centimetre:
            return 100;
        case LengthUnit::millimetre:
            return 1000;
        case LengthUnit::inch:
            return 1 / 0.0254;
        default:
            return 1;
    }
}

const char* plural(LengthUnit unit)
{
    switch (unit) {
        case LengthUnit::centimetre:
            return "centimetres";
        case LengthUnit::millimetre:
            return "millimetres";
        case LengthUnit::inch:
            return "inches";
        default:
            return "metres";
    }
}

std::variant<ExportPlan, Refusal> export_plan(const Document& document, const Export& command)
{
    if (document.objects.empty()) return Refusal{nothing_to_export, ""};
    std::vector<ObjectId> named;
    if (command.objects)
        for (const ObjectRef& ref : *command.objects) {
            const auto found = resolved(document, ref, "objects");
            if (const Refusal* refusal = std::get_if<Refusal>(&found)) return *refusal;
            named.push_back(std::get<ObjectId>(found));
        }
    std::vector<const SceneObject*> chosen;
    for (const auto& o : document.objects)
        if (command.objects ? std::ranges::count(named, o->id) > 0 : !o->hidden)
            chosen.push_back(o.get());
    if (chosen.empty())
        return Refusal{"all objects are hidden; expected the objects to export", "objects"};

    const std::string form = ending(command.file);
    const bool of_surface = among(form, {".3mf", ".glb", ".obj", ".ply", ".stl"}),
               of_splats = among(form, {".glb", ".ply", ".sog", ".splat", ".spz"});
    const bool only_splats = std::ranges::all_of(chosen, [](auto* o) { return has_splats(*o); });
    ExportPlan plan{};
    if (command.what)
        plan.what = *command.what;
    else if (of_surface && of_splats)
        plan.what = only_splats ? ExportContent::splats : ExportContent::surface;
    else
        plan.what = of_splats ? ExportContent::splats : ExportContent::surface;
    const bool splats = plan.what == ExportContent::splats;
    if (!of_surface && !of_splats)
        return Refusal{
            "expected a name that ends in .3mf, .glb, .obj, .ply or .stl for the surface, in "
            ".glb, .ply, .sog, .splat or .spz for splats",
            "file"};
    if (splats ? !of_splats : !of_surface)
        return Refusal{fmt::format("expected a name that ends in {}",
                                   splats ? ".glb, .ply, .sog, .splat or .spz for splats"
                                          : ".3mf, .glb, .obj, .ply or .stl for the surface"),
                       "file"};
    const LengthUnit usual =
        form == ".stl" || form == ".3mf" ? LengthUnit::millimetre : LengthUnit::metre;
    plan.unit = command.unit.value_or(usual);
    for (const SceneObject* o : chosen)
        if (!splats || has_splats(*o)) plan.objects.push_back(o->id);
    if (plan.objects.empty())
        return Refusal{
            command.objects ? "expected an object of splats" : "there are no splats to export",
            command.objects ? "objects" : ""};
    plan.partial = std::ranges::any_of(document.objects, [&](const auto& o) {
        return has_splats(*o) && std::ranges::count(plan.objects, o->id) == 0;
    });
    return plan;
}

std::string surface_name(const Document& document, int category)
{
    std::string all;
    for (const auto& o : document.objects)
        if (o->category == category) all += (all.empty() ? "" : " + ") + o->name;
    return all.empty() ? fmt::format("category {}", category) : all;
}

}  // namespace knead
