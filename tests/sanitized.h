// Whether this build has sanitizers: there the longest tests run the same code on less.
#pragma once

namespace knead {

#if defined(__SANITIZE_ADDRESS__) || defined(KNEAD_SANITIZED)
constexpr bool sanitized = true;
#else
constexpr bool sanitized = false;
#endif

}  // namespace knead
