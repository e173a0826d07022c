// Drawings of results, made by a script of profiling/ if Python and matplotlib are installed.
#include <fmt/format.h>

#include <filesystem>

#include "host/base/child.h"
#include "host/bench/bench.h"

namespace knead {

std::string draw(const std::string& folder, const std::string& name,
                 const std::vector<std::string>& arguments, std::string& said)
{
    const std::string script = (std::filesystem::path(folder) / name).string();
    std::vector<std::string> words{"python3", script};
    words.insert(words.end(), arguments.begin(), arguments.end());
    const std::string by_hand = fmt::format("; by hand: python3 {} {}", script, arguments.at(0));
    if (!std::filesystem::exists(script))
        return fmt::format("drawings: no script {} (--data says where){}", script, by_hand);
    const int code = output_of(words, said);
    if (code == 127) return "drawings: no python3 on the PATH" + by_hand;
    if (code == 3) return "drawings: Python has no matplotlib here" + by_hand;
    if (code != 0) return fmt::format("drawings: the script ended with {}{}", code, by_hand);
    return "";
}

std::string draw(const Bench& bench, const std::string& json)
{
    const std::string& folder = bench.figures.folder;
    std::string said;
    return draw(folder, "plot.py",
                {json, "--peers", (std::filesystem::path(folder) / "peers.json").string()}, said);
}

}  // namespace knead
