// The two-call idiom of OpenXR: one call for the length of a list, one for its elements.
#pragma once
#include <vector>

#include "xr/check.h"

namespace knead::xr {

// All elements listed by call(before..., capacity, &count, array). Elements are initialized with
// `blank`. Repeats both calls if the list grows between them. Throws XrFailure.
template <class T, class Function, class... Before>
std::vector<T> listed(Call<Function>& call, const T& blank, Before... before)
{
    for (;;) {
        std::uint32_t count = 0;
        call(before..., 0u, &count, nullptr);
        std::vector<T> all(count, blank);
        if (count == 0) return all;
        const XrResult result = call.raw(before..., count, &count, all.data());
        if (result == XR_ERROR_SIZE_INSUFFICIENT) continue;
        if (XR_FAILED(result)) call(before..., count, &count, all.data());
        all.resize(count, blank);
        return all;
    }
}

}  // namespace knead::xr
