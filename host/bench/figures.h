// Published figures of other codes, and performance targets, read from data files.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace knead {

// A target: required value `must` and goal `aim`.
struct Target {
    std::string name, unit;
    double must = 0, aim = 0;
    bool min = false;      // true: lower bounds; false: upper bounds
    double measured = -1;  // negative: not measured
    std::string note;
    bool estimate = false;  // prediction for another card, without bounds
};

// peers.json
struct PeerFigures {
    std::string source, device;                 // source of the public codes' times
    std::map<std::string, double> public_best;  // seconds per substep, by size
    std::string splat_source;                   // source of splat_frame
    double splat_frame = 0;                 // time of a frame of clay in a splat scene [s]; 0: none
    std::string card;                       // card for which a time is estimated
    double multiprocessors = 0, clock = 0;  // clock of the card [1/s]
    double copy = 0;                        // copy rate of the card [bytes/s]
};

// targets.json
struct TargetList {
    std::string set_for;
    std::map<std::string, Target> targets;  // by key
};

struct Figures {
    std::string folder;
    std::optional<PeerFigures> peers;
    std::optional<TargetList> targets;
    std::string no_peers, no_targets;  // why there are none; "": loaded
};

// Folder of plot.py, peers.json, targets.json and peers/: `asked`, or if "" the bundled profiling/
// (host/base/paths.h).
std::string figures_folder(const std::string& requested);

// Runs the script `name` of that folder on the results in arguments[0]; `said` receives its output,
// one path per line. Returns "", or why there are no drawings and how to make them by hand.
std::string draw(const std::string& folder, const std::string& name,
                 const std::vector<std::string>& arguments, std::string& said);

// Reads the files that exist. Throws InputError with file and place for an invalid one.
Figures read_figures(const std::string& folder);

}  // namespace knead
