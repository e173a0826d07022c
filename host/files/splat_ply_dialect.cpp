#include "host/files/splat_ply_dialect.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>

#include "host/base/errors.h"

namespace knead {
namespace {

// A property that only files of another method have.
struct MethodMark {
    const char* name;
    bool prefix;  // of names that end in a number
    const char* method;
    const char* why;
};
constexpr const char *anchors =
                         "colours and opacities of its splats come from networks that are "
                         "stored beside the file; export the splats themselves",
                     *kernel = "its kernels are not Gaussians",
                     *film = "its splats move; export one point in time";
// The first that applies names the method: Octree-GS has the properties of Scaffold-GS, too.
constexpr MethodMark method_marks[] = {{"extra_level", false, "Octree-GS", anchors},
                                       {"f_anchor_feat_", true, "Scaffold-GS", anchors},
                                       {"f_offset_", true, "Scaffold-GS", anchors},
                                       {"scale_3", false, "Scaffold-GS", anchors},
                                       {"sb_params_", true, "beta splatting", kernel},
                                       {"beta", false, "beta splatting", kernel},
                                       {"motion_", true, "spacetime splatting", film},
                                       {"omega_", true, "spacetime splatting", film},
                                       {"trbf_", true, "spacetime splatting", film},
                                       {"scale_t", false, "4D splatting", film}};

bool numbered(std::string_view name, std::string_view prefix)
{
    if (!name.starts_with(prefix)) return false;
    name.remove_prefix(prefix.size());
    return !name.empty() && name.find_first_not_of("0123456789") == std::string_view::npos;
}

bool read_or_harmless(const std::string& name)
{
    constexpr std::string_view alone[] = {
        "x",     "y",      "z",         "nx",       "ny",          "nz",         "opacity",
        "red",   "green",  "blue",      "alpha",    "r",           "g",          "b",
        "label", "labels", "object_id", "objectid", "instance_id", "segment_id", "semantic_id",
        "class", "id",     "index",     "state",    "filter_3D"};
    constexpr std::string_view rows[] = {"f_dc_", "f_rest_", "scale_", "rot_", "obj_dc_"};
    return std::any_of(std::begin(alone), std::end(alone), [&](auto n) { return n == name; }) ||
           std::any_of(std::begin(rows), std::end(rows), [&](auto n) { return numbered(name, n); });
}

std::string lower(std::string_view text)
{
    std::string all(text);
    for (char& c : all) c = char(std::tolower(static_cast<unsigned char>(c)));
    return all;
}

// The value behind a key of a comment, without spaces and in lower case; "" for another comment.
std::string value_of(const std::string& comment, std::string_view key)
{
    const std::string text = lower(comment);
    if (!text.starts_with(key)) return "";
    const std::size_t from = text.find_first_not_of(" :\t", key.size());
    if (from == std::string::npos) return "";
    return text.substr(from, text.find_last_not_of(" \t\r") + 1 - from);
}

}  // namespace

void refuse_other_kernels(const PlyFile& header, const std::string& path)
{
    const auto refuse = [&](const std::string& method, const std::string& name, const char* why) {
        throw InputError(fmt::format(
            "{}: PLY header: expected 3D Gaussian splats, found those of {} (\"{}\"): {}", path,
            method, name, why));
    };
    if (header.find("codebook_centers"))
        refuse("reduced 3D Gaussian splatting", "codebook_centers",
               "its values are indices into codebooks; export them unreduced");
    const PlyElement* vertex = header.find("vertex");
    if (!vertex) return;
    for (const MethodMark& m : method_marks)
        for (const PlyProperty& p : vertex->properties)
            if (m.prefix ? p.name.starts_with(m.name) : p.name == m.name)
                refuse(m.method, p.name, m.why);
}

std::vector<std::string> unknown_properties(const PlyElement& vertex)
{
    std::vector<std::string> all;
    for (const PlyProperty& p : vertex.properties)
        if (!read_or_harmless(p.name)) all.push_back(p.name);
    return all;
}

bool says_antialiased(const PlyFile& header)
{
    bool mip = false;
    for (const std::string& comment : header.comments) {
        if (const std::string mode = value_of(comment, "splatrendermode"); !mode.empty())
            mip = mode == "mip";
        if (const std::string flag = value_of(comment, "antialiased"); !flag.empty())
            mip = flag == "1";
    }
    return mip;
}

std::vector<std::string> dialect_notes(const PlyFile& file)
{
    std::vector<std::string> notes;
    for (const std::string& comment : file.comments) {
        const std::string up = value_of(comment, "vertical axis");
        if (up == "x" || up == "y" || up == "z")
            notes.push_back(
                fmt::format("its comment gives {} as the vertical axis; a scene says "
                            "so by \"up\": \"{}\"",
                            up, up));
    }
    // ml-sharp: 0 for sRGB, 1 for linear.
    const PlyElement* space = file.find("color_space");
    if (space && space->properties.size() == 1 && !space->properties[0].list &&
        space->properties[0].values == std::vector<double>{1})
        notes.push_back("its colours are linear; they are shown as if they were sRGB");
    return notes;
}

}  // namespace knead
