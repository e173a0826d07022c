// Names of results and structs, as their functions answer them.
#include <openxr/openxr_reflection.h>

#include "tests/openxr_replay/runtime.h"

namespace knead::replay {
namespace {

std::string name_of(XrResult value)
{
#define KNEAD_PAIR(name, number) {number, #name},
    static const std::map<int, const char*> known{
        XR_LIST_ENUM_XrResult(KNEAD_PAIR)
        // Newer than the headers.
        {-1000429000, "XR_ERROR_SPACE_NOT_LOCATABLE_EXT"},
        {-1000429001, "XR_ERROR_PLANE_DETECTION_PERMISSION_DENIED_EXT"},
    };
    const auto found = known.find(int(value));
    if (found != known.end()) return found->second;
    return (value < 0 ? "XR_UNKNOWN_FAILURE_" : "XR_UNKNOWN_SUCCESS_") + std::to_string(int(value));
}

std::string name_of(XrStructureType value)
{
    static const std::map<int, const char*> known{
        XR_LIST_ENUM_XrStructureType(KNEAD_PAIR)
        // Newer than the headers.
        {XR_TYPE_HAND_TRACKING_DATA_SOURCE_INFO_EXT, "XR_TYPE_HAND_TRACKING_DATA_SOURCE_INFO_EXT"},
        {XR_TYPE_HAND_TRACKING_DATA_SOURCE_STATE_EXT,
         "XR_TYPE_HAND_TRACKING_DATA_SOURCE_STATE_EXT"},
        {XR_TYPE_EVENT_DATA_USER_PRESENCE_CHANGED_EXT,
         "XR_TYPE_EVENT_DATA_USER_PRESENCE_CHANGED_EXT"},
        {XR_TYPE_SYSTEM_USER_PRESENCE_PROPERTIES_EXT,
         "XR_TYPE_SYSTEM_USER_PRESENCE_PROPERTIES_EXT"},
        {1000049001, "XR_TYPE_SPATIAL_GRAPH_STATIC_NODE_BINDING_CREATE_INFO_MSFT"},
        {1000049002, "XR_TYPE_SPATIAL_GRAPH_NODE_BINDING_PROPERTIES_GET_INFO_MSFT"},
        {1000049003, "XR_TYPE_SPATIAL_GRAPH_NODE_BINDING_PROPERTIES_MSFT"},
        {1000429001, "XR_TYPE_PLANE_DETECTOR_CREATE_INFO_EXT"},
        {1000429002, "XR_TYPE_PLANE_DETECTOR_BEGIN_INFO_EXT"},
        {1000429003, "XR_TYPE_PLANE_DETECTOR_GET_INFO_EXT"},
        {1000429004, "XR_TYPE_PLANE_DETECTOR_LOCATIONS_EXT"},
        {1000429005, "XR_TYPE_PLANE_DETECTOR_LOCATION_EXT"},
        {1000429006, "XR_TYPE_PLANE_DETECTOR_POLYGON_BUFFER_EXT"},
        {1000429007, "XR_TYPE_SYSTEM_PLANE_DETECTION_PROPERTIES_EXT"},
    };
#undef KNEAD_PAIR
    const auto found = known.find(int(value));
    if (found != known.end()) return found->second;
    return "XR_UNKNOWN_STRUCTURE_TYPE_" + std::to_string(int(value));
}

XrResult XRAPI_CALL result_text(XrInstance handle, XrResult value, char* to)
{
    return answered("xrResultToString", [&](Runtime&) {
        instance_of(handle);
        refuse_if(!to, XR_ERROR_VALIDATION_FAILURE, "no place for the name");
        std::snprintf(to, XR_MAX_RESULT_STRING_SIZE, "%s", name_of(value).c_str());
    });
}

XrResult XRAPI_CALL type_text(XrInstance handle, XrStructureType value, char* to)
{
    return answered("xrStructureTypeToString", [&](Runtime&) {
        instance_of(handle);
        refuse_if(!to, XR_ERROR_VALIDATION_FAILURE, "no place for the name");
        std::snprintf(to, XR_MAX_STRUCTURE_NAME_SIZE, "%s", name_of(value).c_str());
    });
}

}  // namespace

void add_name_functions(Table& to)
{
    to["xrResultToString"] = entry(result_text);
    to["xrStructureTypeToString"] = entry(type_text);
}

}  // namespace knead::replay
