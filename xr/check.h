// Calls into OpenXR that throw where they fail, and are looked up when first made.
#pragma once
#include <stdexcept>
#include <string>

#include "xr/openxr.h"

namespace knead::xr {

// "XR_ERROR_SESSION_LOST", or the number of a result that is not known here.
std::string result_name(XrResult result);

// A struct of OpenXR with its type, all else zero.
template <class T>
T typed(XrStructureType type)
{
    T all{};
    all.type = type;
    return all;
}

// A call that failed: which, and why.
struct XrFailure : std::runtime_error {
    XrFailure(const char* call, XrResult result)
        : std::runtime_error(std::string(call) + ": " + result_name(result)), code(result)
    {
    }
    XrResult code;
};

// Where functions are found; of an instance, or of none before there is one.
struct Source {
    PFN_xrGetInstanceProcAddr address = nullptr;
    XrInstance instance = XR_NULL_HANDLE;
};

template <class Function>
class Call;

// One function. Answers its result, which is a success of some kind; throws XrFailure otherwise.
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
    // The result, whatever it is. Does not throw: destructors call it, and a lost runtime may no
    // longer have what they look up for the first time.
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
