// Figures of others, and the bounds that are to be met: data files, none of it in the program.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace knead {

// A bound to be met: `must` and, better, `aim`.
struct Target {
    std::string name, unit;
    double must = 0, aim = 0;
    bool min = false;      // the measured value must be at least so large
    double measured = -1;  // negative: not measured
    std::string note;
    bool estimate = false;  // says what may be, on another card; has no bounds
};

// peers.json
struct PeerFigures {
    std::string source, device;                 // of the public codes' times
    std::map<std::string, double> public_best;  // seconds per substep, by size
    std::string splat_source;                   // of what follows
    double splat_frame = 0;  // seconds of a frame of clay in a scene of splats; 0: no figure
    std::string card;        // for which a time is estimated
    double multiprocessors = 0, clock = 0;  // its [1/s]
    double copy = 0;                        // bytes per second of a copy on it
};

// targets.json
struct TargetList {
    std::string set_for;
    std::map<std::string, Target> targets;  // by their keys
};

struct Figures {
    std::string folder;
    std::optional<PeerFigures> peers;
    std::optional<TargetList> targets;
    std::string no_peers, no_targets;  // why there are none; "" if there are
};

// Where plot.py, peers.json, targets.json and peers/ are: `asked`; if that is "", profiling/ of
// what comes with the program (host/base/paths.h).
std::string figures_folder(const std::string& asked);

// Has the script `name` of that folder draw the results in arguments[0]; it says a path a line.
// What it gives is why there are no drawings, and how to make them by hand; "" if there are.
std::string draw(const std::string& folder, const std::string& name,
                 const std::vector<std::string>& arguments, std::string& said);

// A file that is not there is no fault. Throws InputError with file and place for one that is
// wrong.
Figures read_figures(const std::string& folder);

}  // namespace knead
