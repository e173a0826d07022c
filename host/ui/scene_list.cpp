#include "host/ui/scene_list.h"

#include <algorithm>
#include <filesystem>

#include "host/base/paths.h"

namespace knead {

namespace fs = std::filesystem;

std::string path_key(const std::string& path)
{
    std::error_code problem;
    const fs::path whole = fs::weakly_canonical(path, problem);
    return problem ? path : whole.string();
}

std::vector<std::string> scenes_beside(const std::string& path)
{
    std::vector<std::string> found{path};
    std::error_code problem;
    const fs::path folder = fs::path(path).parent_path();
    for (fs::directory_iterator at(folder.empty() ? "." : folder, problem), end;
         !problem && at != end; at.increment(problem)) {
        const std::string one = at->path().lexically_normal().string();
        if (ending(one) == ".json" && path_key(one) != path_key(path)) found.push_back(one);
    }
    std::sort(found.begin(), found.end());
    return found;
}

}  // namespace knead
