#include "host/document/command_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "host/document/command_table.h"
#include "host/document/export_plan.h"
#include "host/scene/names.h"

namespace knead {
namespace {

// A line of a log per command, in the order of the variant's alternatives.
constexpr std::array examples{
    R"({"frame":0,"add_object":{"object":{"name":"cap","centre":[0.5,0.65,0.5],"diameter":0.15}}})",
    R"({"frame":90,"remove_objects":{"objects":["cap"]}})",
    R"({"frame":30,"place_object":{"object":"cap","centre":[0.5,0.7,0.5],"rotation":[0,1,0,0]}})",
    R"({"frame":30,"set_material":{"object":"ball","material":{"preset":"clay","yield":2e4}}})",
    R"({"frame":30,"set_category":{"object":"cap","category":1}})",
    R"({"frame":0,"rename":{"object":1,"name":"head"}})",
    R"({"frame":60,"set_flags":{"object":"cap","locked":true}})",
    R"({"frame":60,"set_colour":{"objects":["cap"],"colour":[0.9,0.4,0.1]}})",
    R"({"frame":60,"copy_objects":{"objects":["cap"],"by":[0.2,0,0],"names":["second cap"]}})",
    R"({"frame":60,"move_objects":{"objects":["cap"],"by":[0,0.1,0],"turn":[0,1,0,0]}})",
    R"({"frame":60,"reset_objects":{"objects":["ball"]}})",
    R"({"frame":60,"scale_objects":{"objects":["cap"],"factor":1.5}})",
    R"({"frame":60,"merge_objects":{"objects":["ball","cap"],"name":"acorn"}})",
    R"({"frame":60,"split_object":{"object":"ball","plane":)"
    R"({"point":[0.5,0.3,0.5],"normal":[0,1,0]}}})",
    R"({"frame":60,"source_begin":{"name":"rope","section":"star","diameter":0.05,)"
    R"("at":[0.2,0.1,0.5]}})",
    R"({"frame":90,"source_move":{"name":"rope","at":[0.4,0.1,0.5]}})",
    R"({"frame":91,"source_end":{"name":"rope"}})",
    R"({"frame":60,"set_gravity":{"gravity":[0,-1.62,0]}})",
    R"({"frame":60,"set_walls":{"contact_mode":"separate","friction":0.6}})",
    R"({"frame":60,"set_contact":{"categories":"separate","friction":0.5}})",
    R"({"frame":60,"set_hands":{"right":{"held":"rod"},"zoom":2.5}})",
    R"({"frame":0,"set_surface":{"nodes":96}})",
    R"({"frame":0,"set_lattice":{"cells":32}})",
    R"({"frame":60,"carry":{"objects":["cap"],"side":"right","begins":true}})",
    R"({"frame":0,"open":{"file":"pot.json","settings":["domain.cells=32"]}})",
    R"({"frame":90,"save":{"file":"pot.knead"}})",
    R"({"frame":90,"export":{"file":"pot.stl","objects":["pot"]}})",
    R"({"frame":90,"undo":{}})",
    R"({"frame":91,"redo":{}})",
    R"({"frame":95,"go_to":{"step":0}})",
    R"({"frame":90,"reset":{}})",
    R"({"frame":30,"pause":{"on":true}})",
    R"({"frame":30,"advance":{"frames":10}})",
    R"({"frame":30,"play":{"recorded":true}})",
    R"({"frame":60,"mark":{"text":"the hands have let go"}})"};
static_assert(examples.size() == std::variant_size_v<Command>, "a command without an example");

std::string type_of(bool) { return "true or false"; }
std::string type_of(int) { return "whole number"; }
std::string type_of(double) { return "number"; }
std::string type_of(const std::string&) { return "text"; }
std::string type_of(const std::vector<std::string>&) { return "list of texts, optional"; }
std::string type_of(const Vec3<double>&) { return "[x, y, z]"; }
std::string type_of(const Quat<double>&) { return "[w, x, y, z] of length 1"; }
std::string type_of(const ObjectRef&) { return "number or name"; }
std::string type_of(const std::vector<ObjectRef>&) { return "list of numbers or names"; }
std::string type_of(const std::vector<ObjectId>&) { return "list of numbers, optional"; }
std::string type_of(const std::vector<int>&) { return "list of whole numbers, optional"; }
std::string type_of(const MaterialSpec&) { return "text or {...}"; }
std::string type_of(const SceneObject&) { return "{...}"; }
std::string type_of(Side) { return "left or right"; }
template <class T>
std::string listed(const Names<T>& all)
{
    std::string names;
    for (const auto& [name, value] : all) names += (names.empty() ? "" : ", ") + name;
    return names;
}
std::string type_of(const std::vector<Point2>&) { return "[[x, y], ...]"; }
std::string type_of(SectionKind) { return listed(section_kinds); }
std::string type_of(ContactMode) { return listed(contact_modes); }
std::string type_of(CategoryContact) { return listed(category_contacts); }
std::string type_of(ExportContent) { return listed(export_contents); }
std::string type_of(LengthUnit) { return listed(length_units); }

// "": not of a number, or a range that the type says already.
template <class T>
std::string range_of(const T&, const Bounds& range)
{
    constexpr bool each = std::is_same_v<T, Vec3<double>>;
    if constexpr (!each && !std::is_same_v<T, double> && !std::is_same_v<T, int>) return "";
    if (!(range.low < range.high)) return "";
    return fmt::format(", {}{}{}{}{}", each ? "each " : "",
                       range.above ? "above " + short_number(range.low) + ", at most "
                                   : short_number(range.low) + " to ",
                       short_number(range.high), *range.unit ? " " : "", range.unit);
}

struct FieldText {
    std::string key, value, help;
};

struct Describe {
    std::vector<FieldText>& all;
    std::string before;  // of a part: the key of its field and "."

