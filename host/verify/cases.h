// Violent little scenes, and how they end.
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/solver/audit.h"
#include "host/verify/clay.h"
#include "host/verify/verify.h"

namespace knead {

// Tools act until `action`, then stand still until `end`: from then on energy can only fall.
struct Case {
    std::string name;
    Setup setup;
    double action = 0, end = 0;                              // [s]
    std::function<std::vector<Joint<double>>(double)> at{};  // no tools: empty
    std::function<std::vector<char>(double)> active{};       // none: always
    double frame = 1.0 / 90;                                 // [s]
    std::string advice = "keep away from it, or lower step.courant";
    bool nonsense = false;  // must be refused
    double may_grow = 0;    // nothing acts: energy is at most so many times the first; 0: not asked
    double limit = 0;       // of wall time [s]; 0: as long as the suite gives to any
};

enum class Ending { stable, guarded, slow, refused, failed };
const char* ending_name(Ending e);

struct Outcome {
    Ending ending = Ending::failed;
    std::string note;  // counters, message or what went wrong
    FrameStats stats;
    double energy = 0;       // the most that was seen while all stood still [J]
    double energy_gain = 0;  // while all stood still, over the energy that there was [1]
    double fastest = 0;      // of the last state [m/s]
    double volume = 0;       // of the last state over that at the beginning [1]
    double simulated = 0, seconds = 0;
    double crowded = 0;  // share of particles around which clay lies in clay, of the last state [1]
    double densest = 0;  // times the room that is there, where it is worst [1]
};
nlohmann::json told(const Outcome& o);
Outcome heard(const nlohmann::json& all);  // throws nlohmann::json::exception

// All energy of the clay [J]: motion with that of each particle's own cell, strain, height.
double energy_of(const std::vector<Particle<double>>& all, const Setup& s);

// Volume that came or went for no reason, which nobody would hear of; "" if none did. The stress in
// clay that nothing holds sums up to nothing, so that only its yield stress, its weight, its motion
// and the energy that it was given keep it from its volume; 2 % are error. Of sand and packed snow
// nothing is known.
std::string silent_error(const Setup& s, const Audit& before, const Audit& after);

// To its end, or until `limit` [s] of wall time have passed.
Outcome outcome_of(const Verification& v, const Case& c, double limit, bool in_double = false);

// The same by another program, which tells its outcome as JSON. One that ends otherwise, or has not
// ended after `late` [s], is a failure that says so.
Outcome outcome_by(const std::vector<std::string>& words, double late);
// Every case in a process of its own, which has twice its limit and 30 s to start; as many at a
// time as there are threads; on a GPU one. `tell` is called in the order of the cases.
void outcomes_of(const Verification& v, const std::vector<Case>& cases,
                 const std::function<void(const Case&, const Outcome&)>& tell);
Outcome outcome_alone(const Verification& v, const Case& c);
double limit_of(const Verification& v, const Case& c);  // [s]; of plain loops twice that

// Changes particles between two frames, in the order of the setup, as a force or a grip from
// outside would: `how` gets all of them.
void change(Verification& v, std::unique_ptr<Solver>& solver, const Setup& s,
            const std::function<void(std::vector<Particle<double>>&)>& how);

// A block of 6 x 4 x 6 cells on a floor, per_axis^3 particles a cell, dx = 1 cm; its materials and
// tools can be changed before it runs.
Setup block_on_floor(const Material<double>& material, int per_axis = 2);
// The same with a ball of `radius` that comes down on it at `speed`, goes in by `depth`, and out.
Case pressed_block(std::string name, const Material<double>& material, double radius, double speed,
                   double depth, int per_axis = 2);

std::vector<Case> stability_cases(bool quick, bool gpu);  // of the map
std::vector<Case> margin_cases(bool quick);
// Any of both, also with a longer substep; throws UsageError for one that is not there.
Case case_named(const Verification& v, const std::string& name);
// With `times` the default substep, and a name that says so.
Case with_substep(Case c, double times);
extern const std::vector<double> substep_ladder;  // times the default

}  // namespace knead
