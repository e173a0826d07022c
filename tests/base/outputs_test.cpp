// The one way a file is written: whole or not at all, whatever goes wrong.
#include "host/base/outputs.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <thread>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "tests/asks.h"
#include "tests/folder.h"
#include "tests/reason.h"
#include "tests/small_disk.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

class Outputs : public InFolder {
  protected:
    std::string content(const std::string& name) const { return read_text(path(name), 1 << 24); }
};

void prepare(const std::string& folder, const std::vector<std::string>& names, bool overwrite)
{
    const FolderLock lock = prepare_folder(folder, names, overwrite);
    EXPECT_TRUE(lock.held());
}

TEST_F(Outputs, AFileIsReplacedWhole)
{
    const std::string all = std::string("\0old\n", 5), none, large(3 << 20, 'x');
    for (const std::string& bytes : {all, none, large}) {
        write_whole(path("a.bin"), bytes);
        EXPECT_EQ(content("a.bin"), bytes);
    }
    EXPECT_EQ(files(), 1);
}

TEST_F(Outputs, AFullDiskLeavesTheOldFileAndNothingElse)
{
    write_whole(path("a.json"), "old");
    for (const std::size_t size : {4097, 1 << 20}) {
        std::string said;
        {
            const SmallDisk full(4096);
            said =
                reason<OutputError>([&] { write_whole(path("a.json"), std::string(size, 'x')); });
        }
        EXPECT_EQ(said, path("a.json") + ": cannot be written: File too large");
        EXPECT_EQ(content("a.json"), "old");
        EXPECT_EQ(files(), 1);
    }
    const SmallDisk full(4096);
    write_whole(path("a.json"), std::string(4096, 'y'));
    EXPECT_EQ(content("a.json").size(), 4096u);
}

TEST_F(Outputs, ALargeFileThatIsGivenUpLeavesTheOldOneAndNothingElse)
{
    const std::string large((std::size_t(17) << 20) + 5, 'x');
    write_whole(path("a"), "old");
    Asks asks;
    const auto all = asks.until(1000);
    EXPECT_TRUE(write_whole_unless(all, path("b"), large));
    EXPECT_EQ(read_text(path("b"), large.size()), large);
    const int count = asks.count;
    EXPECT_GE(count, 5) << "not asked on the way";
    for (int n = 1; n <= count; ++n) {
        EXPECT_FALSE(write_whole_unless(asks.until(n), path("a"), large)) << n;
        EXPECT_EQ(content("a"), "old");
    }
    EXPECT_EQ(files(), 2);
}

TEST_F(Outputs, APlaceThatTakesNoFileIsNamedWithTheReason)
{
    const auto said = [&](const std::string& file) {
        return reason<OutputError>([&] { write_whole(file, "x"); });
    };
    EXPECT_EQ(said(path("no/a")), path("no/a") + ": cannot be written: No such file or directory");
    EXPECT_EQ(said(""), "\"\": cannot be written: the path is empty");
    write_whole(path("file"), "old");
    EXPECT_EQ(said(path("file/a")), path("file/a") + ": cannot be written: Not a directory");
    fs::create_directory(folder / "full");
    EXPECT_EQ(said(path("full")), path("full") + ": cannot be written: Is a directory");
    EXPECT_EQ(said("/proc/a").rfind("/proc/a: cannot be written: ", 0), 0u);
    const std::string name(300, 'n');
    EXPECT_EQ(said(path(name)), path(name) + ": cannot be written: File name too long");
    EXPECT_EQ(files(), 2);
    EXPECT_EQ(content("file"), "old");
}

TEST_F(Outputs, AFolderThatMayNotBeWrittenIsNamedWithTheReason)
{
    fs::create_directory(folder / "locked");
    write_whole(path("locked/a"), "old");
    fs::permissions(folder / "locked", fs::perms::owner_read | fs::perms::owner_exec);
    const bool anywhere = std::ofstream(path("locked/probe")).good();
    const std::string said = reason<OutputError>([&] { write_whole(path("locked/a"), "new"); });
    fs::permissions(folder / "locked", fs::perms::owner_all);
    if (anywhere) GTEST_SKIP() << "this user may write anywhere";
    EXPECT_EQ(said, path("locked/a") + ": cannot be written: Permission denied");
    EXPECT_EQ(content("locked/a"), "old");
}

TEST_F(Outputs, WhatIsNoRegularFileIsNotReplaced)
{
    ASSERT_EQ(mkfifo(path("pipe").c_str(), 0600), 0);
    EXPECT_EQ(reason<OutputError>([&] { write_whole(path("pipe"), "x"); }),
              path("pipe") + ": cannot be written: it exists and is not a regular file");
    EXPECT_TRUE(fs::is_fifo(folder / "pipe"));
    EXPECT_EQ(files(), 1);
}

