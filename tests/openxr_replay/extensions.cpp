// Small extensions: the hidden area, the display's rate, and clocks.
#include <algorithm>

#include "tests/openxr_replay/runtime.h"

namespace knead::replay {
namespace {

// The four corners of each eye's picture, in tangents: what round lenses do not show.
struct Mask {
    std::vector<XrVector2f> corners;
    std::vector<std::uint32_t> indices;
};

// What is left of the square between them, anticlockwise.
std::vector<XrVector2f> visible_outline()
{
    return {{1, -0.75f}, {1, 0.75f},   {0.75f, 1},   {-0.75f, 1},
            {-1, 0.75f}, {-1, -0.75f}, {-0.75f, -1}, {0.75f, -1}};
}

Mask mask_of(XrVisibilityMaskTypeKHR type)
{
    Mask made;
    if (type == XR_VISIBILITY_MASK_TYPE_HIDDEN_TRIANGLE_MESH_KHR) {
        for (const float x : {-1.0f, 1.0f})
            for (const float y : {-1.0f, 1.0f}) {
                const XrVector2f along{0.75f * x, y}, up{x, 0.75f * y};
                const bool turned = x * y < 0;  // all triangles are anticlockwise
                made.corners.insert(made.corners.end(),
                                    {{x, y}, turned ? up : along, turned ? along : up});
            }
    } else {
        made.corners = visible_outline();
    }
    const auto count = std::uint32_t(made.corners.size());
    if (type == XR_VISIBILITY_MASK_TYPE_VISIBLE_TRIANGLE_MESH_KHR)
        for (std::uint32_t i = 2; i < count; ++i)
            made.indices.insert(made.indices.end(), {0, i - 1, i});
    else
        for (std::uint32_t i = 0; i < count; ++i) made.indices.push_back(i);
    return made;
}

XrResult XRAPI_CALL mask(XrSession handle, XrViewConfigurationType views, std::uint32_t view,
                         XrVisibilityMaskTypeKHR type, XrVisibilityMaskKHR* to)
{
    return answered("xrGetVisibilityMaskKHR", [&](Runtime&) {
        session_of(handle);
        check_struct(to, XR_TYPE_VISIBILITY_MASK_KHR);
        refuse_if(view > 1, XR_ERROR_VALIDATION_FAILURE, "not an eye");
        check_view_type(views);
        refuse_if(type < XR_VISIBILITY_MASK_TYPE_HIDDEN_TRIANGLE_MESH_KHR ||
                      type > XR_VISIBILITY_MASK_TYPE_LINE_LOOP_KHR,
                  XR_ERROR_VALIDATION_FAILURE, "not a kind of mask");
        const Mask all = mask_of(type);
        to->vertexCountOutput = std::uint32_t(all.corners.size());
        to->indexCountOutput = std::uint32_t(all.indices.size());
        if (to->vertexCapacityInput == 0 || to->indexCapacityInput == 0) return;
        refuse_if(!to->vertices || !to->indices, XR_ERROR_VALIDATION_FAILURE,
                  "no place for the mask");
        refuse_if(to->vertexCapacityInput < all.corners.size() ||
                      to->indexCapacityInput < all.indices.size(),
                  XR_ERROR_SIZE_INSUFFICIENT, "too small a place for the mask");
        std::copy(all.corners.begin(), all.corners.end(), to->vertices);
        std::copy(all.indices.begin(), all.indices.end(), to->indices);
    });
}

XrResult XRAPI_CALL rates(XrSession handle, std::uint32_t capacity, std::uint32_t* count, float* to)
{
    return answered("xrEnumerateDisplayRefreshRatesFB", [&](Runtime&) {
        session_of(handle);
        return give(std::vector<float>{72, 80, 90, 120}, capacity, count, to);
    });
}

XrResult XRAPI_CALL rate(XrSession handle, float* to)
{
    return answered("xrGetDisplayRefreshRateFB", [&](Runtime& r) {
        session_of(handle);
        *to = float(1e9 / double(r.clock.period()));
    });
}

XrResult XRAPI_CALL ask_rate(XrSession handle, float value)
{
    return answered("xrRequestDisplayRefreshRateFB", [&](Runtime& r) {
        session_of(handle);
        const bool known = value == 0 || value == 72 || value == 80 || value == 90 || value == 120;
        refuse_if(!known, XR_ERROR_DISPLAY_REFRESH_RATE_UNSUPPORTED_FB, "a rate not offered");
        if (value > 0) r.clock.change(double(value));
    });
}

XrResult XRAPI_CALL to_timespec(XrInstance handle, XrTime time, timespec* to)
{
    return answered("xrConvertTimeToTimespecTimeKHR", [&](Runtime& r) {
        instance_of(handle);
        refuse_if(time <= 0, XR_ERROR_TIME_INVALID, "not a time");
        time += clock_offset(r);
        *to = {time_t(time / 1'000'000'000), long(time % 1'000'000'000)};
    });
}

XrResult XRAPI_CALL from_timespec(XrInstance handle, const timespec* from, XrTime* to)
{
    return answered("xrConvertTimespecTimeToTimeKHR", [&](Runtime& r) {
        instance_of(handle);
        *to = XrTime(from->tv_sec) * 1'000'000'000 + from->tv_nsec - clock_offset(r);
        refuse_if(*to <= 0, XR_ERROR_TIME_INVALID, "before the runtime's clock began");
    });
}

}  // namespace

void add_extension_functions(Table& to)
{
    to["xrGetVisibilityMaskKHR"] = entry(mask);
    to["xrEnumerateDisplayRefreshRatesFB"] = entry(rates);
    to["xrGetDisplayRefreshRateFB"] = entry(rate);
    to["xrRequestDisplayRefreshRateFB"] = entry(ask_rate);
    to["xrConvertTimeToTimespecTimeKHR"] = entry(to_timespec);
    to["xrConvertTimespecTimeToTimeKHR"] = entry(from_timespec);
}

}  // namespace knead::replay
