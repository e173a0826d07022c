// Small extreme scenes and their outcomes.
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/solver/audit.h"
#include "host/verify/clay.h"
#include "host/verify/verify.h"

namespace knead {

// Tools move until `action`, then rest until `end`; in the second phase energy must not rise.
struct Case {
    std::string name;
    Setup setup;
    double action = 0, end = 0;                              // [s]
    std::function<std::vector<Joint<double>>(double)> at{};  // empty: no tools
    std::function<std::vector<char>(double)> active{};       // empty: always active
    double frame = 1.0 / 90;                                 // [s]
    std::string advice = "keep away from it, or lower step.courant";
    bool nonsense = false;  // invalid: must be refused
    double may_grow = 0;  // without tools: bound on energy over the initial energy; 0: not checked
    double limit = 0;     // wall time limit [s]; 0: the suite's
};

enum class Ending { stable, guarded, slow, refused, failed };
const char* ending_name(Ending e);

struct Outcome {
    Ending ending = Ending::failed;
    std::string note;  // counters, or message of the failure
    FrameStats stats;
    double energy = 0;       // maximum while the tools rest [J]
    double energy_gain = 0;  // rise while the tools rest, over the energy at its start [1]
    double fastest = 0;      // maximum speed of the last state [m/s]
    double volume = 0;       // volume of the last state over the initial one [1]
    double simulated = 0, seconds = 0;
    double crowded = 0;  // fraction of particles in overlapping clay, of the last state [1]
    double densest = 0;  // largest ratio of clay volume to available space [1]
};
nlohmann::json json_of(const Outcome& o);
Outcome parse_outcome(const nlohmann::json& all);  // throws nlohmann::json::exception

// Total energy of the clay [J]: kinetic, including the affine part of each particle, elastic, and
// potential.
double energy_of(const std::vector<Particle<double>>& all, const Setup& s);

// Describes an unexplained change of volume that no guard reports; "": none. The stress in free
// clay has mean zero, so only its yield stress, weight, motion and supplied energy can keep it from
// its rest volume; 2 % are allowed as error. Sand and snow are not checked.
std::string silent_error(const Setup& s, const Audit& before, const Audit& after);

// Runs the case to its end, or for `limit` [s] of wall time. Exceptions become outcomes.
Outcome outcome_of(const Verification& v, const Case& c, double limit, bool in_double = false);

// The same in a child process that prints its outcome as JSON. Any other exit, or none within
// `late` [s], is an outcome `failed` with a note.
Outcome outcome_by(const std::vector<std::string>& words, double late);
// Runs each case in its own process, with twice its limit plus 30 s for startup; as many in
// parallel as there are threads, one on a GPU. Calls `tell` on the calling thread, in the order of
// the cases.
void outcomes_of(const Verification& v, const std::vector<Case>& cases,
                 const std::function<void(const Case&, const Outcome&)>& report);
Outcome outcome_alone(const Verification& v, const Case& c);
double limit_of(const Verification& v, const Case& c);  // [s]; doubled for the reference

// Applies `how` to all particles, in the order of the setup, between two frames, e.g. an external
// force.
void change(Verification& v, std::unique_ptr<Simulator>& solver, const Setup& s,
            const std::function<void(std::vector<Particle<double>>&)>& how);

// A block of 6 x 4 x 6 cells on a floor, per_axis^3 particles per cell, dx = 1 cm.
Setup block_on_floor(const Material<double>& material, int per_axis = 2);
// The same with a ball of `radius` [m] that descends at `speed` [m/s] to `depth` [m] and withdraws.
Case pressed_block(std::string name, const Material<double>& material, double radius, double speed,
                   double depth, int per_axis = 2);

std::vector<Case> stability_cases(bool quick, bool gpu);  // cases of the stability map
std::vector<Case> margin_cases(bool quick);
// A case of either list, also with a longer substep, by name; throws UsageError for an unknown one.
Case case_named(const Verification& v, const std::string& name);
// The case with `times` the default substep, appended to its name.
Case with_substep(Case c, double times);
extern const std::vector<double> substep_ladder;  // multiples of the default substep

}  // namespace knead
