// What the rest stands on when something is wrong: exit codes, signals, strict JSON, the machine.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <new>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/interrupt.h"
#include "host/base/json_reader.h"
#include "host/base/machine.h"
#include "host/base/outputs.h"
#include "tests/folder.h"
#include "tests/reason.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

template <class Error>
void expect_code(const Error& error, int code, const std::string& said)
{
    testing::internal::CaptureStderr();
    const int found = run_and_report([&]() -> int { throw error; });
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "knead: " + said + "\n");
    EXPECT_EQ(found, code) << said;
}

// Loops under test catch signals, as the program does. Whoever ends the tests is heard all the
// same.
class EndsOnSignals : public testing::EmptyTestEventListener {
    void OnTestEnd(const testing::TestInfo&) override
    {
        const int by = interrupted();
        if (by == 0) return;
        std::signal(by, SIG_DFL);
        std::raise(by);
    }
};
[[maybe_unused]] const bool heard = [] {
    testing::UnitTest::GetInstance()->listeners().Append(new EndsOnSignals);
    return true;
}();

TEST(Errors, EveryKindHasItsExitCodeAndIsSaid)
{
    EXPECT_EQ(run_and_report([] { return 42; }), 42);
    expect_code(UsageError("a"), exit_usage, "a");
    expect_code(InputError("b"), exit_input, "b");
    expect_code(MemoryError("c"), exit_resource, "c");
    expect_code(ResourceError("d"), exit_resource, "d");
    expect_code(OutputError("e"), exit_output, "e");
    expect_code(DeviceLost("f"), exit_device, "f");
    expect_code(std::bad_alloc(), exit_resource, "out of memory");
    expect_code(std::logic_error("g"), exit_check, "internal error: g");
}

// In processes of their own: what is noted here would end the loops of other tests.
TEST(InterruptDeathTest, TheSameSignalTwiceAtOnceCountsOnce)
{
    const auto raised = [](int number) {
        watch_interrupts();
        if (interrupted() != 0) std::exit(99);
        std::raise(number);
        std::raise(number);
        std::exit(interrupted());
    };
    EXPECT_EXIT(raised(SIGINT), testing::ExitedWithCode(SIGINT), "");
    EXPECT_EXIT(raised(SIGTERM), testing::ExitedWithCode(SIGTERM), "");
}

TEST(InterruptDeathTest, ATerminalThatClosesIsHeardUnlessNobodyIsToHear)
{
    const auto raised = [](auto before) {
        std::signal(SIGHUP, before);
        watch_interrupts();
        std::raise(SIGHUP);
        std::exit(interrupted());
    };
    EXPECT_EXIT(raised(SIG_DFL), testing::ExitedWithCode(SIGHUP), "");
    EXPECT_EXIT(raised(SIG_IGN), testing::ExitedWithCode(0), "");  // as under nohup
}

TEST(InterruptDeathTest, AnotherOneLaterEndsTheProgram)
{
    const auto raised = [] {
        watch_interrupts();
        std::raise(SIGINT);
        usleep(600000);
        std::raise(SIGTERM);
        std::exit(0);
    };
    EXPECT_EXIT(raised(), testing::KilledBySignal(SIGTERM), "");
}

using InterruptFilesDeathTest = InFolder;

TEST_F(InterruptFilesDeathTest, AFileUnderMakingIsGivenUpByASignalThatEndsTheProgram)
{
    write_whole(path("a"), "old");
    const std::string large(std::size_t(64) << 20, 'x');
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
        const auto raised = [&] {
            std::signal(number, SIG_DFL);  // it may have been ignored from the start
            int asks = 0;
            const auto stop = [&] {
                if (++asks == 2) std::raise(number);
                if (asks == 4) std::exit(99);
                return false;
            };
            write_whole_unless(stop, path("a"), large);
            std::exit(0);
        };
        EXPECT_EXIT(raised(), testing::KilledBySignal(number), "");
        EXPECT_EQ(read_text(path("a"), 100), "old");
        EXPECT_EQ(files(), 1);
    }
}

