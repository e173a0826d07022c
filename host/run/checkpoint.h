// Checkpoint file of a run: `knead run --resume` continues from it with the same results as an
// uninterrupted run. It is a session that ends with the record of the run. Layout:
// docs/reference/formats.md.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "host/run/run.h"
#include "host/session/session_file.h"
#include "host/session/stored_state.h"

namespace knead {

struct Checkpoint {
    SessionMeta meta;        // of the run as a session; empty in version 6
    SceneSource scene;       // empty in version 6
    nlohmann::json command;  // command line of the run; opaque here
    RunRecord record;        // so far; without state and meshes
    // Of its state only particles and Gaussians of the contents. In version 6 without document,
    // numbers, frames and time.
    StoredState stored;
};

constexpr const char* checkpoint_name = "checkpoint.knead";

// Writes the file atomically: an earlier checkpoint is kept until the new one is complete. Throws
// OutputError.
void write_checkpoint(const std::string& file, const Checkpoint& checkpoint);
// Of this version or of version 6. Throws InputError for a file that is no checkpoint, of another
// version, or damaged. Whether the values fit the scene is checked by its solver.
Checkpoint read_checkpoint(const std::string& file);
// Whether read_checkpoint() would take it for a checkpoint, which may be damaged. Throws InputError
// for a file that is no session.
bool is_checkpoint(const std::string& file);

}  // namespace knead
