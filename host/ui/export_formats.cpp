#include "host/ui/export_formats.h"

#include <utility>

#include "host/files/webp.h"
#include "host/session/session_file.h"

namespace knead {
namespace {

const std::vector<std::pair<std::string, std::string>>& formats()
{
    static const std::vector<std::pair<std::string, std::string>> all{
        {".glb", "glTF: Blender, game engines, browsers"},
        {".stl", "STL: slicers of 3D printers"},
        {".3mf", "3MF: slicers of 3D printers, with unit and colours"},
        {".obj", "OBJ: any modelling program"},
        {".ply", "PLY: MeshLab; splats: SuperSplat"},
        {".spz", "SPZ: splats, small"},
        {".splat", "splat: splats for browsers"},
        {".sog", "SOG: splats, small, PlayCanvas"}};
    return all;
}

}  // namespace

std::vector<std::string> openable_endings()
{
    std::vector<std::string> all = export_endings();
    all.insert(all.begin(), {".json", session_ending});
    return all;
}

std::vector<std::string> export_endings()
{
    std::vector<std::string> all;
    for (const auto& [ending, text] : formats())
        if (ending != ".sog" || webp_available()) all.push_back(ending);
    return all;
}

std::string export_format_text(const std::string& ending)
{
    for (const auto& [one, text] : formats())
        if (one == ending) return text;
    return ending.empty() ? "choose a format" : ending + ": not a format";
}

}  // namespace knead
