// A run on its way, in a file: from it `knead run --resume` goes on as if nothing had ended it.
// docs/reference/formats.md has the layout.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "host/paging/local_state.h"
#include "host/run/run.h"
#include "host/splats/carried.h"

namespace knead {

struct Checkpoint {
    nlohmann::json command;  // how the run was asked for; the caller's
    RunRecord record;        // what it had found; without state and meshes
    SavedState state;        // of the solver; of its setup the particles and Gaussians alone
    CarriedSplats splats;    // one for each Gaussian; none where nothing draws these
    LocalState local;        // of a scene with local clay
};

constexpr const char* checkpoint_name = "checkpoint.knead";

// Throws OutputError. The file before it stands until this one is whole.
void write_checkpoint(const std::string& file, const Checkpoint& checkpoint);
// Throws InputError for a file that is no checkpoint, of another version, or damaged. What the
// numbers mean to a scene, its solver checks.
Checkpoint read_checkpoint(const std::string& file);
Checkpoint parse_checkpoint(const std::string& bytes, const std::string& file);

}  // namespace knead
