#include "host/ui/session_line.h"

#include <fmt/format.h>

#include <filesystem>

#include "host/document/command_table.h"
#include "host/session/session_file.h"

namespace knead {
namespace fs = std::filesystem;

std::string session_line(const LiveState& state)
{
    if (!state.log.trouble.empty()) return "the log: " + state.log.trouble;
    if (state.unsaved) return "unsaved";
    return state.saved_as.empty() ? "" : "saved as " + state.saved_as;
}

std::string why_not(const Command& command, const LiveState& state)
{
    return row_of(command).why_not(state.situation);
}

Save save_command(const LiveState& state)
{
    if (!state.saved_as.empty() || !state.scene) return {state.saved_as, {}};
    const std::string name = fs::path(state.scene->scene.path).stem().string();
    std::error_code problem;
    std::string file = name + session_ending;
    for (int i = 2; fs::exists(file, problem) && i < 10000; ++i)
        file = fmt::format("{}-{}{}", name, i, session_ending);
    return {file, {}};
}

std::string duration_text(double seconds)
{
    if (seconds < 120) return fmt::format("{:.0f} s", seconds);
    if (seconds < 7200) return fmt::format("{:.0f} min", seconds / 60);
    if (seconds < 172800) return fmt::format("{:.0f} h", seconds / 3600);
    return fmt::format("{:.0f} days", seconds / 86400);
}

std::string recovery_line(std::size_t count)
{
    if (count == 0) return "";
    return fmt::format("{} session{} to recover: knead view, knead session list", count,
                       count == 1 ? "" : "s");
}

}  // namespace knead
