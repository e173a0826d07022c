// knead list: presets, gestures and scenes, one per line, name first.
#include <fmt/format.h>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/paths.h"
#include "host/base/print.h"
#include "host/cli/verbs.h"
#include "host/hands/gesture.h"
#include "host/scene/presets.h"

namespace knead {
namespace {

void list_presets()
{
    for (const MaterialSpec& m : material_specs()) {
        const std::string stiff = m.plasticity == Plasticity::fluid
                                      ? fmt::format("bulk {:.3g} Pa", m.bulk)
                                      : fmt::format("Young's modulus {:.3g} Pa", m.young);
        print(fmt::format("{:<16} {} kg/m3, {}\n", m.name, m.density, stiff));
    }
}

void list_gestures()
{
    for (const Gesture& g : gestures()) {
        std::string held;
        for (const std::string& tool : g.held)
            if (!tool.empty()) held += ", with a " + tool;
        print(fmt::format("{:<16} {} s{}\n", g.name, g.seconds, held));
    }
}

// The first comment of a scene file is its description.
std::string first_comment(const std::string& text)
{
    const std::size_t at = text.find("// ");
    if (at == std::string::npos) return "";
    return text.substr(at + 3, text.find('\n', at) - at - 3);
}

void list_scenes()
{
    const std::vector<std::string> names = shipped_scenes();
    if (names.empty()) throw InputError("the bundled scenes are missing");
    for (const std::string& name : names)
        print(fmt::format(
            "{:<16} {}\n", name,
            first_comment(read_text(shipped("scenes/" + name + ".json"), max_json_bytes))));
}

}  // namespace

int list_verb(const ListOptions& o)
{
    const std::vector<std::string> kinds{"presets", "materials", "gestures", "scenes"};
    requested_names("list of", {o.kind}, kinds);
    if (o.kind == "gestures")
        list_gestures();
    else if (o.kind == "scenes")
        list_scenes();
    else
        list_presets();
    return exit_ok;
}

}  // namespace knead
