// What is there of OpenXR, without a session: the loader, the file that names the runtime, and what
// that offers.
#include <cstdlib>
#include <filesystem>

#include "xr/extensions.h"
#include "xr/headset.h"
#include "xr/instance.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

std::string variable(const char* name)
{
    const char* value = std::getenv(name);
    return value ? value : "";
}

// In the order in which the loader looks. A name that was given counts though it leads nowhere.
std::string manifest()
{
    const std::string given = variable("XR_RUNTIME_JSON");
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

}  // namespace

RuntimeFacts runtime_facts()
{
    RuntimeFacts facts;
    facts.built = true;
    facts.manifest = manifest();
    try {
        const auto entry = xr::loader();
        facts.loader = true;
#ifndef _WIN32
        if (facts.manifest.empty())
            throw HeadsetError(
                "no runtime is active: start SteamVR, WiVRn or Monado and make it the active "
                "runtime, or name its file by XR_RUNTIME_JSON");
#endif
        const xr::Enabled has = xr::enabled_of(xr::offered_extensions(entry));
        facts.runtime = true;
        facts.used = has.names(), facts.missing = has.missing();
        if (!has[xr::opengl_enable])
            facts.reason = "the runtime lacks XR_KHR_opengl_enable, without which nothing is drawn";
    } catch (const std::exception& e) {
        facts.reason = e.what();
    }
    return facts;
}

}  // namespace knead
