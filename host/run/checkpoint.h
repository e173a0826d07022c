// Checkpoint file of a run: `knead run --resume` continues from it with the same results as an
// uninterrupted run. Layout: docs/reference/formats.md.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "host/paging/local_state.h"
#include "host/run/run.h"
#include "host/splats/carried.h"

namespace knead {

struct Checkpoint {
    nlohmann::json command;  // command line of the run; opaque here
    RunRecord record;        // so far; without state and meshes
    SavedState state;        // of the simulator; only particles and Gaussians of its contents
    CarriedSplats splats;    // one per Gaussian; none if they are not drawn
    LocalState local;        // of a scene with local clay
};

constexpr const char* checkpoint_name = "checkpoint.knead";

// Writes the file atomically: an earlier checkpoint is kept until the new one is complete. Throws
// OutputError.
void write_checkpoint(const std::string& file, const Checkpoint& checkpoint);
// Throw InputError for a file that is no checkpoint, of another version, or damaged. Whether the
// values fit the scene is checked by its solver.
Checkpoint read_checkpoint(const std::string& file);
Checkpoint parse_checkpoint(const std::string& bytes, const std::string& file);

}  // namespace knead