    template <class F, class T>
    void operator()(const F& f, const std::optional<T>&) const
    {
        (*this)(f, T{});
        all.back().value += ", optional";
    }
    template <class F>
    void operator()(const F& f, const SetHand& hand) const
    {
        all.push_back({before + f.key, "{...}, optional", f.help});
        for_each_field(hand, Describe{all, before + f.key + "."});
    }
    template <class F>
    void operator()(const F& f, const std::optional<SplitPlane>&) const
    {
        all.push_back({before + f.key, "{...}, optional", f.help});
        const SplitPlane part;
        for_each_field(part, Describe{all, before + f.key + "."});
    }
    template <class F, class T>
    void operator()(const F& f, const T& value) const
    {
        all.push_back({before + f.key, type_of(value) + range_of(value, f.range), f.help});
    }
};

struct CommandEntry {
    const CommandRow* row;
    std::vector<FieldText> fields;
    std::string example;
    std::string why_not_in_run;  // "": it is available there
};

template <std::size_t... I>
std::vector<CommandEntry> entries(std::index_sequence<I...>)
{
    const auto entry = []<std::size_t index>() {
        CommandEntry of{&command_rows[index], {}, examples[index], ""};
        const std::variant_alternative_t<index, Command> command{};
        for_each_field(command, Describe{of.fields, ""});
        Situation in_run;
        in_run.live = false;
        of.why_not_in_run = of.row->why_not(in_run);
        return of;
    };
    return {entry.template operator()<I>()...};
}
std::vector<CommandEntry> entries_of(Receiver receiver)
{
    std::vector<CommandEntry> all = entries(std::make_index_sequence<examples.size()>{});
    std::erase_if(all, [&](const CommandEntry& one) { return one.row->receiver != receiver; });
    return all;
}

// `text`, broken at spaces into lines of at most `width` columns of ASCII; lines after the first
// begin with `indent`.
std::string filled(const std::string& text, std::size_t width, const std::string& indent)
{
    std::string all, line;
    for (std::size_t from = 0; from < text.size();) {
        const std::size_t end = std::min(text.find(' ', from + 1), text.size());
        const std::string word = text.substr(from, end - from);
        if (line.size() + word.size() > width) {
            all += line + "\n";
            line = indent + word.substr(1);
        } else {
            line += word;
        }
        from = end;
    }
    return all + line + "\n";
}

std::string refusal_of(const CommandEntry& one)
{
    return one.why_not_in_run.empty() ? "" : " Refused in a run: " + one.why_not_in_run + ".";
}

}  // namespace

std::string commands_help()
{
    std::string text =
        "A log has a command a line, {\"frame\": N, \"NAME\": {...}}, which is applied between\n"
        "the frames N and N + 1; of frame 0, before the first. `knead run --commands LOG`\n"
        "applies it. Objects are given by number or name.\n";
    for (const auto& [receiver, heading] : {std::pair{Receiver::document, "Of the document"},
                                            std::pair{Receiver::session, "Of the session"}}) {
        text += fmt::format("\n{}:\n", heading);
        for (const CommandEntry& one : entries_of(receiver)) {
            text += fmt::format("\n{}\n", one.row->name);
            text += filled("  " + std::string(one.row->help) + refusal_of(one), 80, "  ");
            for (const FieldText& f : one.fields)
                text += filled(fmt::format("    {} ({}): {}", f.key, f.value, f.help), 80,
                               std::string(8, ' '));
            text += "  " + one.example + "\n";
        }
    }
    return text;
}

std::string commands_page()
{
    std::string text;
    for (const auto& [receiver, heading] :
         {std::pair{Receiver::document, "Commands of the document"},
          std::pair{Receiver::session, "Commands of the session"}}) {
        text += fmt::format("{}## {}\n", text.empty() ? "" : "\n", heading);
        for (const CommandEntry& one : entries_of(receiver)) {
            text += fmt::format("\n### {}\n\n", one.row->name);
            // The example precedes the list: after it, it would be a paragraph of its last item.
            text += filled(one.row->help + refusal_of(one), 100, "");
            text += "\n    " + one.example + "\n" + (one.fields.empty() ? "" : "\n");
            for (const FieldText& f : one.fields)
                text += filled(fmt::format("- `{}` ({}): {}", f.key, f.value, f.help), 100, "  ");
        }
    }
    return text;
}

}  // namespace knead
