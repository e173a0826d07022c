// The OpenXR headers, and declarations missing from those of Debian 12 (1.0.20). Functions are
// loaded at run time; no library is linked.
#pragma once
#define XR_NO_PROTOTYPES
#define XR_USE_GRAPHICS_API_OPENGL
#ifndef _WIN32
#include <time.h>
#define XR_USE_TIMESPEC
#endif
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <cstdint>

// Values from the registry of OpenXR 1.1.
#ifndef XR_EXT_hand_tracking_data_source
enum XrHandTrackingDataSourceEXT : std::int32_t {
    XR_HAND_TRACKING_DATA_SOURCE_UNOBSTRUCTED_EXT = 1,
    XR_HAND_TRACKING_DATA_SOURCE_CONTROLLER_EXT = 2
};
constexpr auto XR_TYPE_HAND_TRACKING_DATA_SOURCE_INFO_EXT = XrStructureType(1000428000);
constexpr auto XR_TYPE_HAND_TRACKING_DATA_SOURCE_STATE_EXT = XrStructureType(1000428001);
struct XrHandTrackingDataSourceInfoEXT {
    XrStructureType type;
    const void* next;
    std::uint32_t requestedDataSourceCount;
    XrHandTrackingDataSourceEXT* requestedDataSources;
};
struct XrHandTrackingDataSourceStateEXT {
    XrStructureType type;
    void* next;
    XrBool32 isActive;
    XrHandTrackingDataSourceEXT dataSource;
};
#endif
#ifndef XR_EXT_user_presence
constexpr auto XR_TYPE_EVENT_DATA_USER_PRESENCE_CHANGED_EXT = XrStructureType(1000470000);
constexpr auto XR_TYPE_SYSTEM_USER_PRESENCE_PROPERTIES_EXT = XrStructureType(1000470001);
struct XrEventDataUserPresenceChangedEXT {
    XrStructureType type;
    const void* next;
    XrSession session;
    XrBool32 isUserPresent;
};
#endif
