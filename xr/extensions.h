// The OpenXR extensions in use: one is required, the others are optional.
#pragma once
#include <array>
#include <string>
#include <vector>

namespace knead::xr {

enum Extension : int {
    opengl_enable,
    hand_tracking,
    hand_interaction,
    hand_data_source,
    depth_layer,
    visibility_mask,
    refresh_rate,
    user_presence,
    convert_time,
    debug_messages,
    extension_count
};

struct ExtensionRow {
    const char* name;
    bool needed;
    const char* gives;  // description for users
};
extern const std::array<ExtensionRow, extension_count> extension_table;

// Extensions of the table that are offered, and therefore enabled.
struct Enabled {
    std::array<bool, extension_count> on{};
    bool operator[](Extension e) const { return on[std::size_t(e)]; }
    std::vector<std::string> names() const;
    std::vector<std::string> missing() const;
};
Enabled enabled_of(const std::vector<std::string>& offered);

}  // namespace knead::xr
