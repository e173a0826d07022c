#include "host/base/container.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <sstream>
#include <vector>

namespace knead {
namespace {

// The first word of a file; "" if there is no such file.
std::string word_of(const std::string& file)
{
    std::string word;
    std::ifstream(file) >> word;
    return word;
}

// Parses bytes or microseconds. No limit: version 2 writes "max", version 1 a number near 2^63 or
// -1.
std::optional<std::size_t> number_of(const std::string& word)
{
    constexpr std::size_t none = std::size_t(1) << 62;
    std::size_t number = 0;
    const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (problem != std::errc() || end != word.data() + word.size() || number >= none) return {};
    return number;
}

// Sum of the rows with either name in a memory.stat [bytes].
std::size_t rows_of(const std::string& file, const std::string& first, const std::string& second)
{
    std::ifstream in(file);
    std::string name;
    std::size_t sum = 0;
    for (std::size_t bytes; in >> name >> bytes;)
        if (name == first || name == second) sum += bytes;
    return sum;
}

bool names(const std::string& list, const std::string& one)
{
    return ("," + list + ",").find("," + one + ",") != std::string::npos;
}

// mountinfo escapes blanks, tabs, line ends and backslashes as octal (\040).
std::string unescaped(const std::string& text)
{
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        int code = 0;
        if (text[i] == '\\' && i + 3 < text.size() &&
            std::from_chars(&text[i + 1], &text[i + 4], code, 8).ptr == &text[i + 4]) {
            out += char(code), i += 3;
        } else {
            out += text[i];
        }
    }
    return out;
}

// Mount point of a hierarchy, and the group mounted there.
struct Mount {
    std::string group, place;
};
// Version 2 if `controller` is empty, else the version 1 hierarchy with that controller.
std::optional<Mount> mount_of(const std::string& root, const std::string& controller)
{
    std::ifstream in(root + "/proc/self/mountinfo");
    for (std::string line; std::getline(in, line);) {
        const std::size_t dash = line.find(" - ");
        if (dash == std::string::npos) continue;
        std::istringstream before(line.substr(0, dash)), after(line.substr(dash + 3));
        std::string number, parent, device, group, place, type, source, options;
        before >> number >> parent >> device >> group >> place;
        after >> type >> source >> options;
        const bool ours =
            controller.empty() ? type == "cgroup2" : type == "cgroup" && names(options, controller);
        if (ours) return Mount{unescaped(group), unescaped(place)};
    }
    return {};
}

// Group of this process in that hierarchy.
std::optional<std::string> group_of(const std::string& root, const std::string& controller)
{
    std::ifstream in(root + "/proc/self/cgroup");  // lines of NUMBER:CONTROLLERS:GROUP
    for (std::string line; std::getline(in, line);) {
        const std::size_t first = line.find(':'), second = line.find(':', first + 1);
        if (first == std::string::npos || second == std::string::npos) continue;
        const std::string controllers = line.substr(first + 1, second - first - 1);
        if (controller.empty() ? controllers.empty() : names(controllers, controller))
            return line.substr(second + 1);
    }
    return {};
}

// Visible folders of this process's group and its ancestors.
std::vector<std::string> folders_of(const std::string& root, const std::string& controller)
{
    const std::optional<Mount> mount = mount_of(root, controller);
    std::optional<std::string> group = group_of(root, controller);
    if (!mount || !group) return {};
    // In a container, the mounted group may be far below the hierarchy's root.
    const std::string top = mount->group == "/" ? "" : mount->group;
    std::string below;
    if (group->starts_with(top + "/") && !group->starts_with("/.."))
        below = group->substr(top.size());
    if (below == "/") below.clear();
    std::vector<std::string> folders;
    for (;;) {
        folders.push_back(root + mount->place + below);
        if (below.empty()) return folders;
        below.erase(below.rfind('/'));
    }
}

template <class T>
void lower(std::optional<T>& to, T limit)
{
    to = to ? std::min(*to, limit) : limit;
}

void add_memory(ContainerLimits& all, std::size_t limit, std::size_t used, std::size_t cached)
{
    const std::size_t taken = used - std::min(used, cached);  // page cache is reclaimable
    lower(all.memory, limit);
    lower(all.free, limit - std::min(limit, taken));
}

void add_cpus(ContainerLimits& all, const std::string& quota, const std::string& period)
{
    const std::optional<std::size_t> time = number_of(quota), of = number_of(period);
    if (time && of && *time > 0 && *of > 0) lower(all.cpus, double(*time) / double(*of));
}

}  // namespace

ContainerLimits container_limits(const std::string& root)
{
    ContainerLimits all;
    for (const std::string& at : folders_of(root, "")) {
        for (const char* name : {"/memory.max", "/memory.high"})
            if (const auto limit = number_of(word_of(at + name)))
                add_memory(all, *limit, number_of(word_of(at + "/memory.current")).value_or(0),
                           rows_of(at + "/memory.stat", "inactive_file", "active_file"));
        std::string quota, period;
        std::ifstream(at + "/cpu.max") >> quota >> period;
        add_cpus(all, quota, period);
    }
    const std::vector<std::string> groups = folders_of(root, "memory");
    for (const std::string& at : groups) {
        // Without use_hierarchy, an ancestor does not limit its descendants.
        if (at != groups.front() && word_of(at + "/memory.use_hierarchy") == "0") break;
        if (const auto limit = number_of(word_of(at + "/memory.limit_in_bytes")))
            add_memory(all, *limit, number_of(word_of(at + "/memory.usage_in_bytes")).value_or(0),
                       rows_of(at + "/memory.stat", "total_inactive_file", "total_active_file"));
    }
    for (const std::string& at : folders_of(root, "cpu"))
        add_cpus(all, word_of(at + "/cpu.cfs_quota_us"), word_of(at + "/cpu.cfs_period_us"));
    return all;
}

}  // namespace knead