class JsonReader : public InFolder {
  protected:
    std::string refused(const std::string& text, const ObjectReader::Body& body = {}) const
    {
        return reason<InputError>([&] {
            const Json json = parse_json(text, "x.json");
            if (body) ObjectReader::read(json, "x.json", "", body);
        });
    }
};

TEST_F(JsonReader, FilesThatCannotBeReadAreNamed)
{
    const auto said = [&](const std::string& file, std::size_t max) {
        return reason<InputError>([&] { read_text(file, max); });
    };
    EXPECT_EQ(said(path("none"), 9), path("none") + ": no such file");
    EXPECT_EQ(said(folder.string(), 9),
              folder.string() + ": expected a regular file, found a directory");
    EXPECT_EQ(said("/dev/null", 9), "/dev/null: expected a regular file, found something else");
    write_whole(path("ten"), "0123456789");
    EXPECT_EQ(said(path("ten"), 9), path("ten") + ": expected at most 9 bytes, found 10");
    EXPECT_EQ(said(path("ten"), 10), "");
}

TEST_F(JsonReader, TextsThatAreNoJsonAreNamedWithTheirPlace)
{
    EXPECT_EQ(refused("{\n \"a\": ]").rfind("x.json: line 2, column ", 0), 0u)
        << refused("{\n \"a\": ]");
    EXPECT_EQ(refused(R"({"a": {"b": 1}, "c": {"b": 1, "b": 2}})"),
              "x.json: key \"b\" is given twice in one object");
    EXPECT_EQ(refused(std::string(70, '[') + std::string(70, ']')),
              "x.json: expected at most 64 levels of nesting");
    EXPECT_EQ(refused(R"({"a": 1, /* said */ "b": 2} // end)"), "");
}

TEST_F(JsonReader, NumbersBeyondADoubleAreNamedWithTheirPlace)
{
    const std::string expected = ": expected a number within 1.8e308, found ";
    EXPECT_EQ(refused("1e999"), "x.json: line 1, column 1 (byte 0)" + expected + "1e999");
    EXPECT_EQ(refused("{\"a\": \"1e999\", // 1e999\n \"b\": [3, -1e999 ]}"),
              "x.json: line 2, column 11 (byte 34)" + expected + "-1e999");
    EXPECT_EQ(refused("[1E+400,2]"), "x.json: line 1, column 2 (byte 1)" + expected + "1E+400");
    EXPECT_EQ(refused("[1e-999, 1e308]"), "");
}

// The superuser may read everything; nobody may not.
class Nobody {
  public:
    Nobody()
    {
        if (superuser && seteuid(65534) != 0) ADD_FAILURE() << "not nobody";
    }
    Nobody(const Nobody&) = delete;
    ~Nobody()
    {
        if (superuser && seteuid(0) != 0) ADD_FAILURE() << "not the superuser again";
    }

  private:
    const bool superuser = geteuid() == 0;
};

TEST_F(JsonReader, FilesThatMayNotBeReadAreNamedWithTheReason)
{
    write_whole(path("secret.json"), "{}");
    fs::create_directory(folder / "locked");
    write_whole(path("locked/a.json"), "{}");
    fs::permissions(folder, fs::perms(0755));
    fs::permissions(folder / "secret.json", fs::perms::none);
    fs::permissions(folder / "locked", fs::perms::none);
    std::string said[2];
    {
        const Nobody nobody;
        said[0] = reason<InputError>([&] { read_json(path("secret.json")); });
        said[1] = reason<InputError>([&] { read_json(path("locked/a.json")); });
    }
    fs::permissions(folder / "locked", fs::perms::owner_all);
    EXPECT_EQ(said[0], path("secret.json") + ": cannot be read: Permission denied");
    EXPECT_EQ(said[1], path("locked/a.json") + ": cannot be read: Permission denied");
}

