// The list of files that were opened or saved lately.
#include "host/ui/recent_files.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "host/session/session_file.h"
#include "tests/folder.h"

namespace knead {
namespace {

namespace fs = std::filesystem;
using Files = std::vector<std::string>;

class RecentFiles : public InFolder {
  protected:
    RecentFiles()
    {
        const char* given = ::getenv("XDG_STATE_HOME");
        if (given) before = given;
        ::setenv("XDG_STATE_HOME", path("state").c_str(), 1);
    }
    ~RecentFiles() override
    {
        if (before.empty())
            ::unsetenv("XDG_STATE_HOME");
        else
            ::setenv("XDG_STATE_HOME", before.c_str(), 1);
    }
    std::string make(const std::string& name)
    {
        std::ofstream(path(name)) << name;
        return path(name);
    }
    static std::string list() { return (fs::path(log_folder()) / "recent.json").string(); }

  private:
    std::string before;
};

TEST_F(RecentFiles, NewestFirstEachOnceAndAtMostTwelve)
{
    EXPECT_TRUE(recent_files().empty());
    const std::string a = make("a \xc3\xa4\n.json"), b = make("b.knead");
    add_recent_file(a), add_recent_file(b);
    EXPECT_EQ(recent_files(), (Files{b, a}));
    add_recent_file(path("state/../a \xc3\xa4\n.json"));
    EXPECT_EQ(recent_files(), (Files{a, b}));
    fs::create_symlink(b, path("link"));
    add_recent_file(path("link"));
    EXPECT_EQ(recent_files(), (Files{path("link"), a})) << "the same file by another name";
    Files made;
    for (int i = 0; i < 15; ++i) {
        made.insert(made.begin(), make(std::to_string(i) + ".json"));
        add_recent_file(made.front());
    }
    made.resize(12);
    EXPECT_EQ(recent_files(), made);
}

TEST_F(RecentFiles, MissingFilesAreLeftOutWhileTheyAreMissing)
{
    const std::string a = make("a.json"), b = make("b.json");
    add_recent_file(a), add_recent_file(b);
    fs::rename(b, path("c.json"));
    EXPECT_EQ(recent_files(), (Files{a}));
    fs::rename(path("c.json"), b);
    EXPECT_EQ(recent_files(), (Files{b, a}));
}

TEST_F(RecentFiles, RelativePathsBecomeAbsolute)
{
    add_recent_file("scenes/squeeze.json");
    EXPECT_EQ(recent_files(), (Files{(fs::current_path() / "scenes/squeeze.json").string()}));
}

TEST_F(RecentFiles, StandardInputLogsAndNamesOutsideUtf8AreNotListed)
{
    add_recent_file("-"), add_recent_file(""), add_recent_file("-.json");
    const std::string log = (fs::path(log_folder()) / ("x" + std::string(log_ending))).string();
    std::ofstream(log) << "x";
    add_recent_file(log);
    add_recent_file(make("\xff.json"));
    EXPECT_TRUE(recent_files().empty());
}

TEST_F(RecentFiles, ADamagedListIsEmptyAndIsReplaced)
{
    const std::string a = make("a.json");
    const std::string good = R"({"schema": "knead.recent/1", "files": [")" + a + "\"]}";
    for (const std::string& bad :
         {std::string(), std::string("{"), std::string("[]"), std::string("\xff\xfe"),
          std::string(R"({"schema": "knead.recent/2", "files": ["/"]})"),
          std::string(R"({"schema": "knead.recent/1"})"),
          std::string(R"({"schema": "knead.recent/1", "files": [1, null, "relative", {}]})"),
          good.substr(0, good.size() / 2), std::string(2 << 20, ' ')}) {
        std::ofstream(list(), std::ios::trunc) << bad;
        EXPECT_TRUE(recent_files().empty()) << bad.substr(0, 80);
        add_recent_file(a);
        EXPECT_EQ(recent_files(), (Files{a})) << bad.substr(0, 80);
    }
    std::ofstream(list(), std::ios::trunc) << good;
    EXPECT_EQ(recent_files(), (Files{a}));
}

TEST_F(RecentFiles, AListThatCannotBeWrittenIsNoError)
{
    const std::string a = make("a.json");
    fs::create_directory(list());
    add_recent_file(a);
    EXPECT_TRUE(recent_files().empty());
    ::setenv("XDG_STATE_HOME", a.c_str(), 1);  // a file
    add_recent_file(a);
    EXPECT_TRUE(recent_files().empty());
}

TEST_F(RecentFiles, WritersAtOnceLeaveAWholeList)
{
    Files made;
    for (int i = 0; i < 12; ++i) made.push_back(make(std::to_string(i) + ".json"));
    std::vector<std::thread> writers;
    for (int k = 0; k < 3; ++k)
        writers.emplace_back([&, k] {
            for (int i = k; i < 12; i += 3) add_recent_file(made[std::size_t(i)]);
        });
    for (std::thread& one : writers) one.join();
    const Files listed = recent_files();
    EXPECT_GE(listed.size(), 1u);
    for (const std::string& one : listed)
        EXPECT_NE(std::find(made.begin(), made.end(), one), made.end());
}

}  // namespace
}  // namespace knead
