// Error against run time (work-precision): varied settings and the measure of each scene.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/verify/squeeze.h"
#include "host/verify/verify.h"

namespace knead {

struct FrontResult {
    double error = 0;    // in the scene's unit
    double seconds = 0;  // simulation time [s]
    double inside = 0;   // Driven::inside [m]
};

struct FrontScene {
    std::string name, unit;  // unit, usable in a key: "mm", "percent"
    std::string against;     // reference of the error
    std::vector<int> cells;  // per metre, coarse to fine
    std::function<FrontResult(const SceneOptions&)> run;
};

// Lattices of the scenes [cells/m]: of quick runs, CPU runs and GPU runs.
struct FrontSizes {
    std::vector<int> quick, cpu, gpu;
    const std::vector<int>& of(const Verification& v) const
    {
        return v.quick() ? quick : v.device.kind == DeviceKind::cuda ? gpu : cpu;
    }
};

// The defaults of a scene, with this number of cells.
SceneOptions default_options(int cells);

// A scene whose reference is its own result on the finest cells with default settings; distance(a,
// b) is the distance between two results [m]. A quick run has 16 and `second` cells/m.
template <class Run, class Distance>
FrontScene against_finest(const Verification& v, std::string name, const std::string& what,
                          int quick_finest, int second, Run run, Distance distance)
{
    using Result = decltype(run(v, SceneOptions{}));
    const int finest = FrontSizes{{quick_finest}, {96}, {192}}.of(v).front();
    const auto fine = std::make_shared<const Result>(run(v, default_options(finest)));
    const FrontSizes cells{{16, second}, {16, 24, 32, 48}, {32, 48, 64, 96}};
    return {std::move(name), "mm", what + " on " + std::to_string(finest) + " cells/m", cells.of(v),
            [&v, fine, run, distance](const SceneOptions& options) {
                const Result result = run(v, options);
                return FrontResult{1e3 * distance(result, *fine), result.seconds, result.inside};
            }};
}
inline double places_off(const Squeezed& a, const Squeezed& fine)
{
    return apart(a.at, fine.at).rms;
}

FrontScene squeeze_front(Verification& v);
FrontScene imprint_front(Verification& v);
FrontScene cantilever_front(Verification& v);
FrontScene sloshing_front(Verification& v);
FrontScene pile_front(Verification& v);

// Settings of a scene and their result.
struct FrontPoint {
    SceneOptions options;
    double error, seconds;  // in the scene's unit; [s]
    double counted = 0;     // count_errors()
    std::string name() const;
    std::string summary(const std::string& unit) const;  // error, counted error if larger, seconds
    bool usual() const;                                  // the defaults
    // Pareto dominance: no worse in counted error and time, better in one.
    bool beats(const FrontPoint& other) const;
};

// Sets `counted`: the maximum of the errors of the same settings on these and on finer cells. An
// error that changes sign under refinement may be small by chance.
void count_errors(std::vector<FrontPoint>& all);

// Points that dominate `one` by at least 10 %, beyond chance: the fastest at no larger error, and
// the most accurate at no longer time. Null: none.
struct Beaten {
    const FrontPoint *quicker = nullptr, *righter = nullptr;
    bool at_all() const { return quicker || righter; }
};
Beaten beaten_by(const std::vector<FrontPoint>& all, const FrontPoint& one);
// "on the front", or the dominating points with their values.
std::string standing(const Beaten& by, const std::string& unit);

// At one size, for the defaults and for each setting of the scene file changed alone: error, time,
// and depth of clay left in tools.
void feature_rows(Verification& v, const FrontScene& scene);
// Error against time of a ball's surface, over its nodes and smoothing.
void surface_front(Verification& v);

}  // namespace knead
