#include "host/base/paths.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

namespace knead {
namespace fs = std::filesystem;

std::string ending(const std::string& path)
{
    std::string text = fs::path(path).extension().string();
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
    return text;
}

bool is_standard(const std::string& path)
{
    return path == "-" || (path.starts_with("-.") && path.find('/') == std::string::npos);
}

std::string shipped(const std::string& name)
{
    std::error_code problem;
    const fs::path program = fs::read_symlink("/proc/self/exe", problem).parent_path();
    for (const fs::path& folder :
         {program / "../share/knead", program / "..", program / "../..", fs::path()}) {
        if (!fs::exists(folder / name, problem)) continue;
        const fs::path whole = fs::weakly_canonical(folder / name, problem),
                       near = whole.lexically_relative(fs::current_path(problem));
        return near.empty() || *near.begin() == ".." ? whole.string() : near.string();
    }
    return "";
}

std::string file_or_shipped(const std::string& name)
{
    std::error_code problem;
    const fs::path path = fs::path(name).lexically_normal();
    if (name.empty() || path.is_absolute() || *path.begin() == ".." || fs::exists(name, problem))
        return name;
    const std::string form = ending(name);
    if (!form.empty() && form != ".json" && form != ".hands" && form != ".jsonl" &&
        form != ".knead")
        return name;
    const std::string file = path.string() + (form.empty() ? ".json" : "");
    const std::string found = shipped(file.starts_with("scenes/") ? file : "scenes/" + file);
    return found.empty() ? name : found;
}

std::vector<std::string> shipped_scenes()
{
    std::vector<std::string> names;
    std::error_code problem;
    for (fs::directory_iterator at(shipped("scenes"), problem), end; !problem && at != end;
         at.increment(problem))
        if (at->path().extension() == ".json") names.push_back(at->path().stem().string());
    std::sort(names.begin(), names.end());
    return names;
}

}  // namespace knead
