// Programs that break OpenXR's rules, one a name, so that tests can see the replay runtime notice.
// Prints the result of the wrong call; the runtime then ends the process with a code of its own.
// usage: openxr_misuse NAME
#include <cstdio>
#include <cstring>
#include <utility>

#include "xr/instance.h"
#include "xr/two_call.h"

using namespace knead;
using namespace knead::xr;

namespace {

struct Started {
    Api api{Source{loader(), XR_NULL_HANDLE}};
    std::unique_ptr<Platform> gl = egl_platform();
    XrSystemId system = XR_NULL_SYSTEM_ID;
    XrSession session = XR_NULL_HANDLE;

    Started()
    {
        const char* names[] = {"XR_KHR_opengl_enable", "XR_MNDX_egl_enable"};
        auto about = typed<XrInstanceCreateInfo>(XR_TYPE_INSTANCE_CREATE_INFO);
        std::strcpy(about.applicationInfo.applicationName, "misuse");
        about.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
        about.enabledExtensionCount = 2, about.enabledExtensionNames = names;
        XrInstance made = XR_NULL_HANDLE;
        api.create_instance(&about, &made);
        api.instance = made;
        auto wanted = typed<XrSystemGetInfo>(XR_TYPE_SYSTEM_GET_INFO);
        wanted.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
        api.system(made, &wanted, &system);
    }
    XrResult make_session(bool asks = true)
    {
        auto needs =
            typed<XrGraphicsRequirementsOpenGLKHR>(XR_TYPE_GRAPHICS_REQUIREMENTS_OPENGL_KHR);
        if (asks) api.gl_requirements(api.instance, system, &needs);
        auto about = typed<XrSessionCreateInfo>(XR_TYPE_SESSION_CREATE_INFO);
        about.next = gl->binding(), about.systemId = system;
        return api.create_session.raw(api.instance, &about, &session);
    }
    XrSwapchainCreateInfo chain_info() const
    {
        auto about = typed<XrSwapchainCreateInfo>(XR_TYPE_SWAPCHAIN_CREATE_INFO);
        about.usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT;
        about.format = 0x8C43;
        about.width = about.height = 64;
        about.sampleCount = about.faceCount = about.arraySize = about.mipCount = 1;
        return about;
    }
    // All that was made, in the right order.
    void end()
    {
        if (session) api.destroy_session.raw(session);
        api.destroy_instance.raw(api.instance);
    }
};

XrResult misuse(Started& s, const std::string& name)
{
    if (name == "none") return s.make_session();
    if (name == "unasked_requirements") return s.make_session(false);
    s.make_session();
    if (name == "begin_frame_first") {
        auto about = typed<XrFrameBeginInfo>(XR_TYPE_FRAME_BEGIN_INFO);
        return s.api.begin_frame.raw(s.session, &about);
    }
    if (name == "end_before_begin") return s.api.end_session.raw(s.session);
    if (name == "wrong_type") {
        auto about = typed<XrSessionBeginInfo>(XR_TYPE_SESSION_CREATE_INFO);
        return s.api.begin_session.raw(s.session, &about);
    }
    if (name == "dead_handle") {
        s.api.destroy_session.raw(s.session);
        return s.api.end_session.raw(std::exchange(s.session, XR_NULL_HANDLE));
    }
    if (name == "not_enabled") {
        auto about = typed<XrHandTrackerCreateInfoEXT>(XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT);
        XrHandTrackerEXT made = XR_NULL_HANDLE;
        return s.api.create_hand_tracker.raw(s.session, &about, &made);
    }
    if (name == "skewed_space") {
        auto about = typed<XrReferenceSpaceCreateInfo>(XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
        about.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
        XrSpace made = XR_NULL_HANDLE;  // its quaternion is zero
        return s.api.create_reference_space.raw(s.session, &about, &made);
    }
    if (name == "unknown_struct") {
        XrBaseInStructure stranger{XrStructureType(2000000000), nullptr};
        auto about = typed<XrReferenceSpaceCreateInfo>(XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
        about.next = &stranger;
        about.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
        about.poseInReferenceSpace.orientation.w = 1;
        XrSpace made = XR_NULL_HANDLE;
        const XrResult result = s.api.create_reference_space.raw(s.session, &about, &made);
        s.api.destroy_space.raw(made);
        return result;
    }
    if (name == "twice_the_same_name") {
        auto about = typed<XrActionSetCreateInfo>(XR_TYPE_ACTION_SET_CREATE_INFO);
        std::strcpy(about.actionSetName, "clay"), std::strcpy(about.localizedActionSetName, "Clay");
        XrActionSet first = XR_NULL_HANDLE, second = XR_NULL_HANDLE;
        s.api.create_action_set(s.api.instance, &about, &first);
        const XrResult result = s.api.create_action_set.raw(s.api.instance, &about, &second);
        s.api.destroy_action_set.raw(first);
        return result;
    }
    if (name == "unwaited_image") {
        const XrSwapchainCreateInfo about = s.chain_info();
        XrSwapchain chain = XR_NULL_HANDLE;
        s.api.create_swapchain(s.session, &about, &chain);
        std::uint32_t index = 0;
        s.api.acquire_image(chain, nullptr, &index);
        const XrResult result = s.api.release_image.raw(chain, nullptr);
        s.api.destroy_swapchain.raw(chain);
        return result;
    }
    if (name == "strange_format") {
        XrSwapchainCreateInfo about = s.chain_info();
        about.format = 0x1908;
        XrSwapchain chain = XR_NULL_HANDLE;
        return s.api.create_swapchain.raw(s.session, &about, &chain);
    }
    if (name == "pending_gl_error") {
        const auto disable = reinterpret_cast<void (*)(unsigned)>(s.gl->address()("glDisable"));
        disable(0xffff);
        const XrSwapchainCreateInfo about = s.chain_info();
        XrSwapchain chain = XR_NULL_HANDLE;
        return s.api.create_swapchain.raw(s.session, &about, &chain);
    }
    if (name == "bad_path") {
        XrPath path = XR_NULL_PATH;
        return s.api.path.raw(s.api.instance, "/User/Hand", &path);
    }
    if (name == "leak") {
        const XrSwapchainCreateInfo about = s.chain_info();
        XrSwapchain chain = XR_NULL_HANDLE;
        return s.api.create_swapchain.raw(s.session, &about, &chain);
    }
    std::fprintf(stderr, "no such misuse\n");
    return XR_ERROR_VALIDATION_FAILURE;
}

}  // namespace

int main(int count, char** words)
{
    Started s;
    XrResult result = XR_SUCCESS;
    try {
        result = misuse(s, count > 1 ? words[1] : "none");
    } catch (const XrFailure& e) {
        result = e.code;
    }
    std::printf("%s\n", result == XR_SUCCESS ? "XR_SUCCESS" : result_name(result).c_str());
    s.end();
}
