// The numbered files of a run: what is written, and what of an earlier run goes.
#include "host/cli/sequence.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "host/base/errors.h"
#include "host/base/outputs.h"
#include "tests/folder.h"
#include "tests/reason.h"

namespace knead {
namespace {

class Numbered : public InFolder {
  protected:
    bool there(const std::string& name) const { return std::filesystem::exists(path(name)); }
};

TEST_F(Numbered, EveryFrameThatIsDividedIsWrittenByItsNumber)
{
    Sequence meshes(path("m"), "mesh", "ply", 5);
    for (int frame = 0; frame <= 12; ++frame)
        meshes.add(frame, [](const std::string& file) { write_whole(file, "x"); });
    EXPECT_EQ(meshes.count(), 3);
    for (const char* name : {"m/mesh_0000.ply", "m/mesh_0001.ply", "m/mesh_0002.ply"})
        EXPECT_TRUE(there(name)) << name;
    EXPECT_FALSE(there("m/mesh_0003.ply"));
    Sequence none(path("none"), "mesh", "ply", 0);
    none.add(0, [](const std::string&) { ADD_FAILURE() << "not asked for"; });
    EXPECT_TRUE(!none.wanted() && none.count() == 0 && !there("none"));
}

TEST_F(Numbered, AfterADiskRefusedNothingIsWritten)
{
    Sequence meshes(path("m"), "mesh", "ply", 1);
    const auto full = [](const std::string&) { throw OutputError("full"); };
    EXPECT_THROW(meshes.add(0, full), OutputError);
    meshes.add(1, [](const std::string&) { ADD_FAILURE() << "it was refused before"; });
    EXPECT_EQ(meshes.count(), 0);
    write_whole(path("file"), "x");
    Sequence below(path("file/m"), "mesh", "ply", 1);
    const std::string why = reason<OutputError>([&] { below.add(0, full); });
    EXPECT_EQ(why.find(path("file/m") + ": cannot be made: "), 0u) << why;
}

TEST_F(Numbered, OnlyFilesOfExactlySuchNamesAreRemoved)
{
    const std::string left = "mesh_0003.partial-999999999-0.ply";  // of a process that is gone
    const char* const old[] = {"mesh_0000.ply", "mesh_12345.glb", "mesh_0001.obj", "mesh_0002.stl"};
    const char* const others[] = {"mesh_001.ply",  "mesh_0001.txt",       "mesh_00a1.ply",
                                  "clay_0001.ply", "mesh_1234567890.ply", "mesh.ply"};
    for (const char* name : old) write_whole(path(name), "x");
    for (const char* name : others) write_whole(path(name), "x");
    write_whole(path(left), "x");
    const Sequence meshes(folder.string(), "mesh", "ply", 1);
    meshes.remove_partial();
    EXPECT_FALSE(there(left));
    for (const char* name : old) EXPECT_TRUE(there(name)) << name;
    meshes.remove_old();
    for (const char* name : old) EXPECT_FALSE(there(name)) << name;
    for (const char* name : others) EXPECT_TRUE(there(name)) << name;
    const Sequence nowhere(path("no"), "mesh", "ply", 1);
    nowhere.remove_old(), nowhere.remove_partial();
    EXPECT_FALSE(there("no"));
}

}  // namespace
}  // namespace knead
