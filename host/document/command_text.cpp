#include "host/document/command_text.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <type_traits>
#include <utility>

#include "host/base/outputs.h"
#include "host/document/command_table.h"
#include "host/document/document_text.h"
#include "host/document/export_plan.h"
#include "host/scene/names.h"
#include "host/scene/object_json.h"

namespace knead {
namespace {

constexpr const char* log_schema = "knead.commands/1";
const Names<Side> sides = {{"left", left}, {"right", right}};

Json reference_json(const ObjectRef& object)
{
    if (const ObjectId* id = std::get_if<ObjectId>(&object.by)) return id->value;
    return std::get<std::string>(object.by);
}

// Writes the fields of a command into an object.
struct Writer {
    Json& to;

    template <class F, class T>
    void operator()(const F& f, const std::optional<T>& value) const
    {
        if (value) (*this)(f, *value);
    }
    template <class F>
    void operator()(const F& f, const SetHand& hand) const
    {
        Json part = Json::object();
        for_each_field(hand, Writer{part});
        if (!part.empty()) to[f.key] = part;
    }
    template <class F>
    void operator()(const F& f, const Vec3<double>& v) const
    {
        to[f.key] = {v.x, v.y, v.z};
    }
    template <class F>
    void operator()(const F& f, const Quat<double>& q) const
    {
        to[f.key] = {q.w, q.x, q.y, q.z};
    }
    template <class F>
    void operator()(const F& f, const ObjectRef& object) const
    {
        to[f.key] = reference_json(object);
    }
    template <class F>
    void operator()(const F& f, const std::vector<ObjectRef>& objects) const
    {
        to[f.key] = Json::array();
        for (const ObjectRef& one : objects) to[f.key].push_back(reference_json(one));
    }
    template <class F>
    void operator()(const F& f, const SplitPlane& plane) const
    {
        Json part = Json::object();
        for_each_field(plane, Writer{part});
        to[f.key] = std::move(part);
    }
    template <class F>
    void operator()(const F& f, const std::vector<ObjectId>& ids) const
    {
        if (ids.empty()) return;
        to[f.key] = Json::array();
        for (const ObjectId id : ids) to[f.key].push_back(id.value);
    }
    template <class F>
    void operator()(const F& f, const std::vector<int>& numbers) const
    {
        if (!numbers.empty()) to[f.key] = numbers;
    }
    template <class F>
    void operator()(const F& f, const MaterialSpec& m) const
    {
        to[f.key] = knead::json_of(m);
    }
    template <class F>
    void operator()(const F& f, const SceneObject& o) const
    {
        to[f.key] = knead::json_of(o);
    }
    template <class F>
    void operator()(const F& f, const std::vector<Point2>& outline) const
    {
        to[f.key] = knead::json_of(outline);
    }
    template <class F>
    void operator()(const F& f, SectionKind section) const
    {
        to[f.key] = name_of(section_kinds, section);
    }
    template <class F>
    void operator()(const F& f, ContactMode mode) const
    {
        to[f.key] = name_of(contact_modes, mode);
    }
    template <class F>
    void operator()(const F& f, CategoryContact contact) const
    {
        to[f.key] = name_of(category_contacts, contact == CategoryContact::separate);
    }
    template <class F>
    void operator()(const F& f, Side side) const
    {
        to[f.key] = name_of(sides, side);
    }
    template <class F>
    void operator()(const F& f, ExportContent what) const
    {
        to[f.key] = name_of(export_contents, what);
    }
    template <class F>
    void operator()(const F& f, LengthUnit unit) const
    {
        to[f.key] = name_of(length_units, unit);
    }
    template <class F>
    void operator()(const F& f, const std::vector<std::string>& texts) const
    {
        to[f.key] = texts;
    }
    template <class F>
    void operator()(const F& f, const std::string& text) const
    {
        to[f.key] = text;
    }
    template <class F>
    void operator()(const F& f, double number) const
    {
        to[f.key] = number;
    }
    template <class F>
    void operator()(const F& f, int number) const
    {
        to[f.key] = number;
    }
    template <class F>
    void operator()(const F& f, bool flag) const
    {
        to[f.key] = flag;
    }
};

ObjectRef object_in(ObjectReader& r, const std::string& key, const Json& value)
{
    if (value.is_string()) return value.get<std::string>();
    if (value.is_number_unsigned() && value <= 0xffffffffu && value > 0)
        return ObjectId{value.get<std::uint32_t>()};
    r.fail(key, "an object: its number from 1 or its name", described(value));
}

// Reads the fields of a command.
struct Reader {
    ObjectReader& r;
    const std::string& folder;

