#include "host/session/hand_actions.h"

#include <nlohmann/json.hpp>

#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/scene/seed.h"

namespace knead {
namespace {

constexpr const char* schema = "knead.actions/1";
constexpr double longest = 1e7;  // [s]

template <class T>
using Names = std::vector<std::pair<std::string, T>>;

const Names<ActionType> act_names{
    {"began", ActionType::began},       {"pause", ActionType::pause},
    {"material", ActionType::material}, {"gravity", ActionType::gravity},
    {"hands", ActionType::hands},       {"move", ActionType::move}};
const Names<Elasticity> elasticities{{"neo-hookean", Elasticity::neo_hookean},
                                     {"fixed-corotated", Elasticity::fixed_corotated},
                                     {"hencky", Elasticity::hencky}};
const Names<Plasticity> plasticities{{"none", Plasticity::none},
                                     {"von-mises", Plasticity::von_mises},
                                     {"drucker-prager", Plasticity::drucker_prager},
                                     {"clamp", Plasticity::clamp},
                                     {"herschel-bulkley", Plasticity::herschel_bulkley},
                                     {"fluid", Plasticity::fluid}};
const Names<std::string> beginnings{{"scene", "scene"}, {"reset", "reset"}};

template <class T>
std::string name_of(const Names<T>& names, const T& value)
{
    for (const auto& [name, one] : names)
        if (one == value) return name;
    return "";
}

struct Constant {
    const char* name;
    double Material<double>::*value;
    Bounds range;
};
const Constant constants[] = {{"density", &Material<double>::density, {0, 1e6, "kg/m3", true}},
                              {"mu", &Material<double>::mu, {0, 1e13, "Pa"}},
                              {"lambda", &Material<double>::lambda, {-1e13, 1e13, "Pa"}},
                              {"bulk", &Material<double>::bulk, {0, 1e13, "Pa"}},
                              {"yield", &Material<double>::yield, {0, 1e13, "Pa"}},
                              {"hardening", &Material<double>::hardening, {-1e13, 1e13, "Pa"}},
                              {"yield_floor", &Material<double>::yield_floor, {0, 1e13, "Pa"}},
                              {"friction", &Material<double>::friction, {0, 1e3}},
                              {"cohesion", &Material<double>::cohesion, {0, 1e6}},
                              {"compress", &Material<double>::compress, {0, 1}},
                              {"stretch", &Material<double>::stretch, {0, 1e3}},
                              {"snow", &Material<double>::snow, {0, 1e3}},
                              {"viscosity", &Material<double>::viscosity, {0, 1e9, "Pa s^n"}},
                              {"exponent", &Material<double>::exponent, {0, 1e3}}};

Material<double> material_in(ObjectReader& r)
{
    Material<double> m{};
    for (const char* key : {"elasticity", "plasticity"}) r.required(key, "a name");
    m.elasticity = r.choice("elasticity", elasticities, m.elasticity);
    m.plasticity = r.choice("plasticity", plasticities, m.plasticity);
    for (const Constant& c : constants) m.*c.value = r.number(c.name, c.range);
    if (!go_together(m.elasticity, m.plasticity))
        r.fail("plasticity", "one that goes with the elasticity",
               name_of(plasticities, m.plasticity));
    if (m.plasticity == Plasticity::clamp && !packing_gives_up_energy(m.compress, m.snow))
        r.fail("compress", "1.5 compress (snow + 3) below 1", std::to_string(m.compress));
    return m;
}
Json json_of(const Material<double>& m)
{
    Json of{{"elasticity", name_of(elasticities, m.elasticity)},
            {"plasticity", name_of(plasticities, m.plasticity)}};
    for (const Constant& c : constants) of[c.name] = m.*c.value;
    return of;
}

constexpr const char* side_names[side_count] = {"left", "right"};

HandsOptions hands_in(ObjectReader& r)
{
    HandsOptions options;
    options.zoom = r.number("zoom", {0, 1e6, "", true});
    options.at = r.vector("at", {-1e6, 1e6, "m"});
    for (int side = 0; side < side_count; ++side)
        r.object(side_names[side], [&](ObjectReader& in) {
            options.present[side] = in.flag("present", true);
            options.held[side] = in.text("held", "");
            try {
                if (!options.held[side].empty()) tool_rig(options.held[side], Side(side));
            } catch (const std::exception&) {
                in.fail("held", "a tool, or nothing", options.held[side].substr(0, 60));
            }
        });
    return options;
}
Json json_of(const HandsOptions& options)
{
    Json of{{"zoom", options.zoom}, {"at", {options.at.x, options.at.y, options.at.z}}};
    for (int side = 0; side < side_count; ++side)
        of[side_names[side]] = {{"present", options.present[side]}, {"held", options.held[side]}};
    return of;
}

// The turn is a unit quaternion: "turn" its vector part, "turn_w" its scalar part.
RigidMotion<double> motion_in(ObjectReader& r)
{
    RigidMotion<double> m;
    const Vec3<double> v = r.vector("turn", {-1, 1});
    m.q = {r.number("turn_w", {-1, 1}), v.x, v.y, v.z};
    const double size = m.q.w * m.q.w + dot(v, v);
    if (!(size > 0.999 && size < 1.001)) r.fail("turn", "a quaternion of length 1", "another");
    m.p = r.vector("shift", {-1e6, 1e6, "m"});
    return m;
}

HandAction action_in(ObjectReader& r, double before)
{
    HandAction a;
    a.time = r.number("time", {0, longest, "s"});
    if (a.time < before) r.fail("time", "one that is not before the last", short_number(a.time));
    r.required("do", "what was done");
    a.act = r.choice("do", act_names, a.act);
    const auto object = [&] {
        r.required("object", "a number");
        a.object = r.whole("object", 0, 1000000, 0);
    };
    switch (a.act) {
        case ActionType::began:
            r.required("by", "scene or reset");
            a.by = r.choice("by", beginnings, a.by);
            break;
        case ActionType::pause:
            a.on = r.flag("on", false);
            break;
        case ActionType::material:
            object();
            r.object("material", [&](ObjectReader& in) { a.material = material_in(in); });
            break;
        case ActionType::gravity:
            a.gravity = r.vector("gravity", {-1e4, 1e4, "m/s2"});
            break;
        case ActionType::hands:
            r.object("hands", [&](ObjectReader& in) { a.hands = hands_in(in); });
            break;
        case ActionType::move:
            object();
            a.motion = motion_in(r);
            break;
    }
    return a;
}

Json json_of(const HandAction& a)
{
    Json of{{"time", a.time}, {"do", name_of(act_names, a.act)}};
    switch (a.act) {
        case ActionType::began:
            of["by"] = a.by;
            break;
        case ActionType::pause:
            of["on"] = a.on;
            break;
        case ActionType::material:
            of["object"] = a.object, of["material"] = json_of(a.material);
            break;
        case ActionType::gravity:
            of["gravity"] = {a.gravity.x, a.gravity.y, a.gravity.z};
            break;
        case ActionType::hands:
            of["hands"] = json_of(a.hands);
            break;
        case ActionType::move:
            of["object"] = a.object;
            of["turn"] = {a.motion.q.x, a.motion.q.y, a.motion.q.z}, of["turn_w"] = a.motion.q.w;
            of["shift"] = {a.motion.p.x, a.motion.p.y, a.motion.p.z};
            break;
    }
    return of;
}

const Json& list_in(ObjectReader& r, const std::string& key, std::size_t most)
{
    const Json& list = r.required(key, "a list");
    if (!list.is_array() || list.size() > most)
        r.fail(key, "a list of at most " + std::to_string(most), described(list));
    return list;
}

}  // namespace

std::string actions_file(const std::string& recording) { return recording + ".actions"; }

HandActions parse_actions(const std::string& text, const std::string& file)
{
    HandActions actions;
    ObjectReader::read(parse_json(text, file), file, "", [&](ObjectReader& r) {
        const std::string found = r.text("schema", "");
        if (found != schema) r.fail("schema", schema, "\"" + found.substr(0, 60) + "\"");
        actions.scene = r.text("scene", "");
        actions.recording = r.text("recording", "");
        for (const Json& one : list_in(r, "settings", 1000)) {
            if (!one.is_string()) r.fail("settings", "a list of texts", described(one));
            actions.settings.push_back(one.get<std::string>());
        }
        double before = 0;
        std::size_t number = 0;
        for (const Json& one : list_in(r, "actions", most_actions)) {
            const std::string at = r.pointer("actions") + "/" + std::to_string(number++);
            ObjectReader::read(one, file, at, [&](ObjectReader& in) {
                actions.all.push_back(action_in(in, before));
            });
            before = actions.all.back().time;
        }
    });
    return actions;
}

HandActions read_actions(const std::string& file)
{
    return parse_actions(read_text(file, max_json_bytes), file);
}

std::string to_text(const HandActions& actions)
{
    Json of{{"schema", schema},
            {"scene", actions.scene},
            {"settings", actions.settings},
            {"recording", actions.recording}};
    // One action per line.
    std::string lines;
    for (const HandAction& a : actions.all)
        lines += (lines.empty() ? "\n  " : ",\n  ") + json_of(a).dump();
    std::string text = of.dump(1, ' ', false, Json::error_handler_t::replace);
    text.resize(text.size() - 2);
    return text + ",\n \"actions\": [" + lines + "]\n}\n";
}

void write_actions(const std::string& file, const HandActions& actions)
{
    write_whole(file, to_text(actions));
}

}  // namespace knead
