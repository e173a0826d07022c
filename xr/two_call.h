// OpenXR's lists: asked for once for their length, once for what is in them.
#pragma once
#include <vector>

#include "xr/check.h"

namespace knead::xr {

// Everything that `call` lists, where it takes `before`, a capacity, a count and an array. Elements
// start as `blank`. A list that grows between the two calls is asked for again.
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
