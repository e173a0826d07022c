// Error against run time: what is varied in every scene, and what each measures.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/verify/squeeze.h"
#include "host/verify/verify.h"

namespace knead {

using FrontRule = SqueezeRule;

struct FrontResult {
    double error = 0;    // in the scene's unit
    double seconds = 0;  // of simulating
};

struct FrontScene {
    std::string name, unit;  // the unit as a part of a name: "mm", "percent"
    std::string against;     // what the error is a distance from
    std::vector<int> cells;  // along 1 m, coarse to fine
    std::function<FrontResult(const FrontRule&)> run;
};

// Judged by its own result on the `finest` cells: off(a, b) is how far two of them are apart [m].
// A quick run has 16 cells and `second`.
template <class Run, class Off>
FrontScene against_finest(const Verification& v, std::string name, const std::string& what,
                          int finest, int second, Run run, Off off)
{
    using Result = decltype(run(v, FrontRule{}));
    const auto fine = std::make_shared<const Result>(run(v, {finest, 2, 0, false}));
    std::vector<int> cells{16, 24, 32, 48};
    if (v.quick()) cells = {16, second};
    return {std::move(name), "mm", what + " on " + std::to_string(finest) + " cells/m", cells,
            [&v, fine, run, off](const FrontRule& rule) {
                const Result result = run(v, rule);
                return FrontResult{1e3 * off(result, *fine), result.seconds};
            }};
}
inline double places_off(const Squeezed& a, const Squeezed& fine) { return apart(a, fine).rms; }

FrontScene squeeze_front(Verification& v);
FrontScene imprint_front(Verification& v);
FrontScene cantilever_front(Verification& v);
FrontScene sloshing_front(Verification& v);
FrontScene pile_front(Verification& v);

// On the device of the options, or in double.
std::unique_ptr<Solver> solver_by(const Verification& v, const FrontRule& rule, Setup setup);
// drive() without tools; gives the seconds that it took without those of `look`.
double timed_drive(Solver& solver, double frame, double end,
                   const std::function<bool(double)>& look);

}  // namespace knead
