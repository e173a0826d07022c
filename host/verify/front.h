// Error against run time: what is varied in every scene, and what each measures.
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
    double seconds = 0;  // of simulating
    double inside = 0;   // Driven::inside [m]
};

struct FrontScene {
    std::string name, unit;  // the unit as a part of a name: "mm", "percent"
    std::string against;     // what the error is a distance from
    std::vector<int> cells;  // along 1 m, coarse to fine
    std::function<FrontResult(const SceneOptions&)> run;
};

// Lattices of the scenes: 1 m of a quick run's, of a CPU's and of a GPU's.
struct FrontSizes {
    std::vector<int> quick, cpu, gpu;
    const std::vector<int>& of(const Verification& v) const
    {
        return v.quick() ? quick : v.device.kind == DeviceKind::cuda ? gpu : cpu;
    }
};

// As a scene is by default, with so many cells.
SceneOptions default_options(int cells);

// Judged by its own result on the `finest` cells, by default else: off(a, b) is how far two of them
// are apart [m]. A quick run has 16 cells and `second`.
template <class Run, class Off>
FrontScene against_finest(const Verification& v, std::string name, const std::string& what,
                          int quick_finest, int second, Run run, Off off)
{
    using Result = decltype(run(v, SceneOptions{}));
    const int finest = FrontSizes{{quick_finest}, {96}, {192}}.of(v).front();
    const auto fine = std::make_shared<const Result>(run(v, default_options(finest)));
    const FrontSizes cells{{16, second}, {16, 24, 32, 48}, {32, 48, 64, 96}};
    return {std::move(name), "mm", what + " on " + std::to_string(finest) + " cells/m", cells.of(v),
            [&v, fine, run, off](const SceneOptions& options) {
                const Result result = run(v, options);
                return FrontResult{1e3 * off(result, *fine), result.seconds, result.inside};
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

// A setting of a scene, and what came of it.
struct FrontPoint {
    SceneOptions options;
    double error, seconds;  // in the scene's unit, [s]
    double counted = 0;     // count_errors()
    std::string name() const;
    std::string told(const std::string& unit) const;  // error, what counts if that is more, seconds
    bool usual() const;                               // the defaults
    // No worse in either, better in one; by what counts.
    bool beats(const FrontPoint& other) const;
};

// An error that passes through zero as cells get finer is less by luck than that of the same
// setting on finer cells. What counts is the greatest of it and those.
void count_errors(std::vector<FrontPoint>& all);

// What is better than `one` by a tenth, which chance is not, and no worse else: the quickest of
// those as right, and the most right of those as quick. Null where there is none.
struct Beaten {
    const FrontPoint *quicker = nullptr, *righter = nullptr;
    bool at_all() const { return quicker || righter; }
};
Beaten beaten_by(const std::vector<FrontPoint>& all, const FrontPoint& one);
// "on the front", or by what it is beaten in what, with the numbers of that.
std::string standing(const Beaten& by, const std::string& unit);

// At one size, the default and each setting of a scene's file by itself: error, time, and how deep
// clay is left in tools.
void feature_rows(Verification& v, const FrontScene& scene);
// Of a ball's surface: error against time over its nodes and its smoothing.
void surface_front(Verification& v);

}  // namespace knead
