#include "host/ui/recent_files.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/base/paths.h"
#include "host/session/session_file.h"
#include "host/ui/scene_list.h"

namespace knead {
namespace {

namespace fs = std::filesystem;

constexpr const char* recent_schema = "knead.recent/1";

std::string recent_list() { return (fs::path(log_folder()) / "recent.json").string(); }

// All that the list has, whether they exist or not.
std::vector<std::string> listed()
{
    std::vector<std::string> files;
    try {
        const Json root = Json::parse(read_text(recent_list(), 1 << 20));
        if (!root.is_object() || root.value("schema", Json()) != recent_schema) return {};
        for (const Json& one : root.at("files")) {
            if (!one.is_string() || files.size() == most_recent_files) continue;
            const auto file = one.get<std::string>();
            if (fs::path(file).is_absolute() && file.find('\0') == std::string::npos)
                files.push_back(file);
        }
    } catch (const std::exception&) {
        return {};
    }
    return files;
}

}  // namespace

std::vector<std::string> recent_files()
{
    std::vector<std::string> files = listed();
    std::error_code problem;
    std::erase_if(files, [&](const std::string& file) { return !fs::exists(file, problem); });
    return files;
}

void add_recent_file(const std::string& file)
{
    if (file.empty() || is_standard(file)) return;
    try {
        const fs::path whole = fs::absolute(file).lexically_normal();
        if (whole.extension() == log_ending &&
            path_key(whole.parent_path().string()) == path_key(log_folder()))
            return;
        std::vector<std::string> files = listed();
        std::erase_if(files, [&, key = path_key(whole.string())](const std::string& other) {
            return path_key(other) == key;
        });
        files.insert(files.begin(), whole.string());
        if (files.size() > most_recent_files) files.resize(most_recent_files);
        const Json root{{"schema", recent_schema}, {"files", files}};
        write_whole(recent_list(), root.dump(1) + "\n");
    } catch (const std::exception&) {  // a convenience: not worth a message
    }
}

}  // namespace knead
