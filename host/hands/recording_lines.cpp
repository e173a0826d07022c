// Recordings as JSON lines: a header, then one line per frame.
#include <fmt/format.h>

#include <charconv>
#include <nlohmann/json.hpp>
#include <utility>

#include "host/base/text_number.h"
#include "host/hands/recording_rules.h"

namespace knead {
namespace {

using json = nlohmann::json;

constexpr const char* side_names[side_count] = {"left", "right"};

// Appends a number to a JSON line, in the shortest form that reads back as the same value.
template <class R>
void put_number(std::string& line, R x)
{
    char digits[32];
    line.append(digits, std::to_chars(digits, digits + sizeof digits, x).ptr);
}

const json& member(const json& object, const char* key, const Place& place)
{
    const auto found = object.find(key);
    if (found == object.end()) place.refuse(fmt::format("the key \"{}\"", key), "none");
    return *found;
}

double number(const json& value, const char* what, const Place& place)
{
    if (!value.is_number()) place.refuse(fmt::format("a number for {}", what), value.type_name());
    return value.get<double>();
}

json parse_object(const std::string& line, std::size_t keys, const Place& place)
{
    json object = json::parse(line, nullptr, false);
    if (!object.is_object())
        place.refuse("a JSON object", object.is_discarded() ? "no JSON" : object.type_name());
    if (object.size() != keys)
        place.refuse(fmt::format("{} keys", keys), fmt::format("{}", object.size()));
    return object;
}

Hand parse_hand(const json& object, const char* side, const Place& place)
{
    if (!object.is_object() || object.size() != 2)
        place.refuse(fmt::format("an object with \"tracked\" and \"joints\" for {}", side),
                     object.type_name());
    Hand hand;
    const json& tracked = member(object, "tracked", place);
    if (!tracked.is_boolean()) place.refuse("true or false for \"tracked\"", tracked.type_name());
    hand.tracked = tracked.get<bool>();
    const json& rows = member(object, "joints", place);
    if (!rows.is_array() || rows.size() != joint_count)
        place.refuse(fmt::format("{} joints for {}", int(joint_count), side),
                     fmt::format("{} of {}", rows.type_name(), rows.size()));
    for (int j = 0; j < joint_count; ++j) {
        const json& row = rows[j];
        if (!row.is_array() || row.size() != 9)
            place.refuse("9 numbers for a joint",
                         fmt::format("{} of {}", row.type_name(), row.size()));
        float v[9];
        for (int k = 0; k < 9; ++k) v[k] = float(number(row[k], "a joint", place));
        if (v[8] != 0 && v[8] != 1) place.refuse("validity 0 or 1", fmt::format("{}", v[8]));
        hand.joints[j] = {{v[3], v[4], v[5], v[6]}, {v[0], v[1], v[2]}};
        hand.radius[j] = v[7];
        hand.valid[j] = v[8] == 1;
        check_joint(hand.joints[j], hand.radius[j], hand.valid[j], place);
    }
    return hand;
}

}  // namespace

Recording from_lines(const std::string& bytes, const std::string& path)
{
    Recording r;
    std::size_t begin = text_begin(bytes, path), line_number = 0, count = 0;
    double before = -1;
    const auto place = [&] { return Place{path, fmt::format("in line {}", line_number)}; };
    while (begin < bytes.size()) {
        const std::string_view all = next_line(bytes, begin);
        ++line_number;
        if (all.size() > longest_line)
            place().refuse(fmt::format("at most {} characters", longest_line),
                           fmt::format("{}", all.size()));
        const std::string line(all);
        if (line_number == 1) {
            const json header = parse_object(line, 5, place());
            const json& format = member(header, "format", place());
            if (format != "knead.hands/1") place().refuse("\"knead.hands/1\"", format.dump());
            const json& name = member(header, "name", place());
            if (!name.is_string()) place().refuse("a string for \"name\"", name.type_name());
            r.name = name.get<std::string>();
            r.rate = number(member(header, "rate", place()), "\"rate\"", place());
            r.latency = number(member(header, "latency", place()), "\"latency\"", place());
            const json& frames = member(header, "frames", place());
            if (!frames.is_number_unsigned() || frames.get<std::uint64_t>() == 0)
                place().refuse("at least 1 frame", frames.dump());
            count = frames.get<std::uint64_t>();
            check_header(r, place());
            continue;
        }
        if (r.frames.size() == count) place().refuse("the end of the file", "another line");
        const json object = parse_object(line, 3, place());
        HandFrame frame;
        frame.time = number(member(object, "time", place()), "\"time\"", place());
        check_time(frame.time, before, place());
        before = frame.time;
        for (int s = 0; s < side_count; ++s)
            frame.hand[s] =
                parse_hand(member(object, side_names[s], place()), side_names[s], place());
        r.frames.push_back(frame);
    }
    if (r.frames.size() != count || count == 0)
        place().refuse(fmt::format("{} frames in all", count), fmt::format("{}", r.frames.size()));
    return r;
}

std::string to_lines(const Recording& r)
{
    std::string text = R"({"format":"knead.hands/1","name":)" + json(r.name).dump() + R"(,"rate":)";
    put_number(text, r.rate);
    put_number(text += R"(,"latency":)", r.latency);
    text += fmt::format(",\"frames\":{}}}\n", r.frames.size());
    for (const HandFrame& frame : r.frames) {
        put_number(text += R"({"time":)", frame.time);
        for (int s = 0; s < side_count; ++s) {
            const Hand& hand = frame.hand[s];
            text += fmt::format(R"(,"{}":{{"tracked":{},"joints":[)", side_names[s], hand.tracked);
            for (int j = 0; j < joint_count; ++j) {
                const auto& [q, p] = hand.joints[j];
                text += j == 0 ? "[" : ",[";
                for (const float x : {p.x, p.y, p.z, q.w, q.x, q.y, q.z, hand.radius[j]}) {
                    put_number(text, x);
                    text += ',';
                }
                text += hand.valid[j] ? "1]" : "0]";
            }
            text += "]}";
        }
        text += "}\n";
    }
    return text;
}

}  // namespace knead