    template <class F, class T>
    void operator()(const F& f, std::optional<T>& value) const
    {
        if (r.has(f.key)) (*this)(f, value.emplace());
    }
    template <class F>
    void operator()(const F& f, SetHand& hand) const
    {
        r.object(f.key, [&](ObjectReader& in) { for_each_field(hand, Reader{in, folder}); });
    }
    template <class F>
    void operator()(const F& f, SplitPlane& plane) const
    {
        r.object(f.key, [&](ObjectReader& in) {
            for_each_field(plane, [&](const auto& part, Vec3<double>& v) {
                in.required(part.key, "[x, y, z]");
                v = in.vector(part.key, part.range);
            });
        });
    }
    template <class F>
    void operator()(const F& f, std::vector<ObjectId>& ids) const
    {
        if (!r.has(f.key)) return;
        for (const Json& one : list(f.key, most_objects)) {
            if (!one.is_number_unsigned() || one == 0 || one > highest_id)
                r.fail(f.key, "a list of objects' numbers from 1", described(one));
            ids.push_back({one.get<std::uint32_t>()});
        }
    }
    template <class F>
    void operator()(const F& f, std::vector<int>& numbers) const
    {
        if (!r.has(f.key)) return;
        for (const Json& one : list(f.key, most_objects)) {
            if (!one.is_number_unsigned() || one > f.range.high)
                r.fail(f.key, fmt::format("a list of whole numbers from 0 to {}", f.range.high),
                       described(one));
            numbers.push_back(one.get<int>());
        }
    }
    template <class F>
    void operator()(const F& f, Vec3<double>& v) const
    {
        v = r.vector(f.key, f.range);
    }
    template <class F>
    void operator()(const F& f, Quat<double>& q) const
    {
        q = read_rotation(r, f.key);
    }
    template <class F>
    void operator()(const F& f, ObjectRef& object) const
    {
        object = object_in(r, f.key, r.required(f.key, "an object: its number or its name"));
    }
    template <class F>
    void operator()(const F& f, std::vector<ObjectRef>& objects) const
    {
        for (const Json& one : list(f.key, most_objects))
            objects.push_back(object_in(r, f.key, one));
    }
    template <class F>
    void operator()(const F& f, MaterialSpec& m) const
    {
        r.required(f.key, "a preset's name, or an object");
        m = read_material(r, f.key);
    }
    template <class F>
    void operator()(const F& f, SceneObject& o) const
    {
        r.required(f.key, "an object of a scene");
        r.object(f.key, [&](ObjectReader& in) { o = read_scene_object(in, folder); });
    }
    template <class F>
    void operator()(const F& f, std::vector<Point2>& outline) const
    {
        outline = read_outline(r, f.key);
    }
    template <class F>
    void operator()(const F& f, SectionKind& section) const
    {
        section = r.choice(f.key, section_kinds, section);
    }
    template <class F>
    void operator()(const F& f, ContactMode& mode) const
    {
        mode = r.choice(f.key, contact_modes, mode);
    }
    template <class F>
    void operator()(const F& f, CategoryContact& contact) const
    {
        contact = CategoryContact(
            r.choice(f.key, category_contacts, contact == CategoryContact::separate));
    }
    template <class F>
    void operator()(const F& f, Side& side) const
    {
        r.required(f.key, "\"left\" or \"right\"");
        side = r.choice(f.key, sides, side);
    }
    template <class F>
    void operator()(const F& f, ExportContent& what) const
    {
        what = r.choice(f.key, export_contents, what);
    }
    template <class F>
    void operator()(const F& f, LengthUnit& unit) const
    {
        unit = r.choice(f.key, length_units, unit);
    }
    template <class F>
    void operator()(const F& f, std::vector<std::string>& texts) const
    {
        if (!r.has(f.key)) return;
        for (const Json& one : list(f.key, 1000)) {
            if (!one.is_string()) r.fail(f.key, "a list of texts", described(one));
            texts.push_back(one.get<std::string>());
        }
    }
    template <class F>
    void operator()(const F& f, std::string& text) const
    {
        r.required(f.key, "a text");
        text = r.text(f.key, "");
    }
    template <class F>
    void operator()(const F& f, double& number) const
    {
        number = r.number(f.key, f.range);
    }
    template <class F>
    void operator()(const F& f, int& number) const
    {
        r.required(f.key, "a whole number");
        number = r.whole(f.key, int(f.range.low), int(f.range.high), number);
    }
    template <class F>
    void operator()(const F& f, bool& flag) const
    {
        r.required(f.key, "true or false");
        flag = r.flag(f.key, flag);
    }

