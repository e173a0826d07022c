// The OpenXR functions in use, each loaded at its first call.
#pragma once
#include "xr/check.h"

namespace knead::xr {

struct Api : Source {
    explicit Api(const Source& from) : Source(from) {}

    Call<PFN_xrEnumerateInstanceExtensionProperties> extensions{
        *this, "xrEnumerateInstanceExtensionProperties"};
    Call<PFN_xrCreateInstance> create_instance{*this, "xrCreateInstance"};
    Call<PFN_xrDestroyInstance> destroy_instance{*this, "xrDestroyInstance"};
    Call<PFN_xrGetInstanceProperties> instance_properties{*this, "xrGetInstanceProperties"};
    Call<PFN_xrPollEvent> poll_event{*this, "xrPollEvent"};
    Call<PFN_xrStringToPath> path{*this, "xrStringToPath"};
    Call<PFN_xrGetSystem> system{*this, "xrGetSystem"};
    Call<PFN_xrGetSystemProperties> system_properties{*this, "xrGetSystemProperties"};
    Call<PFN_xrEnumerateEnvironmentBlendModes> blend_modes{*this,
                                                           "xrEnumerateEnvironmentBlendModes"};
    Call<PFN_xrEnumerateViewConfigurationViews> views{*this, "xrEnumerateViewConfigurationViews"};
    Call<PFN_xrGetOpenGLGraphicsRequirementsKHR> gl_requirements{
        *this, "xrGetOpenGLGraphicsRequirementsKHR"};

    Call<PFN_xrCreateSession> create_session{*this, "xrCreateSession"};
    Call<PFN_xrDestroySession> destroy_session{*this, "xrDestroySession"};
    Call<PFN_xrBeginSession> begin_session{*this, "xrBeginSession"};
    Call<PFN_xrEndSession> end_session{*this, "xrEndSession"};
    Call<PFN_xrRequestExitSession> request_exit{*this, "xrRequestExitSession"};
    Call<PFN_xrEnumerateReferenceSpaces> reference_spaces{*this, "xrEnumerateReferenceSpaces"};
    Call<PFN_xrCreateReferenceSpace> create_reference_space{*this, "xrCreateReferenceSpace"};
    Call<PFN_xrCreateActionSpace> create_action_space{*this, "xrCreateActionSpace"};
    Call<PFN_xrLocateSpace> locate_space{*this, "xrLocateSpace"};
    Call<PFN_xrDestroySpace> destroy_space{*this, "xrDestroySpace"};

    Call<PFN_xrEnumerateSwapchainFormats> formats{*this, "xrEnumerateSwapchainFormats"};
    Call<PFN_xrCreateSwapchain> create_swapchain{*this, "xrCreateSwapchain"};
    Call<PFN_xrDestroySwapchain> destroy_swapchain{*this, "xrDestroySwapchain"};
    Call<PFN_xrEnumerateSwapchainImages> images{*this, "xrEnumerateSwapchainImages"};
    Call<PFN_xrAcquireSwapchainImage> acquire_image{*this, "xrAcquireSwapchainImage"};
    Call<PFN_xrWaitSwapchainImage> wait_image{*this, "xrWaitSwapchainImage"};
    Call<PFN_xrReleaseSwapchainImage> release_image{*this, "xrReleaseSwapchainImage"};

    Call<PFN_xrWaitFrame> wait_frame{*this, "xrWaitFrame"};
    Call<PFN_xrBeginFrame> begin_frame{*this, "xrBeginFrame"};
    Call<PFN_xrEndFrame> end_frame{*this, "xrEndFrame"};
    Call<PFN_xrLocateViews> locate_views{*this, "xrLocateViews"};

    Call<PFN_xrCreateActionSet> create_action_set{*this, "xrCreateActionSet"};
    Call<PFN_xrDestroyActionSet> destroy_action_set{*this, "xrDestroyActionSet"};
    Call<PFN_xrCreateAction> create_action{*this, "xrCreateAction"};
    Call<PFN_xrSuggestInteractionProfileBindings> suggest_bindings{
        *this, "xrSuggestInteractionProfileBindings"};
    Call<PFN_xrAttachSessionActionSets> attach_action_sets{*this, "xrAttachSessionActionSets"};
    Call<PFN_xrSyncActions> sync_actions{*this, "xrSyncActions"};
    Call<PFN_xrGetActionStateFloat> float_state{*this, "xrGetActionStateFloat"};
    Call<PFN_xrGetActionStatePose> pose_state{*this, "xrGetActionStatePose"};
    Call<PFN_xrApplyHapticFeedback> vibrate{*this, "xrApplyHapticFeedback"};

    // Extension functions. Precondition: the extension is enabled.
    Call<PFN_xrCreateHandTrackerEXT> create_hand_tracker{*this, "xrCreateHandTrackerEXT"};
    Call<PFN_xrDestroyHandTrackerEXT> destroy_hand_tracker{*this, "xrDestroyHandTrackerEXT"};
    Call<PFN_xrLocateHandJointsEXT> locate_hand{*this, "xrLocateHandJointsEXT"};
    Call<PFN_xrGetVisibilityMaskKHR> visibility_mask{*this, "xrGetVisibilityMaskKHR"};
    Call<PFN_xrEnumerateDisplayRefreshRatesFB> refresh_rates{*this,
                                                             "xrEnumerateDisplayRefreshRatesFB"};
    Call<PFN_xrGetDisplayRefreshRateFB> refresh_rate{*this, "xrGetDisplayRefreshRateFB"};
    Call<PFN_xrRequestDisplayRefreshRateFB> request_refresh_rate{*this,
                                                                 "xrRequestDisplayRefreshRateFB"};
    Call<PFN_xrCreateDebugUtilsMessengerEXT> create_messenger{*this,
                                                              "xrCreateDebugUtilsMessengerEXT"};
    Call<PFN_xrDestroyDebugUtilsMessengerEXT> destroy_messenger{*this,
                                                                "xrDestroyDebugUtilsMessengerEXT"};
#ifndef _WIN32
    Call<PFN_xrConvertTimeToTimespecTimeKHR> to_timespec{*this, "xrConvertTimeToTimespecTimeKHR"};
#endif
};

}  // namespace knead::xr
