// The drawings of a benchmark: profiling/plot.py makes them, where Python and matplotlib are.
#include <fmt/format.h>

#include <filesystem>

#include "host/bench/bench.h"
#include "host/base/child.h"

namespace knead {

std::string draw(const Bench& bench, const std::string& json)
{
    namespace fs = std::filesystem;
    const fs::path folder(bench.figures.folder);
    const std::string script = (folder / "plot.py").string();
    const std::string by_hand = fmt::format("; by hand: python3 {} {}", script, json);
    if (!fs::exists(script))
        return fmt::format("drawings: no script {} (--data says where){}", script, by_hand);
    std::string said;
    const int code =
        output_of({"python3", script, json, "--peers", (folder / "peers.json").string()}, said);
    if (code == 127) return "drawings: no python3 on the PATH" + by_hand;
    if (code == 3) return "drawings: Python has no matplotlib here" + by_hand;
    if (code != 0) return fmt::format("drawings: the script ended with {}{}", code, by_hand);
    return "";
}

}  // namespace knead
