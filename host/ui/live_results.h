// Output files of an interactive session: `knead view` and `knead vr`.
#pragma once
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "host/base/outputs.h"
#include "host/document/command_text.h"
#include "host/live/live_session.h"

namespace knead {

// Output destinations: the options --out and --record.
struct LiveOutputs {
    // Folder: hands.hands, mesh.glb (in the frame of the scene's file) and the report; "": none.
    std::string out;
    std::string record;  // .hands or .jsonl; "": none
    std::string report;  // the report's name in `out`
    bool overwrite = false;

    bool any() const { return !out.empty() || !record.empty(); }
};
// Call before the session. Throws UsageError for a recording with another ending, OutputError for
// outputs that cannot be written. The lock gives exclusive use of the folder.
[[nodiscard]] FolderLock prepare(const LiveOutputs& outputs);

struct LiveResults {
    Recording hands;      // as the simulation received them; empty if there were none
    CommandLog commands;  // that were applied; without the recording's hash
    std::shared_ptr<const LiveState> state;
    ClayDigest clay;
};
// Adds the parts common to all sessions: `simulation` and `hands`.
void add_simulation(nlohmann::json& report, const LiveResults& results, bool deterministic);
// Writes each result independently: a failure is reported, the others are still written. Returns
// false after any failure.
bool write_results(const LiveOutputs& outputs, LiveResults& results, const nlohmann::json& report);

}  // namespace knead
