// OpenXR calls that throw on failure; functions are loaded at the first call.
#pragma once
#include <stdexcept>
#include <string>

#include "xr/openxr.h"

namespace knead::xr {

// Name such as "XR_ERROR_SESSION_LOST"; for a result outside the table its number.
std::string result_name(XrResult result);

// An OpenXR struct with `type` set and all other members zero.
template <class T>
T typed(XrStructureType type)
{
    T all{};
    all.type = type;
    return all;
}

// A failed call: its name and result.
struct XrFailure : std::runtime_error {
    XrFailure(const char* call, XrResult result)
        : std::runtime_error(std::string(call) + ": " + result_name(result)), code(result)
    {
    }
    XrResult code;
};

// xrGetInstanceProcAddr and the instance it is called with; null before the instance exists.
struct Source {
    PFN_xrGetInstanceProcAddr address = nullptr;
    XrInstance instance = XR_NULL_HANDLE;
};

template <class Function>
class Call;

// One function. Returns its result if that is a success code; throws XrFailure otherwise.
template <class... Of>
class Call<XrResult(XRAPI_PTR*)(Of...)> {
  public:
    Call(const Source& from, const char* called) : source(from), name(called) {}
    Call(const Call&) = delete;

    XrResult operator()(Of... of)
    {
        if (const XrResult result = raw(of...); XR_SUCCEEDED(result))
            return result;
        else
            throw XrFailure(name, result);
    }
    // Returns the result unchecked. Does not throw: destructors call it, and after a loss the
    // function may no longer be available.
    XrResult raw(Of... of) { return find() ? function(of...) : XR_ERROR_FUNCTION_UNSUPPORTED; }

  private:
    bool find()
    {
        if (function) return true;
        const XrResult found =
            source.address(source.instance, name, reinterpret_cast<PFN_xrVoidFunction*>(&function));
        if (XR_FAILED(found)) function = nullptr;
        return function;
    }

    const Source& source;
    const char* name;
    XrResult(XRAPI_PTR* function)(Of...) = nullptr;
};

}  // namespace knead::xr
