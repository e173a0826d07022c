// Endings in any case, and the files that come with the program from any folder.
#include "host/base/paths.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "host/base/outputs.h"
#include "tests/folder.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

// Works in a folder that has nothing of ours.
class Elsewhere : public InFolder {
  protected:
    void SetUp() override { fs::current_path(folder); }
    void TearDown() override { fs::current_path(before); }

  private:
    const fs::path before = fs::current_path();
};

TEST(Paths, AnEndingIsInLowerCase)
{
    EXPECT_EQ(ending("a.b/Ball.GLB"), ".glb");
    EXPECT_EQ(ending("ball.Hands"), ".hands");
    EXPECT_EQ(ending("a.glb/ball"), "");
    EXPECT_EQ(ending(""), "");
}

TEST(Paths, WhatLiesBelowIsNamedFromHere)
{
    EXPECT_EQ(shipped("profiling/targets.json"), "profiling/targets.json");
}

TEST_F(Elsewhere, WhatComesWithTheProgramIsFound)
{
    EXPECT_TRUE(fs::is_regular_file(shipped("profiling/targets.json")));
    EXPECT_EQ(shipped("profiling/no such file"), "");
    for (const char* name : {"squeeze", "squeeze.json", "scenes/squeeze.json"}) {
        const fs::path found = file_or_shipped(name);
        EXPECT_TRUE(fs::is_regular_file(found)) << found;
        EXPECT_EQ(found.filename(), "squeeze.json");
    }
    EXPECT_TRUE(fs::is_regular_file(file_or_shipped("squeeze.hands")));
}

TEST_F(Elsewhere, TheScenesThatComeWithTheProgramAreNamedInTheirOrder)
{
    const std::vector<std::string> names = shipped_scenes();
    EXPECT_TRUE(std::is_sorted(names.begin(), names.end()));
    for (const char* name : {"ground", "pot", "squeeze"})
        EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << name;
    for (const std::string& name : names)
        EXPECT_TRUE(fs::is_regular_file(file_or_shipped(name))) << name;
}

TEST_F(Elsewhere, AFileOfTheUsersComesFirstAndNoOtherFolderIsSearched)
{
    write_whole("squeeze.json", "mine");
    EXPECT_EQ(file_or_shipped("squeeze.json"), "squeeze.json");
    for (const char* name : {"", "absent.json", "../squeeze.json", "/squeeze.json", "squeeze.txt"})
        EXPECT_EQ(file_or_shipped(name), name);
}

}  // namespace
}  // namespace knead