TEST_F(Outputs, ALinkStaysAndWhatItNamesIsReplaced)
{
    fs::create_directory(folder / "disk");
    write_whole(path("disk/real"), "old");
    fs::create_symlink("disk/real", folder / "near");
    fs::create_symlink(path("near"), folder / "far");
    fs::create_symlink("disk/new", folder / "dangling");
    write_whole(path("far"), "new");
    write_whole(path("dangling"), "first");
    EXPECT_EQ(content("disk/real"), "new");
    EXPECT_EQ(content("disk/new"), "first");
    for (const char* link : {"near", "far", "dangling"})
        EXPECT_TRUE(fs::is_symlink(folder / link)) << link;
    EXPECT_EQ(files(), 4);
    fs::create_symlink("loop", folder / "loop");
    ASSERT_EQ(mkfifo(path("pipe").c_str(), 0600), 0);
    fs::create_symlink("pipe", folder / "to-pipe");
    const auto said = [&](const std::string& name) {
        return reason<OutputError>([&] { write_whole(path(name), "x"); });
    };
    EXPECT_EQ(said("loop"),
              path("loop") + ": cannot be written: Too many levels of symbolic links");
    EXPECT_EQ(said("to-pipe"),
              path("to-pipe") + ": cannot be written: it exists and is not a regular file");
    EXPECT_TRUE(fs::is_fifo(folder / "pipe"));
}

TEST_F(Outputs, AnotherProgramMayWriteWhatIsThenPutInPlace)
{
    write_whole(path("clip.mp4"), "old");
    {
        const PartialFile dropped(path("clip.mp4"));
        EXPECT_EQ(fs::path(dropped.path()).extension(), ".mp4");
        EXPECT_EQ(fs::path(dropped.path()).parent_path(), folder);
        std::ofstream(dropped.path()) << "half";
        EXPECT_EQ(content("clip.mp4"), "old");
    }
    EXPECT_EQ(files(), 1);
    PartialFile partial(path("clip.mp4"));
    std::ofstream(partial.path()) << "new";
    partial.put_in_place();
    EXPECT_EQ(content("clip.mp4"), "new");
    EXPECT_EQ(files(), 1);
}

// A process of the same number that was killed may have left anything.
TEST_F(Outputs, AnEarlierHalfIsNeitherUsedNorFollowed)
{
    std::string taken;
    {
        const PartialFile next(path("a"));
        taken = next.path();
    }
    const std::size_t dash = taken.rfind('-');
    const int number = std::stoi(taken.substr(dash + 1));
    write_whole(path("precious"), "precious");
    fs::create_symlink(path("precious"), taken.substr(0, dash + 1) + std::to_string(number + 1));
    fs::create_symlink("/dev/full", taken.substr(0, dash + 1) + std::to_string(number + 2));
    write_whole(path("a"), "new");
    write_whole(path("a"), "newer");
    EXPECT_EQ(content("a"), "newer");
    EXPECT_EQ(content("precious"), "precious");
}

TEST_F(Outputs, ManyWritersOfOneFileLeaveOneOfTheirs)
{
    std::vector<std::thread> writers;
    for (int k = 0; k < 8; ++k)
        writers.emplace_back([&, k] {
            for (int i = 0; i < 20; ++i) write_whole(path("a"), std::string(20000, char('a' + k)));
        });
    for (std::thread& w : writers) w.join();
    const std::string left = content("a");
    EXPECT_EQ(left, std::string(20000, left[0]));
    EXPECT_EQ(files(), 1);
}

TEST_F(Outputs, PlacesAreCheckedBeforeTheWorkAndLeftAsTheyWere)
{
    prepare(path("out/deep"), {"report.json"}, false);
    EXPECT_TRUE(fs::is_empty(folder / "out/deep"));
    write_whole(path("out/deep/report.json"), "old");
    EXPECT_NE(reason<OutputError>([&] { prepare(path("out/deep"), {"report.json"}, false); }), "");
    prepare(path("out/deep"), {"report.json"}, true);
    EXPECT_NE(reason<OutputError>([&] { prepare_file(path("out/deep/report.json"), false); }), "");
    prepare_file(path("out/deep/report.json"), true);
    EXPECT_EQ(content("out/deep/report.json"), "old");
    EXPECT_NE(reason<OutputError>([&] { prepare_file(path("out/deep"), true); }), "");
    EXPECT_NE(reason<OutputError>([&] { prepare_file(path("no/a"), true); }), "");
    EXPECT_NE(reason<OutputError>([&] { prepare(path("out/deep/report.json"), {}, true); }), "");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder / "out/deep"), {}), 1);
}

