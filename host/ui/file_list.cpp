#include "host/ui/file_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <filesystem>

#include "host/base/paths.h"

namespace knead {
namespace {

namespace fs = std::filesystem;

// ASCII letters only: other languages' rules differ.
std::string folded(const std::string& name)
{
    std::string lower = name;
    for (char& c : lower) c = char(std::tolower((unsigned char)c));
    return lower;
}

double since_1970(fs::file_time_type time)
{
    return std::chrono::duration<double>(std::chrono::file_clock::to_sys(time).time_since_epoch())
        .count();
}

std::vector<FileList::Parent> parents_of(const fs::path& folder)
{
    std::vector<FileList::Parent> parents;
    fs::path at;
    for (const fs::path& part : folder) {
        at /= part;
        parents.push_back({part.string(), at.string()});
    }
    return parents;
}

}  // namespace

FileList list_files(const std::string& folder, const std::vector<std::string>& endings,
                    std::size_t most)
{
    FileList list;
    std::error_code problem;
    fs::path whole = fs::absolute(folder.empty() ? "." : folder, problem).lexically_normal();
    if (problem) whole = folder;
    if (whole.filename().empty() && whole.has_relative_path()) whole = whole.parent_path();
    list.folder = whole.string();
    list.parents = parents_of(whole);

    fs::directory_iterator at(whole, problem);
    for (const fs::directory_iterator end; !problem && at != end; at.increment(problem)) {
        FileEntry entry{at->path().filename().string()};
        if (entry.name.starts_with('.')) continue;
        std::error_code gone;  // of this entry alone: removed meanwhile, or a link to nothing
        entry.is_folder = at->is_directory(gone);
        if (!entry.is_folder) {
            if (!endings.empty() &&
                std::find(endings.begin(), endings.end(), ending(entry.name)) == endings.end())
                continue;
            if (!at->is_regular_file(gone)) continue;
        }
        if (list.entries.size() == most) {
            list.note =
                fmt::format("The folder has more than {} entries; not all are listed.", most);
            break;
        }
        const std::uintmax_t size = entry.is_folder ? 0 : at->file_size(gone);
        if (!gone) entry.size = size;
        const fs::file_time_type time = at->last_write_time(gone);
        if (!gone) entry.modified = since_1970(time);
        list.entries.push_back(std::move(entry));
    }
    if (problem) list.error = list.folder + ": " + problem.message();

    struct Row {
        std::string key;
        FileEntry entry;
    };
    std::vector<Row> rows;
    rows.reserve(list.entries.size());
    for (FileEntry& entry : list.entries) rows.push_back({folded(entry.name), std::move(entry)});
    std::sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) {
        if (a.entry.is_folder != b.entry.is_folder) return a.entry.is_folder;
        return a.key != b.key ? a.key < b.key : a.entry.name < b.entry.name;
    });
    for (std::size_t i = 0; i < rows.size(); ++i) list.entries[i] = std::move(rows[i].entry);
    return list;
}

}  // namespace knead
