#include "host/base/outputs.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include "host/base/errors.h"

namespace knead {
namespace fs = std::filesystem;
namespace {

struct Close {
    void operator()(std::FILE* f) const { std::fclose(f); }
};

std::string partial_name(const std::string& file)
{
    return file + ".partial-" + std::to_string(getpid());
}

[[noreturn]] void fail(const std::string& path, const std::string& what)
{
    throw OutputError(path + ": " + what);
}

void refuse_existing(const fs::path& path)
{
    std::error_code problem;
    if (fs::exists(fs::symlink_status(path, problem)))
        fail(path.string(), "is there already; --overwrite replaces it");
}

}  // namespace

void write_whole(const std::string& file, const std::string& bytes)
{
    const std::string partial = partial_name(file);
    bool good = false;
    int reason = 0;
    {
        std::unique_ptr<std::FILE, Close> out(std::fopen(partial.c_str(), "wb"));
        if (!out) fail(file, std::string("cannot be written: ") + std::strerror(errno));
        good = std::fwrite(bytes.data(), 1, bytes.size(), out.get()) == bytes.size() &&
               std::fflush(out.get()) == 0 && fsync(fileno(out.get())) == 0;
        reason = errno;
    }
    if (good && std::rename(partial.c_str(), file.c_str()) == 0) return;
    if (good) reason = errno;
    std::remove(partial.c_str());
    fail(file, std::string("cannot be written: ") + std::strerror(reason));
}

void prepare_folder(const std::string& folder, const std::vector<std::string>& names,
                    bool overwrite)
{
    std::error_code problem;
    fs::create_directories(folder, problem);
    if (problem) fail(folder, "cannot be made: " + problem.message());
    if (!fs::is_directory(folder)) fail(folder, "is not a folder");
    const std::string probe = (fs::path(folder) / ".knead-probe").string();
    write_whole(probe, "");
    std::remove(probe.c_str());
    if (overwrite) return;
    for (const std::string& name : names) refuse_existing(fs::path(folder) / name);
}

void prepare_file(const std::string& file, bool overwrite)
{
    const fs::path path(file);
    if (!path.has_filename()) fail(file, "is not the name of a file");
    std::error_code problem;
    if (fs::is_directory(path, problem)) fail(file, "is a folder");
    if (!overwrite) refuse_existing(path);
    const std::string probe = partial_name(file);
    write_whole(probe, "");
    std::remove(probe.c_str());
}

}  // namespace knead
