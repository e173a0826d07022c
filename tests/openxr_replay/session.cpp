// Systems' views, sessions and their life.
#include "tests/openxr_replay/runtime.h"

namespace knead::replay {
namespace {

void check_system(XrInstance handle, XrSystemId system)
{
    refuse_if(!instance_of(handle).asked_system || system != the_system, XR_ERROR_SYSTEM_INVALID,
              "not the system, or never asked for");
}

XrResult XRAPI_CALL view_types(XrInstance handle, XrSystemId system, std::uint32_t capacity,
                               std::uint32_t* count, XrViewConfigurationType* to)
{
    return answered("xrEnumerateViewConfigurations", [&](Runtime&) {
        check_system(handle, system);
        return give(std::vector<XrViewConfigurationType>{XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO},
                    capacity, count, to);
    });
}

XrResult XRAPI_CALL view_properties(XrInstance handle, XrSystemId system,
                                    XrViewConfigurationType type, XrViewConfigurationProperties* to)
{
    return answered("xrGetViewConfigurationProperties", [&](Runtime&) {
        check_system(handle, system);
        check_view_type(type);
        check_struct(to, XR_TYPE_VIEW_CONFIGURATION_PROPERTIES);
        to->viewConfigurationType = type;
        to->fovMutable = XR_FALSE;
    });
}

XrResult XRAPI_CALL views(XrInstance handle, XrSystemId system, XrViewConfigurationType type,
                          std::uint32_t capacity, std::uint32_t* count, XrViewConfigurationView* to)
{
    return answered("xrEnumerateViewConfigurationViews", [&](Runtime& r) {
        check_system(handle, system);
        check_view_type(type);
        for (std::uint32_t i = 0; to && i < capacity; ++i)
            check_struct(&to[i], XR_TYPE_VIEW_CONFIGURATION_VIEW);
        const auto width = std::uint32_t(r.script.width), height = std::uint32_t(r.script.height);
        const XrViewConfigurationView one{
            XR_TYPE_VIEW_CONFIGURATION_VIEW, nullptr, width, 8192, height, 8192, 1, 1};
        return give(std::vector<XrViewConfigurationView>(2, one), capacity, count, to);
    });
}

XrResult XRAPI_CALL blend_modes(XrInstance handle, XrSystemId system, XrViewConfigurationType type,
                                std::uint32_t capacity, std::uint32_t* count,
                                XrEnvironmentBlendMode* to)
{
    return answered("xrEnumerateEnvironmentBlendModes", [&](Runtime& r) {
        check_system(handle, system);
        check_view_type(type);
        std::vector<XrEnvironmentBlendMode> modes{XR_ENVIRONMENT_BLEND_MODE_OPAQUE};
        if (r.script.passthrough) modes.push_back(XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND);
        return give(modes, capacity, count, to);
    });
}

XrResult XRAPI_CALL gl_needs(XrInstance handle, XrSystemId system,
                             XrGraphicsRequirementsOpenGLKHR* to)
{
    return answered("xrGetOpenGLGraphicsRequirementsKHR", [&](Runtime&) {
        check_system(handle, system);
        check_struct(to, XR_TYPE_GRAPHICS_REQUIREMENTS_OPENGL_KHR);
        to->minApiVersionSupported = XR_MAKE_VERSION(4, 0, 0);
        to->maxApiVersionSupported = XR_MAKE_VERSION(4, 6, 0);
        instance_of(handle).asked_gl = true;
    });
}

XrResult XRAPI_CALL create(XrInstance handle, const XrSessionCreateInfo* info, XrSession* to)
{
    return answered("xrCreateSession", [&](Runtime& r) {
        InstanceObject& instance = instance_of(handle);
        check_struct(info, XR_TYPE_SESSION_CREATE_INFO,
                     {XR_TYPE_GRAPHICS_BINDING_EGL_MNDX, XR_TYPE_GRAPHICS_BINDING_OPENGL_XLIB_KHR});
        check_system(handle, info->systemId);
        refuse_if(!instance.asked_gl, XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING,
                  "the requirements of OpenGL were not asked for");
        refuse_if(r.live_session() != nullptr, XR_ERROR_LIMIT_REACHED, "one session at a time");
        auto made = std::make_unique<SessionObject>();
        made->gl = gl_of(info->next);
        refuse_if(!made->gl, XR_ERROR_GRAPHICS_DEVICE_INVALID, "no graphics binding");
        r.note({{"session", made->gl->name()}, {"frame", r.frame}});
        if (r.context_stolen) made->gl->steal();
        *to = r.add<XrSession>(std::move(made), number_of(handle));
    });
}

XrResult XRAPI_CALL destroy(XrSession handle)
{
    return answered("xrDestroySession", [&](Runtime& r) {
        r.get<SessionObject>(handle);
        r.remove(number_of(handle));
        r.events.clear();
    });
}

XrResult XRAPI_CALL begin(XrSession handle, const XrSessionBeginInfo* info)
{
    return answered("xrBeginSession", [&](Runtime& r) {
        SessionObject& session = session_of(handle);
        check_struct(info, XR_TYPE_SESSION_BEGIN_INFO);
        check_view_type(info->primaryViewConfigurationType);
        allowed(session.flow.begin());
        session.order = {};
        if (the_instance().enabled.count("XR_EXT_user_presence") > 0)
            r.post(XrEventDataUserPresenceChangedEXT{XR_TYPE_EVENT_DATA_USER_PRESENCE_CHANGED_EXT,
                                                     nullptr, handle, XR_TRUE});
    });
}

XrResult XRAPI_CALL end(XrSession handle)
{
    return answered("xrEndSession", [&](Runtime&) { allowed(session_of(handle).flow.end()); });
}

XrResult XRAPI_CALL request_exit(XrSession handle)
{
    return answered("xrRequestExitSession",
                    [&](Runtime&) { allowed(session_of(handle).flow.request_exit()); });
}

}  // namespace

void check_view_type(XrViewConfigurationType type)
{
    refuse_if(type != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
              XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED, "not the stereo view");
}

void add_session_functions(Table& to)
{
    to["xrEnumerateViewConfigurations"] = entry(view_types);
    to["xrGetViewConfigurationProperties"] = entry(view_properties);
    to["xrEnumerateViewConfigurationViews"] = entry(views);
    to["xrEnumerateEnvironmentBlendModes"] = entry(blend_modes);
    to["xrGetOpenGLGraphicsRequirementsKHR"] = entry(gl_needs);
    to["xrCreateSession"] = entry(create);
    to["xrDestroySession"] = entry(destroy);
    to["xrBeginSession"] = entry(begin);
    to["xrEndSession"] = entry(end);
    to["xrRequestExitSession"] = entry(request_exit);
}

}  // namespace knead::replay
