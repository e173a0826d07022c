// What a file chooser shows of a folder.
#include "host/ui/file_list.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <ctime>
#include <filesystem>
#include <fstream>

#include "tests/folder.h"

namespace knead {
namespace {

namespace fs = std::filesystem;

class FileLists : public InFolder {
  protected:
    void make(const std::string& name, const std::string& bytes = "")
    {
        std::ofstream(path(name), std::ios::binary) << bytes;
    }
    static std::vector<std::string> names(const FileList& list)
    {
        std::vector<std::string> found;
        for (const FileEntry& e : list.entries) found.push_back(e.name + (e.is_folder ? "/" : ""));
        return found;
    }
};
using Names = std::vector<std::string>;

TEST_F(FileLists, FoldersComeFirstThenNamesWithoutRegardToCase)
{
    for (const char* name : {"b.json", "A.json", "a.json", "c.KNEAD", "Zebra.ply", ".hidden.json"})
        make(name, "12345");
    fs::create_directory(path("zoo"));
    fs::create_directory(path("Box.json"));
    fs::create_directory(path(".git"));
    const FileList all = list_files(folder.string());
    EXPECT_EQ(names(all),
              (Names{"Box.json/", "zoo/", "A.json", "a.json", "b.json", "c.KNEAD", "Zebra.ply"}));
    EXPECT_EQ(all.error + all.note, "");
    EXPECT_EQ(all.entries[2].size, 5u);
    EXPECT_EQ(all.entries[0].size, 0u);
    EXPECT_NEAR(all.entries[2].modified, double(std::time(nullptr)), 120);
    EXPECT_EQ(names(list_files(folder.string(), {".knead", ".ply"})),
              (Names{"Box.json/", "zoo/", "c.KNEAD", "Zebra.ply"}));
}

TEST_F(FileLists, ParentsLeadFromTheRootToTheFolder)
{
    const std::string odd = path("a b/\xc3\xa4\n\xe2\x88\x82");
    fs::create_directories(odd);
    const FileList list = list_files(odd + "/../" + fs::path(odd).filename().string() + "/");
    EXPECT_EQ(list.folder, odd);
    ASSERT_GE(list.parents.size(), 3u);
    EXPECT_EQ(list.parents.front().path, "/");
    EXPECT_EQ(list.parents.back().path, odd);
    EXPECT_EQ(list.parents.back().name, "\xc3\xa4\n\xe2\x88\x82");
    EXPECT_EQ(list.parents[list.parents.size() - 2].path, path("a b"));
    const FileList root = list_files("/");
    EXPECT_EQ(root.folder, "/");
    EXPECT_EQ(root.parents.size(), 1u);
    EXPECT_EQ(root.error, "");
    EXPECT_EQ(list_files("").folder, fs::current_path().string());
}

TEST_F(FileLists, OddNamesAreListedAsTheyAre)
{
    const Names odd{" space .json", "\xd0\x9f\xd0\xbe.json", "line\nbreak.json", "\xff\xfe.json",
                    "quote\".json"};
    for (const std::string& name : odd) make(name);
    const FileList list = list_files(folder.string(), {".json"});
    EXPECT_EQ(list.entries.size(), odd.size());
    for (const FileEntry& e : list.entries)
        EXPECT_NE(std::find(odd.begin(), odd.end(), e.name), odd.end()) << e.name;
}

TEST_F(FileLists, LinksAreFollowedAndWhatIsNoFileIsLeftOut)
{
    fs::create_directory(path("real"));
    make("file.json", "1");
    fs::create_directory_symlink(path("real"), path("link"));
    fs::create_symlink(path("file.json"), path("other.json"));
    fs::create_symlink(path("nothing"), path("broken.json"));
    ASSERT_EQ(::mkfifo(path("pipe.json").c_str(), 0600), 0);
    EXPECT_EQ(names(list_files(folder.string())),
              (Names{"link/", "real/", "file.json", "other.json"}));
}

TEST_F(FileLists, AreBoundedAndSaySo)
{
    for (int i = 0; i < 30; ++i) make(std::to_string(i) + ".json");
    EXPECT_EQ(list_files(folder.string(), {}, 30).note, "");
    const FileList list = list_files(folder.string(), {}, 20);
    EXPECT_EQ(list.entries.size(), 20u);
    EXPECT_NE(list.note.find("20"), std::string::npos);
    EXPECT_EQ(list.error, "");
}

TEST_F(FileLists, SayWhyAFolderCannotBeRead)
{
    const FileList gone = list_files(path("gone"));
    EXPECT_NE(gone.error.find("gone: No such file"), std::string::npos) << gone.error;
    EXPECT_EQ(gone.parents.back().path, path("gone"));
    make("file.json");
    EXPECT_NE(list_files(path("file.json")).error, "");
    if (::geteuid() == 0) return;  // root may read everything
    fs::create_directory(path("closed"));
    fs::permissions(path("closed"), fs::perms::none);
    EXPECT_NE(list_files(path("closed")).error.find("Permission denied"), std::string::npos);
    fs::permissions(path("closed"), fs::perms::owner_all);
}

}  // namespace
}  // namespace knead
