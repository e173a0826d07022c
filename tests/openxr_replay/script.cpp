#include "tests/openxr_replay/script.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/base/json_reader.h"
#include "host/hands/recording.h"

namespace knead::replay {
namespace {

const std::vector<std::pair<std::string, FaultKind>> kinds{
    {"lose_session", FaultKind::lose_session},
    {"session_loss", FaultKind::session_loss},
    {"lose_instance", FaultKind::lose_instance},
    {"lose_headset", FaultKind::lose_headset},
    {"take_off", FaultKind::take_off},
    {"unworn", FaultKind::unworn},
    {"no_render", FaultKind::no_render},
    {"lose_hand", FaultKind::lose_hand},
    {"invalid_joints", FaultKind::invalid_joints},
    {"invalid_fingers", FaultKind::invalid_fingers},
    {"constant_radii", FaultKind::constant_radii},
    {"leap", FaultKind::leap},
    {"refresh", FaultKind::refresh},
    {"recentre", FaultKind::recentre},
    {"gl_error", FaultKind::gl_error},
    {"steal_context", FaultKind::steal_context},
    {"busy_images", FaultKind::busy_images},
    {"hang", FaultKind::hang},
    {"exit", FaultKind::exit},
};
constexpr Bounds place{-100, 100, "m"}, moment{0, 1e6, "s"}, angle{-360, 360, "degrees"};

// Turned by `turn` about y, then by `tilt` about the x that it has then [degrees].
Joint<double> pose_of(ObjectReader& from)
{
    const double degree = 3.14159265358979323846 / 180;
    const Quat<double> turn =
        turn_about(Vec3<double>{0, 1, 0}, degree * from.number("turn", angle, 0));
    const Quat<double> tilt =
        turn_about(Vec3<double>{1, 0, 0}, degree * from.number("tilt", angle, 0));
    const Quat<double> roll =
        turn_about(Vec3<double>{0, 0, 1}, degree * from.number("roll", angle, 0));
    return {unit(turn * tilt * roll), from.vector("at", place, {0, 0, 0})};
}

std::optional<Side> side_of(ObjectReader& from)
{
    if (!from.has("side")) return {};
    return from.choice<Side>("side", {{"left", left}, {"right", right}}, right);
}

// Reads every object of the list under `key`.
void list(ObjectReader& from, const std::string& key, const std::string& file,
          const ObjectReader::Body& body)
{
    const Json* all = from.find(key);
    if (!all) return;
    if (!all->is_array()) from.fail(key, "a list", described(*all));
    for (std::size_t i = 0; i < all->size(); ++i)
        ObjectReader::read((*all)[i], file, from.pointer(key) + "/" + std::to_string(i), body);
}

void read_moving(Script& script, ObjectReader& from, const std::string& file)
{
    list(from, "head", file, [&](ObjectReader& key) {
        script.head.push_back({key.number("time", moment, 0), pose_of(key)});
    });
    if (script.head.empty()) script.head.push_back({});
    list(from, "controllers", file, [&](ObjectReader& key) {
        Controller c;
        c.side = side_of(key).value_or(right);
        c.from = key.number("from", moment, 0), c.to = key.number("to", moment, 1e6);
        c.grip = pose_of(key);
        c.velocity = key.vector("velocity", {-10, 10, "m/s"}, {0, 0, 0});
        c.trigger = key.number("trigger", {0, 1}, 0), c.squeeze = key.number("squeeze", {0, 1}, 0);
        c.lower = key.number("lower", {0, 1}, 0), c.upper = key.number("upper", {0, 1}, 0);
        script.controllers.push_back(c);
    });
    list(from, "faults", file, [&](ObjectReader& key) {
        Fault f{key.choice<FaultKind>("kind", kinds, FaultKind::exit), 0, 1, side_of(key), 0, ""};
        f.frame = key.whole("frame", 0, 1000000, 0), f.count = key.whole("count", 1, 1000000, 1);
        f.value = key.number("value", {0, 1000}, 0), f.call = key.text("call", "xrWaitFrame");
        script.faults.push_back(f);
    });
}

// From 0 to 1 between two times.
double share(double from, double to, double at)
{
    return to > from ? clamp((at - from) / (to - from), 0.0, 1.0) : 0;
}

}  // namespace

Script Script::read(const std::string& file)
{
    Script script;
    ObjectReader::read(read_json(file), file, "", [&](ObjectReader& from) {
        script.rate = from.number("rate", {1, 1000, "1/s"}, script.rate);
        script.real_time = from.flag("real_time", false);
        script.width = from.whole("width", 16, 8192, script.width);
        script.height = from.whole("height", 16, 8192, script.height);
        script.eyes_apart = from.number("eyes_apart", {0, 1, "m"}, script.eyes_apart);
        const std::string recording = from.text("hands", "");
        if (!recording.empty()) script.hands = read_recording(recording);
        script.hands_at = from.vector("hands_at", place, {0, 0, 0});
        script.log = from.text("log", ""), script.dump = from.text("dump", "");
        script.dump_every = from.whole("dump_every", 1, 1000000, 1);
        script.render_every = from.whole("render_every", 1, 1000000, 1);
        script.passthrough = from.flag("passthrough", false);
        script.service = from.flag("service", true), script.headset = from.flag("headset", true);
        if (const Json* names = from.find("without"))
            script.without = names->get<std::vector<std::string>>();
        read_moving(script, from, file);
    });
    return script;
}

int Script::frame_at(double time) const { return int(std::floor(time * rate + 1e-3)); }

bool Script::has(FaultKind kind, int frame, std::optional<Side> side) const
{
    return std::any_of(faults.begin(), faults.end(), [&](const Fault& f) {
        return f.kind == kind && f.during(frame) && (!side || f.of(*side));
    });
}

Joint<double> head_at(const Script& script, double time)
{
    const auto after = std::upper_bound(script.head.begin(), script.head.end(), time,
                                        [](double t, const HeadKey& k) { return t < k.time; });
    const HeadKey& to = after == script.head.end() ? script.head.back() : *after;
    const HeadKey& from = after == script.head.begin() ? to : *(after - 1);
    const double s = share(from.time, to.time, time);
    return between(from.pose, to.pose, s);
}

Joint<double> eye_at(const Script& script, double time, int eye)
{
    const Joint<double> head = head_at(script, time);
    const double x = (eye == 0 ? -0.5 : 0.5) * script.eyes_apart;
    return {head.q, head.p + rotate(head.q, Vec3<double>{x, 0, 0})};
}

HandAnswer hand_at(const Script& script, Side side, double time)
{
    const int frame = script.frame_at(time);
    if (!script.hands || script.has(FaultKind::lose_hand, frame, side)) return {};
    const std::vector<HandFrame>& all = script.hands->frames;
    if (time > all.back().time + 1e-6) return {};
    const auto after = std::upper_bound(all.begin(), all.end(), time,
                                        [](double t, const HandFrame& f) { return t < f.time; });
    const HandFrame& to = after == all.end() ? all.back() : *after;
    const HandFrame& from = after == all.begin() ? to : *(after - 1);
    const Hand &a = from.hand[side], &b = to.hand[side];
    if (!a.tracked || !b.tracked) return {};
    HandAnswer answer{true, a};
    const float s = float(share(from.time, to.time, time));
    const Vec3<float> shift = cast<float>(script.hands_at);
    for (int j = 0; j < joint_count; ++j) {
        Joint<float>& joint = answer.hand.joints[j];
        joint = between(a.joints[j], b.joints[j], s);
        joint.p = joint.p + shift;
        if (script.has(FaultKind::leap, frame, side)) joint.p.y += 0.3f;
        answer.hand.valid[j] = a.valid[j] && b.valid[j];
        if (script.has(FaultKind::invalid_joints, frame, side)) answer.hand.valid[j] = false;
        if (script.has(FaultKind::invalid_fingers, frame, side) && j > wrist)
            answer.hand.valid[j] = false;
        if (script.has(FaultKind::constant_radii, frame, side)) answer.hand.radius[j] = 0.01f;
    }
    return answer;
}

const Controller* controller_at(const Script& script, Side side, double time)
{
    for (const Controller& c : script.controllers)
        if (c.side == side && time >= c.from && time < c.to) return &c;
    return nullptr;
}

Joint<double> grip_at(const Controller& c, double time)
{
    return {c.grip.q, c.grip.p + (time - c.from) * c.velocity};
}

}  // namespace knead::replay
