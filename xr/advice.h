// Advice for users without a running headset, shared by `knead vr` and `knead doctor`.
#pragma once
#include <string>

#include "xr/openxr.h"

namespace knead::xr {

// Manifest of the active runtime, searched for in the loader's order; "": none.
std::string runtime_manifest();

// Advice after a call that failed with `result`: layers to install if one is missing, else which
// program to start, the service of the active runtime if it is a known one.
std::string start_advice(XrResult result = XR_ERROR_RUNTIME_UNAVAILABLE);

// Message for a runtime that has not returned from a call for `seconds` [s], with advice.
std::string no_answer(double seconds);

}  // namespace knead::xr
