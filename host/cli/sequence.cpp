#include "host/cli/sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "host/base/errors.h"
#include "host/base/outputs.h"
#include "host/base/paths.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

// "mesh_0001.ply" for the stem "mesh".
bool is_numbered(const std::string& name, const std::string& stem)
{
    const std::string form = ending(name), before = stem + "_";
    const std::vector<std::string> forms{".glb", ".ply", ".obj", ".stl"};
    if (!name.starts_with(before) || std::find(forms.begin(), forms.end(), form) == forms.end())
        return false;
    const std::string digits =
        name.substr(before.size(), name.size() - before.size() - form.size());
    return digits.size() >= 4 && digits.size() <= 9 &&
           std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

Sequence::Sequence(std::string folder_, std::string stem_, std::string ending_, int every_)
    : folder(std::move(folder_)), stem(std::move(stem_)), ending(std::move(ending_)), every(every_)
{
}

void Sequence::remove_partial() const
{
    std::error_code problem;
    if (!fs::is_directory(folder, problem)) return;
    remove_partials(folder, [&](const std::string& name) { return is_numbered(name, stem); });
}

void Sequence::remove_old() const
{
    const auto ours = [&](const std::string& name) { return is_numbered(name, stem); };
    std::error_code problem;
    if (!fs::is_directory(folder, problem)) return;
    remove_partials(folder, ours);
    std::vector<std::string> old;
    for (fs::directory_iterator at(folder, problem), end; !problem && at != end;
         at.increment(problem))
        if (ours(at->path().filename().string())) old.push_back(at->path().filename().string());
    remove_files(folder, old);
}

void Sequence::add(int frame, const std::function<void(const std::string& file)>& write)
{
    if (!wanted() || refused || frame % every != 0) return;
    refused = true;  // until the file is written
    std::error_code problem;
    fs::create_directories(folder, problem);
    if (problem) throw OutputError(folder + ": cannot be made: " + problem.message());
    write((fs::path(folder) / fmt::format("{}_{:04}.{}", stem, frame / every, ending)).string());
    refused = false;
    ++written;
}

}  // namespace knead
