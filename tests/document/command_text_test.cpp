// Commands and logs of them as text: what is written reads again to the bit, and what is wrong is
// refused with its place.
#include "host/document/command_text.h"

#include <gtest/gtest.h>

#include <bit>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/document/random.h"
#include "tests/folder.h"
#include "tests/reason.h"
#include "tests/sanitized.h"

namespace knead {
namespace {

// Whether two commands are equal, member by member, to the bit.
struct Same {
    template <class T>
    static bool of(const T& a, const T& b)
    {
        return a == b;
    }
    static bool of(double a, double b)
    {
        return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
    }
    static bool of(const Vec3<double>& a, const Vec3<double>& b) { return equal(a, b); }
    static bool of(const Quat<double>& a, const Quat<double>& b)
    {
        return of(a.w, b.w) && of(a.x, b.x) && of(a.y, b.y) && of(a.z, b.z);
    }
    static bool of(const MaterialSpec& a, const MaterialSpec& b) { return equal(a, b); }
    static bool of(const SceneObject& a, const SceneObject& b) { return equal(a, b); }
    static bool of(const ObjectRef& a, const ObjectRef& b) { return a.by == b.by; }
    static bool of(const SetHand& a, const SetHand& b) { return members(a, b); }
    static bool of(const SplitPlane& a, const SplitPlane& b) { return members(a, b); }
    template <class T>
    static bool of(const std::optional<T>& a, const std::optional<T>& b)
    {
        return a.has_value() == b.has_value() && (!a || of(*a, *b));
    }
    template <class T>
    static bool of(const std::vector<T>& a, const std::vector<T>& b)
    {
        return std::ranges::equal(a, b, [](const T& x, const T& y) { return of(x, y); });
    }
    template <class C>
    static bool members(const C& a, const C& b)
    {
        bool all = true;
        for_each_field(
            a, [&](const auto& f, const auto& value) { all = all && of(value, b.*(f.member)); });
        return all;
    }
};
bool same(const Command& a, const Command& b)
{
    return a.index() == b.index() &&
           std::visit([&]<class C>(const C& one) { return Same::members(one, std::get<C>(b)); }, a);
}

DocumentPtr some_objects()
{
    Random r(4);
    IdSource ids;
    DocumentPtr d = empty_room();
    for (int i = 0; i < 8; ++i) {
        const Drawing by{0, d.get(), 0, true};
        SceneObject o = random_object(r, by);
        o.id = {};
        d = after(d, AddObject{o}, ids);
    }
    return d;
}

// Commands with all numbers in their ranges, as far as the ends of these and down to denormals.
std::vector<Command> drawn(long count, std::uint64_t seed)
{
    const DocumentPtr d = some_objects();
    Random r(seed);
    const Drawing by{0, d.get(), 5, true, true};
    std::vector<Command> all;
    while (long(all.size()) < count) {
        all.push_back(random_command(r, by, all.size() % command_rows.size()));
        // References to no object are not written.
        std::visit(
            [](auto& c) {
                for_each_field(c, [](const auto&, auto& value) {
                    const auto real = [](ObjectRef& ref) {
                        if (ref.by == ObjectRef(ObjectId{0}).by) ref = ObjectId{1};
                    };
                    using T = std::remove_cvref_t<decltype(value)>;
                    if constexpr (std::is_same_v<T, ObjectRef>) real(value);
                    if constexpr (std::is_same_v<T, std::vector<ObjectRef>>)
                        for (ObjectRef& one : value) real(one);
                    if constexpr (std::is_same_v<T, std::optional<std::vector<ObjectRef>>>)
                        for (std::size_t i = 0; value && i < value->size(); ++i) real((*value)[i]);
                });
            },
            all.back());
    }
    return all;
}

TEST(CommandText, EveryCommandReadsAsItWasWrittenToTheBit)
{
    const long count = repeats(sanitized ? 4000 : 40000, 4000000);
    for (const Command& wrote : drawn(count, 58)) {
        const Json json = json_of(wrote);
        const std::string text = json.dump();
        const Command read = read_command(parse_json(text, "x"), "x", "", ".");
        ASSERT_TRUE(same(wrote, read)) << text << "\n" << json_of(read).dump();
        ASSERT_EQ(json_of(read).dump(), text);
    }
}

TEST(CommandText, NumbersAtTheEndsOfADoubleKeepTheirBits)
{
    using D = std::numeric_limits<double>;
    for (const double x : {D::denorm_min(), -D::denorm_min(), D::min(), 2.2250738585072011e-308,
                           0.0, -0.0, 0.1, 1.0 / 3, 1000.0, std::nextafter(1000.0, 0.0), 5e-324,
                           9007199254740993.0 / 9007199254740992, 1e-5, 123456.789e-300}) {
        const SetGravity wrote{{x, -x, 0}};
        const std::string text = json_of(Command(wrote)).dump();
        const Command read = read_command(parse_json(text, "x"), "x", "", "");
        EXPECT_TRUE(same(wrote, read)) << text;
    }
    EXPECT_EQ(json_of(Command(SetGravity{{0.1, -0.0, 1e-7}})).dump(),
              R"({"set_gravity":{"gravity":[0.1,-0.0,1e-07]}})")
        << "the shortest text";
    const std::string last = "100000000000000005e-17";  // whole numbers and long ones are read, too
    const Command read = read_command(
        parse_json(R"({"set_gravity":{"gravity":[-9, )" + last + R"(, 1e0]}})", "x"), "x", "", "");
    EXPECT_TRUE(same(read, SetGravity{{-9, 1.00000000000000005, 1}}));
}

TEST(CommandText, ALogReadsAsItWasWritten)
{
    CommandLog wrote{"scenes/ball.json", {"domain.cells=16", "a=\"ä\"\n"}, "0123abcd", {}};
    const long count = repeats(sanitized ? 2000 : 100000, 1000000);
    long frame = 0;
    Random r(6);
    for (const Command& command : drawn(count, 59)) {
        if (r.one_in(3)) frame += r.below(50);
        wrote.commands.push_back({frame, command, 0});
    }
    const std::string text = to_text(wrote);
    const CommandLog read = parse_command_log(text, "x.jsonl", ".");
    EXPECT_EQ(read.scene, wrote.scene);
    EXPECT_EQ(read.settings, wrote.settings);
    EXPECT_EQ(read.recording, wrote.recording);
    ASSERT_EQ(read.commands.size(), wrote.commands.size());
    for (std::size_t i = 0; i < read.commands.size(); ++i) {
        ASSERT_EQ(read.commands[i].frame, wrote.commands[i].frame);
        ASSERT_EQ(read.commands[i].line, int(i) + 2);
        ASSERT_TRUE(same(read.commands[i].command, wrote.commands[i].command)) << i;
    }
    EXPECT_EQ(to_text(read), text);
}

TEST(CommandText, LinesAreOneCommandEach)
{
    EXPECT_EQ(line_of({120, SetGravity{{0, -9.81, 0}}, 0}),
              "{\"frame\":120,\"set_gravity\":{\"gravity\":[0.0,-9.81,0.0]}}\n");
    EXPECT_EQ(line_of({0, Reset{}, 0}), "{\"frame\":0,\"reset\":{}}\n");
    EXPECT_EQ(line_of({7, Mark{"a\nb"}, 0}), "{\"frame\":7,\"mark\":{\"text\":\"a\\nb\"}}\n");
    EXPECT_EQ(to_text({}), "") << "it says nothing";
    // Blank lines, ends of lines of other systems, a last line without an end, a comment behind.
    const CommandLog log = parse_command_log(
        "\n  \t\n{\"frame\": 1, \"pause\": {\"on\": true}}\r\n\n"
        "{\"mark\": {\"text\": \"x\"}, \"frame\": 1} // why\n{\"frame\": 2, \"reset\": {}}",
        "x", "");
    ASSERT_EQ(log.commands.size(), 3u);
    EXPECT_EQ(log.commands[0].line, 3);
    EXPECT_EQ(log.commands[1].line, 5);
    EXPECT_EQ(log.commands[2].line, 6);
    EXPECT_EQ(log.commands[2].frame, 2);
    EXPECT_TRUE(log.scene.empty());
    // The first line may say less.
    EXPECT_EQ(
        parse_command_log("{\"schema\": \"knead.commands/1\", \"scene\": \"a.json\"}", "x", "")
            .scene,
        "a.json");
}

TEST(CommandText, FilesOfALineLieInTheFolder)
{
    const std::string line =
        R"({"frame": 0, "add_object": {"object": {"shape": "splats", "file": "FILE", )"
        R"("size": 0.2, "centre": [0, 0, 0]}}})";
    const auto file = [&](const std::string& name) {
        std::string text = line;
        text.replace(text.find("FILE"), 4, name);
        return std::get<AddObject>(
                   parse_command_log(text, "logs/x.jsonl", "out").commands[0].command)
            .object.source.splats.file;
    };
    const std::string there = (std::filesystem::current_path() / "out/pot.ply").string();
    EXPECT_EQ(file("pot.ply"), there);
    EXPECT_EQ(file(there), there) << "read again, from any folder";
    EXPECT_EQ(file("/clay/pot.ply"), "/clay/pot.ply");
}

class LogFile : public InFolder {};

TEST_F(LogFile, IsWrittenAndRead)
{
    const CommandLog wrote{"a.json", {}, "", {{3, Pause{true}, 0}}};
    const std::string file = command_log_of(path("one.hands"));
    EXPECT_EQ(file, path("one.hands.commands"));
    write_command_log(file, wrote);
    EXPECT_EQ(to_text(read_command_log(file, "")), to_text(wrote));
    EXPECT_EQ(reason<InputError>([&] { read_command_log(path("none"), ""); }).find(path("none")),
              0u);
    std::ofstream(path("bad")) << "{\"frame\": 0, \"pause\": {\"on\": true}}\n{\"frame\": 0}\n";
    EXPECT_EQ(reason<InputError>([&] { read_command_log(path("bad"), ""); }),
              path("bad") + ":2: expected \"frame\" and one command, found no command");
}

std::string refusal(const std::string& line)
{
    return reason<InputError>([&] {
        parse_command_log("{\"frame\": 5, \"mark\": {\"text\": \"before\"}}\n" + line + "\n",
                          "a.jsonl", "");
    });
}

TEST(CommandText, WhatIsWrongIsSaidWithFileLineAndField)
{
    const std::pair<std::string, std::string> all[] = {
        {R"({"frame": 6, "set_gravity")",
         "a.jsonl:2: line 1, column 27 (byte 26): cannot be read as JSON"},
        {R"(7)", "a.jsonl:2: expected an object, found 7"},
        {R"([])", "a.jsonl:2: expected an object, found "},
        {R"({"frame": 6})", "a.jsonl:2: expected \"frame\" and one command, found no command"},
        {R"({"frame": 6, "reset": {}, "pause": {"on": true}})",
         "a.jsonl:2: expected \"frame\" and one command, found pause, reset"},
        {R"({"frame": 6, "set_gravty": {}})",
         "a.jsonl:2: /set_gravty: there is no such command; the nearest is \"set_gravity\""},
        {R"({"frame": 6, "set_gravity": {"gravity": [0, 0, 0], "colour": 3}})",
         "a.jsonl:2: /set_gravity/colour: unknown key \"colour\""},
        {R"({"frame": 6, "set_gravity": {}})",
         "a.jsonl:2: /set_gravity/gravity: expected three numbers, each "},
        {R"({"frame": 6, "set_gravity": {"gravty": [0, 0, 0]}})",
         "a.jsonl:2: /set_gravity/gravity: expected three numbers, each number at least -1000 and "
         "at "
         "most 1000 m/s^2, found nothing, but there is \"gravty\""},
        {R"({"frame": 6, "set_gravity": {"gravity": [0, 0, 1001]}})",
         "a.jsonl:2: /set_gravity/gravity/2: expected a number at least -1000 and at most 1000 "
         "m/s^2, found"},
        {R"({"frame": 6, "set_gravity": {"gravity": [0, 0, 1e999]}})",
         "a.jsonl:2: line 1, column 48 (byte 47): expected a number within 1.8e308, found 1e999"},
        {R"({"frame": 6, "set_gravity": {"gravity": [0, 0, NaN]}})", "a.jsonl:2: line 1"},
        {R"({"frame": 6, "set_gravity": {"gravity": 9.81}})", "a.jsonl:2: /set_gravity/gravity: "},
        {R"({"frame": 6, "set_gravity": []})", "a.jsonl:2: /set_gravity: expected an object"},
        {R"({"frame": 6, "pause": {"on": 1}})",
         "a.jsonl:2: /pause/on: expected true or false, found 1"},
        {R"({"frame": 6, "pause": {}})",
         "a.jsonl:2: /pause/on: expected true or false, found nothing"},
        {R"({"frame": 6, "advance": {"frames": 1.5}})",
         "a.jsonl:2: /advance/frames: expected a whole number"},
        {R"({"frame": 6, "advance": {"frames": 0}})",
         "a.jsonl:2: /advance/frames: expected a whole number"},
        {R"({"frame": 6, "rename": {"object": 0, "name": "a"}})",
         "a.jsonl:2: /rename/object: expected an object: its number from 1 or its name, found "
         "0"},
        {R"({"frame": 6, "rename": {"object": 1.5, "name": "a"}})", "a.jsonl:2: /rename/object: "},
        {R"({"frame": 6, "rename": {"object": 4294967296, "name": "a"}})",
         "a.jsonl:2: /rename/object: "},
        {R"({"frame": 6, "rename": {"object": -1, "name": "a"}})", "a.jsonl:2: /rename/object: "},
        {R"({"frame": 6, "rename": {"object": 1, "name": 2}})",
         "a.jsonl:2: /rename/name: expected a text"},
        {R"({"frame": 6, "remove_objects": {"objects": 1}})",
         "a.jsonl:2: /remove_objects/objects: expected a list"},
        {R"({"frame": 6, "remove_objects": {"objects": [true]}})",
         "a.jsonl:2: /remove_objects/objects: expected an object"},
        {R"({"frame": 6, "carry": {"objects": [1], "side": "up", "begins": true}})",
         "a.jsonl:2: /carry/side: expected one of "},
        {R"({"frame": 6, "set_walls": {"contact_mode": "slippy"}})",
         "a.jsonl:2: /set_walls/contact_mode: expected one of \"sticky\", \"slip\", \"separate\", "
         "found"},
        {R"({"frame": 6, "set_material": {"object": 1, "material": "clya"}})",
         "a.jsonl:2: /set_material/material: "},
        {R"({"frame": 6, "set_material": {"object": 1, "material": {"young": 0}}})",
         "a.jsonl:2: /set_material/material/young: expected"},
        {R"({"frame": 6, "set_material": {"object": 1}})",
         "a.jsonl:2: /set_material/material: expected"},
        {R"({"frame": 6, "place_object": {"object": 1, "rotation": [1, 1, 0, 0]}})",
         "a.jsonl:2: /place_object/rotation: expected a quaternion [w, x, y, z] of length 1"},
        {R"({"frame": 6, "set_hands": {"left": {"hold": "rod"}}})",
         "a.jsonl:2: /set_hands/left/hold: unknown key"},
        {R"({"frame": 6, "add_object": {}})", "a.jsonl:2: /add_object/object: expected"},
        {R"({"frame": 6, "add_object": {"object": {"shape": "pyramid"}}})",
         "a.jsonl:2: /add_object/object/shape: expected one of"},
        {R"({"frame": 6, "add_object": {"object": {"centre": [0, 0, 0], "diameter": 1, "id": 0}}})",
         "a.jsonl:2: /add_object/object/id: expected a whole number from 1"},
        {R"({"frame": 4, "reset": {}})",
         "a.jsonl:2: /frame: expected at least 5, that of the line before, found 4"},
        {R"({"frame": -1, "reset": {}})",
         "a.jsonl:2: /frame: expected a whole number from 0 to 10000000, found -1"},
        {R"({"frame": 1.5, "reset": {}})", "a.jsonl:2: /frame: expected a whole number"},
        {R"({"frame": 6.0, "reset": {}})", "a.jsonl:2: /frame: expected a whole number"},
        {R"({"frame": 18446744073709551615, "reset": {}})",
         "a.jsonl:2: /frame: expected a whole number"},
        {R"({"frame": 10000001, "reset": {}})", "a.jsonl:2: /frame: expected a whole number"},
        {R"({"frame": "6", "reset": {}})", "a.jsonl:2: /frame: expected a whole number"},
        {R"({"reset": {}})",
         "a.jsonl:2: /frame: expected a whole number from 0 to 10000000, found "},
        {R"({"frame": 6, "frame": 7, "reset": {}})", "a.jsonl:2: key \"frame\" is given twice"},
        {R"({"schema": "knead.commands/1", "scene": ""})",
         "a.jsonl:2: expected \"frame\" and one command"}};
    for (const auto& [line, words] : all)
        EXPECT_EQ(refusal(line).find(words), 0u) << line << "\n" << refusal(line);
}

TEST(CommandText, TheFirstLineIsCheckedToo)
{
    const auto first = [](const std::string& line) {
        return reason<InputError>([&] { parse_command_log(line + "\n", "a.jsonl", ""); });
    };
    EXPECT_EQ(first(R"({"schema": "knead.commands/2"})")
                  .find("a.jsonl:1: /schema: expected knead.commands/1"),
              0u);
    EXPECT_EQ(first(R"({"schema": 1})").find("a.jsonl:1: /schema: "), 0u);
    EXPECT_EQ(first(R"({"schema": "knead.commands/1", "sceen": "x"})").find("a.jsonl:1: /sceen: "),
              0u);
    for (const char* settings : {"\"a=1\"", "{\"a\": \"1\"}", "[1]", "null", "7"})
        EXPECT_EQ(
            first(std::string(R"({"schema": "knead.commands/1", "settings": )") + settings + "}")
                .find("a.jsonl:1: /settings: expected a list of texts"),
            0u)
            << settings;
    EXPECT_NE(first("{\"schema\": \"knead.commands/1\"}\n{\"schema\": \"knead.commands/1\"}"), "");
}

// By the table: without each field that is not optional, with each of another type, out of range.
TEST(CommandText, EveryFieldOfEveryCommandIsChecked)
{
    const DocumentPtr d = some_objects();
    Random r(8);
    const Drawing by{0, d.get()};
    int without = 0, others = 0, outside = 0;
    for (std::size_t i = 0; i < command_rows.size(); ++i) {
        const std::string name = command_rows[i].name;
        const Command command = random_command(r, by, i);
        const Json good = json_of(command);
        const auto refused = [&](const Json& body, const std::string& key) {
            const std::string text = Json{{name, body}}.dump();
            const std::string why =
                reason<InputError>([&] { read_command(parse_json(text, "x"), "x", "", ""); });
            EXPECT_EQ(why.find("x: /" + name + "/" + key), 0u) << text << ": " << why;
        };
        std::visit(
            [&](const auto& c) {
                for_each_field(c, [&](const auto& f, const auto& value) {
                    using T = std::remove_cvref_t<decltype(value)>;
                    Json body = good[name];
                    constexpr bool may_lack = requires { value.has_value(); }
                    || std::is_same_v<T, SetHand> || std::is_same_v<T, std::vector<std::string>> ||
                        std::is_same_v<T, std::vector<ObjectId>> ||
                        std::is_same_v<T, std::vector<int>>;
                    body.erase(f.key);
                    if (!may_lack) refused(body, f.key), ++without;
                    body[f.key] = {{"never", 1}};
                    refused(body, f.key), ++others;
                    body[f.key] = nullptr;
                    refused(body, f.key), ++others;
                    if (!(f.range.low < f.range.high) ||
                        std::is_same_v<T, std::optional<Quat<double>>>)
                        return;
                    for (const double beyond : {f.range.low - 1, f.range.high + 1}) {
                        body[f.key] = beyond;
                        if constexpr (
                            requires(T t) { t.x; } || requires(T t) { t->x; })
                            body[f.key] = {0, beyond, 0};
                        refused(body, f.key), ++outside;
                    }
                });
            },
            command);
    }
    EXPECT_GT(without, 15);
    EXPECT_GT(others, 60);
    EXPECT_GT(outside, 15);
}

TEST(CommandText, HostileLogsAreRefusedInShort)
{
    const std::string deep(100000, '['), long_name(1 << 20, 'n');
    const std::string all[] = {
        deep,
        "{\"frame\": 6, \"set_gravity\": {\"gravity\": " + deep,
        std::string(200000, '{'),
        "{\"frame\": 6, \"" + long_name + "\": {}}",
        "{\"frame\": 6, \"" + long_name + "\": {}, \"b" + long_name + "\": {}}",
        "{\"frame\": 6, \"rename\": {\"object\": 1, \"name\": [\"" + long_name + "\"]}}",
        "{\"frame\": 6, \"set_material\": {\"object\": 1, \"material\": \"" + long_name + "\"}}",
        "{\"frame\": " + std::string(100000, '9') + ", \"reset\": {}}",
        std::string("{\"frame\": 6, \"mark\": {\"text\": \"\xff\xfe\"}}"),
        "{\"frame\": 6, \"remove_objects\": {\"objects\": [" +
            std::string(600, '1').replace(1, 599,
                                          [] {
                                              std::string more;
                                              for (int i = 0; i < 300; ++i) more += ",1";
                                              return more;
                                          }()) +
            "]}}"};
    for (const std::string& line : all) {
        const std::string why = refusal(line);
        EXPECT_EQ(why.find("a.jsonl:2: "), 0u) << line.substr(0, 60) << ": " << why.substr(0, 200);
        EXPECT_LT(why.size(), 1000u) << line.substr(0, 60);
    }
    // A long name is read, and refused by the document.
    const CommandLog log =
        parse_command_log("{\"frame\": 0, \"rename\": {\"object\": \"" + long_name +
                              "\", \"name\": \"" + long_name + "\"}}",
                          "x", "");
    IdSource ids;
    const auto result = reduce(some_objects(), log.commands.at(0).command, ids);
    ASSERT_TRUE(std::holds_alternative<Refusal>(result));
    EXPECT_LT(std::get<Refusal>(result).text().size(), 300u);
    // More commands than a log may have.
    if (sanitized) return;
    std::string many;
    for (std::size_t i = 0; i <= most_commands; ++i) many += "{\"frame\":0,\"reset\":{}}\n";
    EXPECT_EQ(reason<InputError>([&] { parse_command_log(many, "a.jsonl", ""); }),
              "a.jsonl:1000001: expected at most 1000000 commands");
}

}  // namespace
}  // namespace knead
