// What a user without a headset is told to do: one text for `knead vr` and `knead doctor`.
#pragma once
#include <string>

namespace knead::xr {

// The file that names the active runtime, looked for in the loader's order; "": there is none.
std::string runtime_manifest();

// Which program to start: the runtime's own service where its manifest is of a runtime that is
// known here.
std::string start_advice();

// Of a runtime that has not returned from a call for so long [s], with advice.
std::string no_answer(double seconds);

}  // namespace knead::xr
