// A program called ffmpeg, first on the PATH, that does what a test asks for in the place of the
// real one: `keep` writes the frames to the file as they come.
#pragma once
#include <cstdlib>
#include <filesystem>
#include <string>

#include "host/base/outputs.h"

namespace knead {

class FakeFfmpeg {
  public:
    // In the folder, which has no other use. Its words are kept there in `words`, one a line.
    explicit FakeFfmpeg(const std::string& folder, const std::string& does = keep)
    {
        std::filesystem::create_directories(folder);
        const std::string program = folder + "/ffmpeg";
        write_whole(program, "#!/bin/sh\nprintf '%s\\n' \"$@\" >'" + folder +
                                 "/words'\nfor to; do :; done\n" + does + "\n");
        std::filesystem::permissions(program, std::filesystem::perms::owner_all);
        setenv("PATH", (folder + ":" + before).c_str(), 1);
    }
    ~FakeFfmpeg() { setenv("PATH", before.c_str(), 1); }
    FakeFfmpeg(const FakeFfmpeg&) = delete;
    FakeFfmpeg& operator=(const FakeFfmpeg&) = delete;

    static constexpr const char* keep = "exec cat >\"${to#file:}\"";

  private:
    const std::string before = std::getenv("PATH") ? std::getenv("PATH") : "";
};

}  // namespace knead
