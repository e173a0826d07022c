#include "host/document/actions_file.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/document/command_table.h"
#include "host/scene/names.h"
#include "host/scene/object_json.h"
#include "host/scene/presets.h"

namespace knead {
namespace {

constexpr const char* actions_schema = "knead.actions/1";
constexpr double longest = 1e7, rounding = 1e-9;  // [s]

enum class ActionType { began, pause, material, gravity, hands, move };
const Names<ActionType> action_types{
    {"began", ActionType::began},       {"pause", ActionType::pause},
    {"material", ActionType::material}, {"gravity", ActionType::gravity},
    {"hands", ActionType::hands},       {"move", ActionType::move}};
const Names<bool> beginnings{{"scene", false}, {"reset", true}};

// The names of laws in these files have dashes in place of underscores.
template <class T>
Names<T> dashed(Names<T> names)
{
    for (auto& [name, value] : names)
        for (char& c : name) c = c == '_' ? '-' : c;
    return names;
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
    m.elasticity = r.choice("elasticity", dashed(elasticities), m.elasticity);
    m.plasticity = r.choice("plasticity", dashed(plasticities), m.plasticity);
    for (const Constant& c : constants) m.*c.value = r.number(c.name, c.range);
    if (!go_together(m.elasticity, m.plasticity))
        r.fail("plasticity", "one that goes with the elasticity",
               name_of(dashed(plasticities), m.plasticity));
    if (m.plasticity == Plasticity::clamp && !packing_gives_up_energy(m.compress, m.snow))
        r.fail("compress", "1.5 compress (snow + 3) below 1", std::to_string(m.compress));
    return m;
}

// Calls `is` with the value and with the numbers next to it, until it returns true. If it never
// does, the value stays.
template <class Is>
bool search(double& value, int steps, const Is& is)
{
    const double first = value;
    if (is()) return true;
    double up = value, down = value;
    for (int k = 0; k < steps; ++k) {
        value = up = std::nextafter(up, 1e300);
        if (is()) return true;
        value = down = std::nextafter(down, -1e300);
        if (is()) return true;
    }
    value = first;
    return false;
}

// The quantities that give these constants to the bit, where there are any: those that stated()
// computes are rounded.
MaterialSpec stated_exactly(const Material<double>& m)
{
    MaterialSpec found = stated(m);
    const auto same = [&](auto... constants_of) {
        const Material<double> again = made(found);
        return ((again.*constants_of == m.*constants_of) && ...);
    };
    using Constants = Material<double>;
    if (m.plasticity != Plasticity::fluid && !fault_of(found)) {
        search(found.poisson, 12, [&] {
            return search(found.young, 12,
                          [&] { return same(&Constants::mu, &Constants::lambda); });
        });
        search(found.friction_angle, 1000, [&] { return same(&Constants::friction); });
        search(found.cohesion, 12, [&] { return same(&Constants::cohesion); });
    }
    // Constants that the plasticity does not use are those of a preset.
    for (const MaterialSpec& preset : material_specs()) {
        MaterialSpec named = found;
        named.name = preset.name;
        named = normalised(named);
        Material<double> again = made(named);
        again.mass = m.mass, again.volume = m.volume, again.category = m.category;
        if (again == m) return named;
    }
    return found;
}

SetHand hand_in(ObjectReader& r, Side side)
{
    SetHand hand;
    hand.present = r.flag("present", true);
    hand.held = r.text("held", "");
    try {
        if (!hand.held->empty()) tool_rig(*hand.held, side);
    } catch (const std::exception&) {
        r.fail("held", "a tool, or nothing", hand.held->substr(0, 60));
    }
    return hand;
}

SetHands hands_in(ObjectReader& r, Vec3<double> origin)
{
    SetHands hands;
    hands.zoom = r.number("zoom", {0, 1e6, "", true});
    hands.at = r.vector("at", {-1e6, 1e6, "m"}) + origin;
    r.object("left", [&](ObjectReader& in) { hands.left = hand_in(in, left); });
    r.object("right", [&](ObjectReader& in) { hands.right = hand_in(in, right); });
    return hands;
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

std::variant<Command, Moved> action_in(ObjectReader& r, Vec3<double> origin)
{
    r.required("do", "what was done");
    // Objects are numbered from 0 here.
    const auto object = [&] {
        r.required("object", "a number");
        return ObjectId{std::uint32_t(r.whole("object", 0, 1000000, 0) + 1)};
    };
    switch (r.choice("do", action_types, ActionType::began)) {
        case ActionType::began:
            r.required("by", "scene or reset");
            return Command(Mark{r.choice("by", beginnings, false) ? "reset" : "scene"});
        case ActionType::pause:
            return Command(Pause{r.flag("on", false)});
        case ActionType::material: {
            SetMaterial to{object(), {}};
            r.object("material",
                     [&](ObjectReader& in) { to.material = stated_exactly(material_in(in)); });
            return Command(to);
        }
        case ActionType::gravity:
            return Command(SetGravity{r.vector("gravity", {-1e4, 1e4, "m/s2"})});
        case ActionType::hands: {
            SetHands to;
            r.object("hands", [&](ObjectReader& in) { to = hands_in(in, origin); });
            return Command(to);
        }
        case ActionType::move:
            break;
    }
    const ObjectId moved = object();
    return Moved{moved, motion_in(r)};
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

ActionsFile parse_actions(const std::string& text, const std::string& file, double rate,
                          Vec3<double> origin)
{
    ActionsFile actions;
    ObjectReader::read(parse_json(text, file), file, "", [&](ObjectReader& r) {
        const std::string found = r.text("schema", "");
        if (found != actions_schema)
            r.fail("schema", actions_schema, "\"" + found.substr(0, 60) + "\"");
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
                const double time = in.number("time", {0, longest, "s"});
                if (time < before)
                    in.fail("time", "one that is not before the last", short_number(time));
                before = time;
                // An action precedes the first frame with a later end.
                actions.all.push_back(
                    {long(std::floor((time + rounding) * rate)), action_in(in, origin), 0});
            });
        }
    });
    return actions;
}

ActionsFile read_actions(const std::string& file, double rate, Vec3<double> origin)
{
    return parse_actions(read_text(file, max_json_bytes), file, rate, origin);
}

}  // namespace knead