TEST_F(JsonReader, ValuesOfAnotherTypeAreNamedWithWhatWasExpected)
{
    const Bounds share{0, 1}, length{0, INFINITY, "m", true}, any{-INFINITY, INFINITY, "Pa"},
        low{-INFINITY, 3, "s"};
    EXPECT_EQ(described(share), "a number at least 0 and at most 1");
    EXPECT_EQ(described(length), "a number above 0 m");
    EXPECT_EQ(described(any), "a finite number in Pa");
    EXPECT_EQ(described(Bounds{-INFINITY, INFINITY}), "a finite number");
    EXPECT_EQ(described(low), "a number at most 3 s");
    EXPECT_EQ(described(Json(std::string(99, 'x'))), "the text \"" + std::string(56, 'x') + "...");
    const auto said = [&](const char* value, const ObjectReader::Body& body) {
        return refused(std::string(R"({"a/b~": )") + value + "}", body);
    };
    const std::string key = "a/b~", at = "x.json: /a~1b~0: expected ";
    const auto text = [&](ObjectReader& r) { r.text(key, ""); };
    const auto flag = [&](ObjectReader& r) { r.flag(key, false); };
    const auto whole = [&](ObjectReader& r) { r.whole(key, 1, 5, 2); };
    const auto vector = [&](ObjectReader& r) { r.vector(key, share, {}); };
    const auto choice = [&](ObjectReader& r) {
        r.choice<int>(key, {{"clay", 1}, {"dough", 2}}, 0);
    };
    EXPECT_EQ(said("3", text), at + "a text, found 3");
    EXPECT_EQ(said("\"yes\"", flag), at + "true or false, found the text \"yes\"");
    EXPECT_EQ(said("{}", whole), at + "a whole number from 1 to 5, found an object");
    EXPECT_EQ(said("2.5", whole), at + "a whole number from 1 to 5, found 2.5");
    EXPECT_EQ(said("6", whole), at + "a whole number from 1 to 5, found 6");
    EXPECT_EQ(said("[1, 1]", vector),
              at + "three numbers, each number at least 0 and at most 1, found an array of 2");
    EXPECT_EQ(said("[1, 1, 2]", vector),
              "x.json: /a~1b~0/2: expected a number at least 0 and at most 1, found 2");
    EXPECT_EQ(said("1", choice), at + "one of \"clay\", \"dough\", found 1");
    EXPECT_EQ(said("\"caly\"", choice), at + "one of \"clay\", \"dough\", found the text \"caly\"; "
                                             "the nearest is \"clay\"");
    EXPECT_EQ(said("0", [&](ObjectReader& r) { r.number(key, length); }),
              at + "a number above 0 m, found 0");
    EXPECT_EQ(said("0", [&](ObjectReader& r) { r.number("a/b", share); }),
              "x.json: /a~1b: expected a number at least 0 and at most 1, found nothing, but there "
              "is \"a/b~\"");
    EXPECT_EQ(said("0", [](ObjectReader& r) { r.has("far"); }),
              "x.json: /a~1b~0: unknown key \"a/b~\"; the nearest is \"far\"");
    EXPECT_EQ(refused("[]", text), "x.json: /: expected an object, found an array of 0");
}

TEST(Machine, TellsWhatItIs)
{
    EXPECT_FALSE(host_name().empty());
    EXPECT_FALSE(cpu_name().empty());
    EXPECT_GT(cpu_count(), 0);
    EXPECT_GT(total_memory(), std::size_t(1) << 20);
    EXPECT_GT(process_seconds(), 0);
    const std::string now = utc_now();
    EXPECT_EQ(now.size(), 20u);
    EXPECT_EQ(now.back(), 'Z');
    EXPECT_TRUE(machine_facts(true).contains("gpu"));
    EXPECT_FALSE(machine_facts(true)["gpu"]["driver"].get<std::string>().empty());
}

}  // namespace
}  // namespace knead
