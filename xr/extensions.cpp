#include "xr/extensions.h"

#include <algorithm>

namespace knead::xr {

// Only OpenGL is required. Without hand tracking, controllers pose the hands.
const std::array<ExtensionRow, extension_count> extension_table{{
    {"XR_KHR_opengl_enable", true, "pictures by OpenGL"},
    {"XR_EXT_hand_tracking", false, "hands without controllers"},
    {"XR_EXT_hand_interaction", false, "pinch and grasp as the runtime sees them"},
    {"XR_EXT_hand_tracking_data_source", false, "whether cameras see the hand"},
    {"XR_KHR_composition_layer_depth", false, "steadier pictures in motion, by depth"},
    {"XR_KHR_visibility_mask", false, "no work for pixels that no lens shows"},
    {"XR_FB_display_refresh_rate", false, "the display's rate"},
    {"XR_EXT_user_presence", false, "whether the headset is worn"},
    {"XR_KHR_convert_timespec_time", false, "how much time a frame has left"},
    {"XR_EXT_debug_utils", false, "messages of runtime and layers"},
}};

std::vector<std::string> Enabled::names() const
{
    std::vector<std::string> all;
    for (std::size_t i = 0; i < on.size(); ++i)
        if (on[i]) all.push_back(extension_table[i].name);
    return all;
}

std::vector<std::string> Enabled::missing() const
{
    std::vector<std::string> all;
    for (std::size_t i = 0; i < on.size(); ++i)
        if (!on[i]) all.push_back(extension_table[i].name);
    return all;
}

Enabled enabled_of(const std::vector<std::string>& offered)
{
    Enabled enabled;
    for (std::size_t i = 0; i < enabled.on.size(); ++i)
        enabled.on[i] =
            std::find(offered.begin(), offered.end(), extension_table[i].name) != offered.end();
    return enabled;
}

}  // namespace knead::xr
