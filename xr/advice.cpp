#include "xr/advice.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

namespace knead::xr {
namespace {
namespace fs = std::filesystem;

std::string variable(const char* name)
{
    const char* value = std::getenv(name);
    return value ? value : "";
}

// Name and library of the runtime, in lower case; "" where the manifest cannot be read.
std::string runtime_words(const std::string& manifest)
{
    std::ifstream in(manifest);
    const nlohmann::json all = nlohmann::json::parse(in, nullptr, false);
    if (!all.is_object() || !all.contains("runtime") || !all["runtime"].is_object()) return "";
    std::string words;
    for (const char* key : {"name", "library_path"})
        if (const auto found = all["runtime"].find(key);
            found != all["runtime"].end() && found->is_string())
            words += found->get<std::string>() + " ";
    std::transform(words.begin(), words.end(), words.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    return words;
}

}  // namespace

// XR_RUNTIME_JSON takes precedence even if the file does not exist.
std::string runtime_manifest()
{
    std::string given = variable("XR_RUNTIME_JSON");
    if (!given.empty()) return given;
    const char* const rest = "openxr/1/active_runtime.json";
    std::vector<fs::path> folders;
    const std::string own = variable("XDG_CONFIG_HOME"), home = variable("HOME");
    if (!own.empty()) folders.push_back(own);
    if (own.empty() && !home.empty()) folders.push_back(fs::path(home) / ".config");
    for (const char* shared : {"/etc/xdg", "/usr/local/etc", "/etc"}) folders.push_back(shared);
    std::error_code problem;
    for (const fs::path& folder : folders)
        if (fs::exists(folder / rest, problem)) return (folder / rest).string();
    return "";
}

namespace {

// "": unknown runtime.
std::string known_advice()
{
    struct Known {
        const char *word, *advice;
    };
    // WiVRn first: its library name also contains "monado".
    constexpr Known known[] = {
        {"wivrn", "start wivrn-server, and connect the headset to it"},
        {"monado", "start monado-service"},
        {"steam", "start SteamVR"},
    };
    const std::string words = runtime_words(runtime_manifest());
    for (const Known& one : known)
        if (words.find(one.word) != words.npos) return one.advice;
    return "";
}

}  // namespace

std::string start_advice(XrResult result)
{
    if (result == XR_ERROR_API_LAYER_NOT_PRESENT)
        return "install the layers named in XR_ENABLE_API_LAYERS (\"" +
               variable("XR_ENABLE_API_LAYERS") + "\"), or unset it";
    const std::string known = known_advice();
    if (!known.empty()) return known;
    return "start SteamVR, WiVRn or Monado and make it the active runtime, or name its file by "
           "XR_RUNTIME_JSON";
}

std::string no_answer(double seconds)
{
    std::ostringstream text;
    const std::string known = known_advice();
    text << "the OpenXR runtime has not answered for " << seconds << " s: stop it, and "
         << (known.empty() ? "start it again" : known);
    return text.str();
}

}  // namespace knead::xr
