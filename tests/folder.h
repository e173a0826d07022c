// A folder of a test's own, empty at first, gone with all that is in it at the end; tests that run
// at the same time have others.
#pragma once
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cerrno>
#include <filesystem>
#include <iterator>
#include <string>
#include <system_error>

namespace knead {

class Folder {
  public:
    Folder()
    {
        std::string name = (std::filesystem::temp_directory_path() / "knead-test-XXXXXX").string();
        if (!mkdtemp(name.data())) throw std::system_error(errno, std::generic_category(), name);
        itself = name;
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    ~Folder()
    {
        std::error_code nobody_asks;
        std::filesystem::remove_all(itself, nobody_asks);
    }
    std::string operator/(const std::string& name) const { return (itself / name).string(); }
    const std::filesystem::path& path() const { return itself; }
    std::ptrdiff_t files() const
    {
        using Each = std::filesystem::directory_iterator;
        return std::distance(Each(itself), Each());
    }

  private:
    std::filesystem::path itself;
};

// A test with one.
class InFolder : public testing::Test {
  protected:
    std::string path(const std::string& name) const { return own / name; }
    std::ptrdiff_t files() const { return own.files(); }

  private:
    const Folder own;

  protected:
    const std::filesystem::path& folder = own.path();
};

}  // namespace knead
