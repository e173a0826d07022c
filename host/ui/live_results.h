// What a session that people shape leaves on the disk: `knead view` and `knead vr`.
#pragma once
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "host/base/outputs.h"
#include "host/live/live_session.h"

namespace knead {

// Where it goes: --out and --record.
struct LiveOutputs {
    std::string out;     // folder: hands.hands, mesh.glb and the report; "": none
    std::string record;  // .hands or .jsonl; "": none
    std::string report;  // the report's name in `out`
    bool overwrite = false;

    bool any() const { return !out.empty() || !record.empty(); }
};
// Before the session begins: throws UsageError for a recording with another ending, OutputError for
// outputs that could not be written. The folder is this process's own while the lock lives.
[[nodiscard]] FolderLock prepare(const LiveOutputs& outputs);

struct LiveResults {
    Recording hands;      // as the simulation had them; without frames: none came
    HandActions actions;  // what was done beside them; the recording's hash is not filled in
    std::shared_ptr<const LiveState> state;
    ClayDigest clay;
};
// The parts of a report that are the same for all sessions: `simulation` and `hands`.
void add_simulation(nlohmann::json& report, const LiveResults& results, bool deterministic);
// Writes each result on its own: a failure is reported, and the others are still written. False
// after any failure.
bool write_results(const LiveOutputs& outputs, LiveResults& results, const nlohmann::json& report);

}  // namespace knead
