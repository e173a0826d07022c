// Outputs of a run: report.json, frames.csv and the summary in text form.
// docs/reference/formats.md
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cuda/math/box.h"
#include "host/document/document.h"
#include "host/run/run.h"
#include "host/session/history.h"

namespace knead {

// An object of a document, and its clay.
struct ObjectFacts {
    ObjectId id;
    std::string name;
    int category = 0;
    long particles = 0;
    double mass = 0, volume = 0;             // [kg] [m^3]
    Box3<double> box = empty_box<double>();  // of its particles, in the scene file's frame [m]
};

// Facts for the report that are not in RunRecord.
struct RunInfo {
    std::string solver;                  // Simulator::name()
    int threads = 0;                     // requested; 0: all
    double cpu_seconds = 0;              // of the whole process during the loop
    double hand_rate = 0;                // of the recording [1/s]; 0: no hands
    double hand_latency = 0;             // of the tracker [s]
    std::size_t splats = 0, inside = 0;  // that follow clay; of these, filled in inside objects
    bool local = false;                  // the scene has local clay
    std::vector<std::string> left_out;
    std::vector<std::string> settings;   // --set as given
    std::vector<std::string> outputs;    // files written
    std::vector<ObjectFacts> objects;    // of the document at the end
    std::optional<HistoryInfo> history;  // of a run with commands
};

struct Spread {
    double median = 0, p95 = 0, mean = 0, max = 0;
};
Spread spread(std::vector<double> values);  // zeros for none; nearest-rank percentiles

nlohmann::json report(const Scene& scene, const RunRecord& record, const RunInfo& facts);
// `particles` in the scene file's frame; `materials` by the simulator's objects, whose numbers
// `simulated` gives. Paged clay belongs to the one object that is paged.
std::vector<ObjectFacts> object_facts(const Document& document,
                                      const std::function<std::vector<int>(ObjectId)>& simulated,
                                      const std::vector<Particle<double>>& particles,
                                      const std::vector<Material<double>>& materials);
// Objects that are simulated softer than given, each with its text; [] for none.
nlohmann::json softened_facts(const Scene& scene);
std::string file_hash(const std::string& path);  // xxh64; "" if the file cannot be read
std::string frames_csv(const RunRecord& record);
// Throws InputError if a value that summary() needs is missing or of the wrong type.
void check_report(const nlohmann::json& report, const std::string& file);
std::string summary(const nlohmann::json& report);  // precondition: check_report()
const char* end_name(End end);

}  // namespace knead
