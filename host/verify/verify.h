// knead verify: accuracy, convergence, error against run time, stability. docs/reference/verify.md
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/base/machine.h"
#include "host/session/backend.h"
#include "host/verify/check.h"
#include "host/verify/known.h"

namespace knead {

struct VerifyOptions {
    std::vector<std::string> suites;  // none: all
    std::string device = "auto";      // auto, cuda, cuda:N, cpu or reference
    std::string only;                 // only parts whose name contains it
    std::string out;                  // folder; "": no files
    std::string one;   // run only this case of the stability suite; print its outcome as JSON
    std::string data;  // folder of known.json, plot_verify.py; "": the bundled one
    // Executable that runs each case of the stability suite in its own process; "": cases run in
    // this process, and a crash ends it.
    std::string program;
    bool quick = false, overwrite = false, json = false, quiet = false;
    int threads = 0;  // CPU; 0: all
};

// A row of a table beside the checks: stability map, error against run time.
struct VerifyRow {
    std::string table, name, outcome;
    std::vector<std::pair<std::string, double>> numbers;
};

// State shared by the suites: options, device, results so far.
class Verification {
  public:
    explicit Verification(const VerifyOptions& options);

    // Adds a check. Sets its seconds to the time since the last one or lap(), and `why` from
    // known.json.
    void add(Check check);
    void add(VerifyRow row) { rows.push_back(std::move(row)); }
    void lap() { mark = wall_seconds(); }
    void say(const std::string& text) const;  // on stderr

    std::unique_ptr<Simulator> solver(Setup setup) const;     // on the device of the options
    std::unique_ptr<Simulator> reference(Setup setup) const;  // in double
    bool quick() const { return options.quick; }

    const VerifyOptions options;
    const Device device;
    const KnownFailures known;
    std::string suite;  // current suite
    std::vector<Check> checks;
    std::vector<VerifyRow> rows;

  private:
    double mark = wall_seconds();
};

// A part of a suite: the checks of one file.
struct VerifyPart {
    const char *suite, *name;
    void (*run)(Verification&);
};
const std::vector<VerifyPart>& verify_parts();

void laws_part(Verification&);
void shear_part(Verification&);
void momentum_part(Verification&);
void floor_part(Verification&);
void rolling_part(Verification&);
void impact_part(Verification&);
void recovery_part(Verification&);
void hands_part(Verification&);
void spheres_part(Verification&);
void hertz_part(Verification&);
void sand_part(Verification&);
void dam_part(Verification&);
void patch_part(Verification&);
void waves_part(Verification&);
void twist_part(Verification&);
void locking_part(Verification&);
void cook_part(Verification&);
void manufactured_part(Verification&);
void squeeze_part(Verification&);
void front_part(Verification&);
void margin_part(Verification&);
void steps_part(Verification&);
void map_part(Verification&);

nlohmann::json verify_json(const Verification& v);
std::string verify_csv(const Verification& v);
std::string verify_text(const Check& check);
std::string verify_summary(const Verification& v);
// report.md, with references to these drawings beside it.
std::string verify_page(const Verification& v, const std::vector<std::string>& drawings = {});

// Runs all selected parts. An exception of a part becomes a failed check.
void run(Verification& v);

}  // namespace knead
