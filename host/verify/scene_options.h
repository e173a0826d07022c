// What a check may vary of a scene: cells, particles, substeps, precision, contact; and how it is
// filled, driven and timed by that.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "host/verify/clay.h"
#include "host/verify/verify.h"

namespace knead {

// What one scene was filled with, by object, cells and particles a cell: packing takes its time.
using Seeds = std::map<std::tuple<int, int, double>, std::vector<Place>>;

struct SceneOptions {
    int cells = 32;          // along 1 m
    double per_cell = 8;     // particles a cell
    double courant = 0;      // 0: the default
    bool in_double = false;  // by the reference, whatever the device
    bool packed = false;  // filled as a scene is (model.md, 35); else one particle in the middle of
                          // each cube, of which per_cell, a whole number cubed, fill a cell
    bool grid_contact = true;
    int passes = Setup{}.passes;
    bool deterministic = false;
    int repeats = 1;                 // of what takes less than half a second: the quickest counts
    bool watch = false;              // how deep clay is in tools at the ends of frames
    std::shared_ptr<Seeds> seeds{};  // of this scene's other runs; null: packed anew
};

// Adds an object that fills `from` to `to` where it is `depth` [m] under its surface, negative
// outside. Returns the object.
int fill_by(Setup& setup, const SceneOptions& options, Material<double> material, Place from,
            Place to, const std::function<double(Place)>& depth);
int fill_by(Setup& setup, const SceneOptions& options, Material<double> material, Place from,
            Place to);

struct Driven {
    double seconds = 0;  // of simulating, without those of looking
    FrameStats stats;    // of all frames in one
    double inside = 0;   // deepest of any particle in a tool at the end of a frame [m], if watched
    std::unique_ptr<Solver> solver;
};

// drive() of what `setup` makes by the rule, on the device of the options or in double. `look` sees
// the first run alone, which decides how many frames there are.
Driven timed_drive(const Verification& v, const SceneOptions& options, Setup setup, double frame,
                   double end, const std::function<std::vector<Joint<double>>(double)>& at,
                   const std::function<bool(const Solver&, double)>& look);

inline std::vector<Joint<double>> no_tools(double) { return {}; }
inline bool no_look(const Solver&, double) { return true; }

}  // namespace knead
