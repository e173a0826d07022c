// The complete state of a running scene as bytes: a replay or a session goes on from it with the
// bits of one that was not interrupted.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "host/paging/local_state.h"
#include "host/session/history.h"
#include "host/solver/editable_simulator.h"
#include "host/splats/carried.h"

namespace knead {

struct StoredState {
    SavedState state;      // of the simulator; without `config`: see `numbers` and `document`
    CarriedSplats splats;  // one per Gaussian; none if they are not drawn
    LocalState local;      // of a scene with local clay
    DocumentPtr document;  // not null
    ObjectNumbers numbers;
    std::uint32_t ids_used = 0;  // IdSource::most()
    long frames = 0;             // of the session
    double time = 0;             // of the session [s]
};

std::string to_bytes(const StoredState& state);
// Throws InputError for bytes that to_bytes() cannot have written; allocates nothing before the
// counts are checked against the bytes. Whether the values fit the scene is checked by its
// simulator and its splats. Files that objects name stay as they are. `file`: for messages.
StoredState state_from(const std::string& bytes, const std::string& file);

// Numbers to the bit. numbers_in() throws InputError with the place; `file`: for messages.
nlohmann::json json_of(const ObjectNumbers& numbers);
ObjectNumbers numbers_in(const nlohmann::json& value, const std::string& file);

}  // namespace knead
