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