TEST_F(Outputs, WhatIsToBeReplacedMustBeOfItsKind)
{
    fs::create_directory(folder / "report.json");
    write_whole(path("pictures"), "a file");
    const auto why = [&](const std::string& name) {
        return reason<OutputError>([&] { prepare(folder.string(), {name}, true); });
    };
    EXPECT_NE(why("report.json").find("report.json: is a folder"), std::string::npos);
    EXPECT_NE(why("pictures/").find("pictures: is no folder"), std::string::npos);
    prepare(folder.string(), {"pictures", "report.json/", "absent", "none/"}, true);
}

TEST_F(Outputs, OnlyWhatTheDeadLeftUnfinishedIsCleared)
{
    const std::string us = std::to_string(getpid());
    const std::vector<std::string> stay = {"mesh.partial-" + us + "-0.glb",  // somebody is at work
                                           "mesh.glb",
                                           "mine.partial-999999999-0.txt",
                                           "mesh.partial-x-0.glb",
                                           "mesh.partial-9.glb",
                                           "mesh.partial-999999999-0x.glb",
                                           "mesh.partial-99999999999999999999-0.glb"};
    const std::vector<std::string> go = {"mesh.partial-999999999-0.glb",
                                         ".knead-probe.partial-999999999-12"};
    for (const auto* names : {&stay, &go})
        for (const std::string& name : *names) write_whole(path(name), "half");
    fs::create_directory(folder / "mesh.partial-999999999-1.glb");
    remove_partials(folder.string(), [](const std::string& name) {
        return name == "mesh.glb" || name == ".knead-probe";
    });
    for (const std::string& name : stay) EXPECT_TRUE(fs::exists(path(name))) << name;
    for (const std::string& name : go) EXPECT_FALSE(fs::exists(path(name))) << name;
    EXPECT_TRUE(fs::exists(folder / "mesh.partial-999999999-1.glb"));
}

TEST_F(Outputs, WhatTheDeadLeftIsNamedWithWhatItWasToBe)
{
    for (const char* name : {"z.partial-999999999-0.hands", "a.partial-999999999-3.glb",
                             "x.hands.partial", "x.partial-1-0.hands", "x.hands"})
        write_whole(path(name), "half");
    const std::vector<Leftover> left = leftovers(folder.string());
    ASSERT_EQ(left.size(), 2u);
    EXPECT_EQ(left[0].path, path("a.partial-999999999-3.glb"));
    EXPECT_EQ(left[0].of, "a.glb");
    EXPECT_EQ(left[1].path, path("z.partial-999999999-0.hands"));
    EXPECT_EQ(left[1].of, "z.hands");
    EXPECT_TRUE(leftovers(path("absent")).empty());
    EXPECT_EQ(files(), 5);
}

TEST_F(Outputs, AFolderThatTakesNoFilesIsNamedItself)
{
    const std::string said = reason<OutputError>([] { prepare("/proc", {}, false); });
    EXPECT_EQ(said.rfind("/proc: cannot be written: ", 0), 0u) << said;
}

// A name may be as long as the file system allows, of one-byte characters or of others.
TEST_F(Outputs, WhateverMayBeANameCanBeWritten)
{
    std::string umlauts, hanzi;
    while (umlauts.size() < 250) umlauts += "\u00e4";
    while (hanzi.size() < 249) hanzi += "\u6ce5";
    for (const std::string& name :
         {std::string(255, 'n'), std::string(250, 'n') + ".json", umlauts + ".json",
          hanzi + ".jsonl", "." + std::string(254, 'n'), "n." + std::string(253, 'e'),
          std::string(127, 'n') + "." + std::string(127, 'e')}) {
        ASSERT_EQ(name.size(), 255u);
        prepare_file(path(name), false);
        write_whole(path(name), "old");
        write_whole(path(name), "new");
        EXPECT_EQ(content(name), "new");
        const PartialFile half(path(name));
        const std::string beside = fs::path(half.path()).filename();
        EXPECT_LE(beside.size(), 255u);
        EXPECT_NE(beside.find(".partial-" + std::to_string(getpid()) + "-"), std::string::npos);
        if (name.size() - name.rfind('.') < 8) {
            EXPECT_EQ(fs::path(beside).extension(), fs::path(name).extension());
        }
        const std::size_t kept = beside.find(".partial-");
        EXPECT_TRUE(name.starts_with(beside.substr(0, kept)));
        EXPECT_NE(name[kept] & 0xc0, 0x80) << "half a character";
    }
    EXPECT_EQ(files(), 7);
}

TEST_F(Outputs, FilesAreRemovedWhereTheyAre)
{
    write_whole(path("a"), "1"), write_whole(path("b"), "2");
    remove_files(folder.string(), {"a", "absent"});
    EXPECT_EQ(files(), 1);
    fs::create_directories(folder / "full/of");
    EXPECT_NE(reason<OutputError>([&] { remove_files(folder.string(), {"full"}); }), "");
}

}  // namespace
}  // namespace knead
