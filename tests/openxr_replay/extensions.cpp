// Small extensions: the hidden area, the display's rate, and clocks.
#include "tests/openxr_replay/runtime.h"

namespace knead::replay {
namespace {

// The four corners of each eye's picture, in tangents: what round lenses do not show.
XrResult XRAPI_CALL mask(XrSession handle, XrViewConfigurationType, std::uint32_t view,
                         XrVisibilityMaskTypeKHR type, XrVisibilityMaskKHR* to)
{
    return answered("xrGetVisibilityMaskKHR", [&](Runtime&) {
        session_of(handle);
        check_struct(to, XR_TYPE_VISIBILITY_MASK_KHR);
        refuse_if(view > 1, XR_ERROR_VALIDATION_FAILURE, "not an eye");
        to->vertexCountOutput = to->indexCountOutput = 0;
        if (type != XR_VISIBILITY_MASK_TYPE_HIDDEN_TRIANGLE_MESH_KHR) return;
        std::vector<XrVector2f> corners;
        for (const float x : {-1.0f, 1.0f})
            for (const float y : {-1.0f, 1.0f})
                corners.insert(corners.end(), {{x, y}, {0.75f * x, y}, {x, 0.75f * y}});
        to->vertexCountOutput = to->indexCountOutput = std::uint32_t(corners.size());
        if (to->vertexCapacityInput == 0 && to->indexCapacityInput == 0) return;
        refuse_if(to->vertexCapacityInput < corners.size() ||
                      to->indexCapacityInput < corners.size() || !to->vertices || !to->indices,
                  XR_ERROR_SIZE_INSUFFICIENT, "too small a place for the mask");
        for (std::size_t i = 0; i < corners.size(); ++i)
            to->vertices[i] = corners[i], to->indices[i] = std::uint32_t(i);
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
    return answered("xrConvertTimeToTimespecTimeKHR", [&](Runtime&) {
        instance_of(handle);
        refuse_if(time <= 0, XR_ERROR_TIME_INVALID, "not a time");
        *to = {time_t(time / 1'000'000'000), long(time % 1'000'000'000)};
    });
}

XrResult XRAPI_CALL from_timespec(XrInstance handle, const timespec* from, XrTime* to)
{
    return answered("xrConvertTimespecTimeToTimeKHR", [&](Runtime&) {
        instance_of(handle);
        *to = XrTime(from->tv_sec) * 1'000'000'000 + from->tv_nsec;
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
