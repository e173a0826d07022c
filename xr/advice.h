// Advice for users without a running headset, shared by `knead vr` and `knead doctor`.
#pragma once
#include <string>

namespace knead::xr {

// Manifest of the active runtime, searched for in the loader's order; "": none.
std::string runtime_manifest();

// Advice which program to start: the service of the active runtime if it is a known one.
std::string start_advice();

// Message for a runtime that has not returned from a call for `seconds` [s], with advice.
std::string no_answer(double seconds);

}  // namespace knead::xr
