// Options of a scene that a check varies: cells, particles, substeps, precision, contact; and
// filling, running and timing with them.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "host/verify/clay.h"
#include "host/verify/verify.h"

namespace knead {

// Cache of packed particle positions, by object, cells and particles per cell: packing is slow.
using Seeds = std::map<std::tuple<int, int, double>, std::vector<Place>>;

struct SceneOptions {
    int cells = 32;          // per metre
    double per_cell = 8;     // particles per cell
    double courant = 0;      // 0: the default
    bool in_double = false;  // run the reference on any device
    // True: packed as in scenes (model.md, 35). False: one particle in the centre of each cube,
    // per_cell, a cubic number, per cell.
    bool packed = false;
    bool grid_contact = true;
    int passes = Setup{}.passes;
    bool deterministic = false;
    int repeats = 1;                 // runs of cases shorter than 0.5 s; the fastest counts
    bool watch = false;              // record the depth of clay in tools at the ends of frames
    std::shared_ptr<Seeds> seeds{};  // shared by runs of a scene; null: pack anew
};

// Adds an object in the box `from` to `to`; depth(x) is the depth below its surface [m], negative
// outside. Returns the object's index.
int fill_by(Setup& setup, const SceneOptions& options, Material<double> material, Place from,
            Place to, const std::function<double(Place)>& depth);
int fill_by(Setup& setup, const SceneOptions& options, Material<double> material, Place from,
            Place to);

struct Driven {
    double seconds = 0;  // simulation time [s], without `look`
    FrameStats stats;    // accumulated over all frames
    double inside = 0;   // if `watch`: largest depth of a particle in a tool after a frame [m]
    std::unique_ptr<Simulator> solver;
};

// Runs drive() on `setup` with `options`, on the device of `v` or in double. `look` is called in
// the first run only, which determines the number of frames for the repeats.
Driven timed_drive(const Verification& v, const SceneOptions& options, Setup setup, double frame,
                   double end, const std::function<std::vector<Joint<double>>(double)>& at,
                   const std::function<bool(const Simulator&, double)>& observe);

inline std::vector<Joint<double>> no_tools(double) { return {}; }
inline bool no_look(const Simulator&, double) { return true; }

}  // namespace knead