  private:
    const Json& list(const char* key, int most) const
    {
        const Json& all = r.required(key, "a list");
        if (!all.is_array() || all.size() > std::size_t(most))
            r.fail(key, fmt::format("a list of at most {}", most), described(all));
        return all;
    }
};

std::vector<std::string> command_names()
{
    std::vector<std::string> names;
    for (const CommandRow& row : command_rows) names.push_back(row.name);
    return names;
}

Command command_in(const std::string& name, const Json& body, const std::string& file,
                   const std::string& pointer, const std::string& folder)
{
    Command read;
    const bool known = visit_command_type(name, [&]<class C>(std::in_place_type_t<C>) {
        C command;
        ObjectReader::read(body, file, pointer, [&](ObjectReader& r) {
            for_each_field(command, Reader{r, folder});
        });
        read = std::move(command);
    });
    if (known) return read;
    throw InputError(fmt::format("{}: {}: there is no such command; the nearest is \"{}\"", file,
                                 pointer.substr(0, 100), nearest_name(name, command_names())));
}

// The one key of a line besides "frame".
std::string command_name_in(const Json& line, const std::string& file)
{
    if (!line.is_object())
        throw InputError(fmt::format("{}: expected an object, found {}", file, described(line)));
    std::vector<std::string> names;
    for (const auto& [key, value] : line.items())
        if (key != "frame") names.push_back(key);
    if (names.size() == 1) return names[0];
    for (std::string& one : names) one.resize(std::min<std::size_t>(one.size(), 30));
    names.resize(std::min<std::size_t>(names.size(), 5));
    throw InputError(
        fmt::format("{}: expected \"frame\" and one command, found {}", file,
                    names.empty() ? "no command" : fmt::format("{}", fmt::join(names, ", "))));
}

LoggedCommand line_in(const Json& line, const std::string& file, const std::string& folder)
{
    constexpr long most_frames = 10000000;
    const std::string name = command_name_in(line, file);
    const Json frame = line.value("frame", Json());
    if (!frame.is_number_integer() || frame < 0 || frame > most_frames)
        throw InputError(fmt::format("{}: /frame: expected a whole number from 0 to {}, found {}",
                                     file, most_frames, described(frame)));
    return {frame.get<long>(), command_in(name, line[name], file, "/" + name, folder)};
}

void read_first_line(const Json& line, const std::string& file, CommandLog& log)
{
    ObjectReader::read(line, file, "", [&](ObjectReader& r) {
        const std::string found = r.text("schema", "");
        if (found != log_schema) r.fail("schema", log_schema, "\"" + found.substr(0, 60) + "\"");
        log.scene = r.text("scene", "");
        log.recording = r.text("recording", "");
        if (const Json* list = r.find("settings")) {
            if (!list->is_array()) r.fail("settings", "a list of texts", described(*list));
            for (const Json& one : *list) {
                if (!one.is_string()) r.fail("settings", "a list of texts", described(one));
                log.settings.push_back(one.get<std::string>());
            }
        }
    });
}

}  // namespace

Json json_of(const Command& command)
{
    Json body = Json::object();
    std::visit([&](const auto& c) { for_each_field(c, Writer{body}); }, command);
    return {{row_of(command).name, std::move(body)}};
}

Command read_command(const Json& value, const std::string& file, const std::string& pointer,
                     const std::string& folder)
{
    const std::string name = command_name_in(value, file);
    return command_in(name, value[name], file, pointer + "/" + name, folder);
}

CommandLog parse_command_log(const std::string& text, const std::string& file,
                             const std::string& folder)
{
    CommandLog log;
    std::size_t number = 0;
    bool first = true;
    for (std::size_t from = 0; from < text.size();) {
        const std::size_t end = std::min(text.find('\n', from), text.size());
        const std::string one = text.substr(from, end - from);
        from = end + 1;
        const std::string place = fmt::format("{}:{}", file, ++number);
        if (one.find_first_not_of(" \t\r") == std::string::npos) continue;
        const Json line = parse_json(one, place);
        if (std::exchange(first, false) && line.is_object() && line.contains("schema")) {
            read_first_line(line, place, log);
            continue;
        }
        LoggedCommand next = line_in(line, place, folder);
        next.line = int(number);
        if (!log.commands.empty() && next.frame < log.commands.back().frame)
            throw InputError(
                fmt::format("{}: /frame: expected at least {}, that of the line "
                            "before, found {}",
                            place, log.commands.back().frame, next.frame));
        if (log.commands.size() == most_commands)
            throw InputError(fmt::format("{}: expected at most {} commands", place, most_commands));
        log.commands.push_back(std::move(next));
    }
    return log;
}

CommandLog read_command_log(const std::string& file, const std::string& folder)
{
    return parse_command_log(read_text(file, max_log_bytes), file, folder);
}

std::string line_of(const LoggedCommand& logged)
{
    // "frame" first, as people read it.
    const std::string body =
        json_of(logged.command).dump(-1, ' ', false, Json::error_handler_t::replace);
    return fmt::format("{{\"frame\":{},{}\n", logged.frame, body.substr(1));
}

std::string to_text(const CommandLog& log)
{
    std::string text;
    if (!log.scene.empty() || !log.settings.empty() || !log.recording.empty())
        text = Json{{"schema", log_schema},
                    {"scene", log.scene},
                    {"settings", log.settings},
                    {"recording", log.recording}}
                   .dump(-1, ' ', false, Json::error_handler_t::replace) +
               "\n";
    for (const LoggedCommand& one : log.commands) text += line_of(one);
    return text;
}

void write_command_log(const std::string& file, const CommandLog& log)
{
    write_whole(file, to_text(log));
}

std::string command_log_of(const std::string& recording) { return recording + ".commands"; }

}  // namespace knead
