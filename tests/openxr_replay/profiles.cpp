#include "tests/openxr_replay/profiles.h"

#include <algorithm>

namespace knead::replay {
namespace {

using Names = std::vector<std::string>;

const Names both_hands{"/user/hand/left", "/user/hand/right"};
const Names poses{"input/grip/pose", "input/aim/pose"};
const Names motor{"output/haptic"};
const Names trackpad{"input/trackpad", "input/trackpad/x", "input/trackpad/y",
                     "input/trackpad/touch"};
const Names pressed_trackpad{"input/trackpad/click"};
const Names thumbstick{"input/thumbstick", "input/thumbstick/x", "input/thumbstick/y",
                       "input/thumbstick/click"};

Names joined(const std::vector<Names>& all)
{
    Names made;
    for (const Names& some : all) made.insert(made.end(), some.begin(), some.end());
    return made;
}

Profile touch()
{
    return {
        "/interaction_profiles/oculus/touch_controller",
        both_hands,
        joined({poses,
                motor,
                thumbstick,
                {"input/squeeze/value", "input/trigger/value", "input/trigger/touch",
                 "input/thumbstick/touch", "input/thumbrest/touch"}}),
        {"input/x/click", "input/x/touch", "input/y/click", "input/y/touch", "input/menu/click"},
        {"input/a/click", "input/a/touch", "input/b/click", "input/b/touch", "input/system/click"}};
}

Profile index()
{
    return {"/interaction_profiles/valve/index_controller",
            both_hands,
            joined({poses,
                    motor,
                    thumbstick,
                    trackpad,
                    {"input/system/click", "input/system/touch", "input/a/click", "input/a/touch",
                     "input/b/click", "input/b/touch", "input/squeeze/value", "input/squeeze/force",
                     "input/trigger/click", "input/trigger/value", "input/trigger/touch",
                     "input/thumbstick/touch", "input/trackpad/force"}}),
            {},
            {}};
}

Profile vive()
{
    return {"/interaction_profiles/htc/vive_controller",
            both_hands,
            joined({poses,
                    motor,
                    trackpad,
                    pressed_trackpad,
                    {"input/system/click", "input/squeeze/click", "input/menu/click",
                     "input/trigger/click", "input/trigger/value"}}),
            {},
            {}};
}

Profile motion()
{
    return {"/interaction_profiles/microsoft/motion_controller",
            both_hands,
            joined({poses,
                    motor,
                    trackpad,
                    pressed_trackpad,
                    thumbstick,
                    {"input/menu/click", "input/squeeze/click", "input/trigger/value"}}),
            {},
            {}};
}

Profile go()
{
    return {"/interaction_profiles/oculus/go_controller",
            both_hands,
            joined({poses,
                    trackpad,
                    pressed_trackpad,
                    {"input/system/click", "input/trigger/click", "input/back/click"}}),
            {},
            {}};
}

Profile daydream()
{
    return {"/interaction_profiles/google/daydream_controller",
            both_hands,
            joined({poses, trackpad, pressed_trackpad, {"input/select/click"}}),
            {},
            {}};
}

Profile simple()
{
    return {"/interaction_profiles/khr/simple_controller",
            both_hands,
            joined({poses, motor, {"input/select/click", "input/menu/click"}}),
            {},
            {}};
}

// Of XR_EXT_hand_interaction.
Profile hands()
{
    return {"/interaction_profiles/ext/hand_interaction_ext",
            both_hands,
            joined({poses,
                    {"input/pinch_ext/pose", "input/poke_ext/pose", "input/pinch_ext/value",
                     "input/pinch_ext/ready_ext", "input/aim_activate_ext/value",
                     "input/aim_activate_ext/ready_ext", "input/grasp_ext/value",
                     "input/grasp_ext/ready_ext"}}),
            {},
            {}};
}

Profile head()
{
    return {"/interaction_profiles/htc/vive_pro",
            {"/user/head"},
            {"input/system/click", "input/volume_up/click", "input/volume_down/click",
             "input/mute_mic/click"},
            {},
            {}};
}

Profile gamepad()
{
    Names all{"output/haptic_left", "output/haptic_right", "output/haptic_left_trigger",
              "output/haptic_right_trigger"};
    for (const char* button :
         {"menu", "view", "a", "b", "x", "y", "dpad_down", "dpad_right", "dpad_up", "dpad_left",
          "shoulder_left", "shoulder_right", "thumbstick_left", "thumbstick_right"})
        all.push_back(std::string("input/") + button + "/click");
    for (const char* side : {"left", "right"}) {
        const std::string stick = std::string("input/thumbstick_") + side;
        all.insert(all.end(), {stick, stick + "/x", stick + "/y",
                               std::string("input/trigger_") + side + "/value"});
    }
    return {"/interaction_profiles/microsoft/xbox_controller", {"/user/gamepad"}, all, {}, {}};
}

// Whether it is among them, or one of them without its last part.
bool among(const Names& all, const std::string& one)
{
    return one.find('/') != one.npos && std::any_of(all.begin(), all.end(), [&](const auto& name) {
               return name == one || name.starts_with(one + "/");
           });
}

}  // namespace

const std::vector<Profile>& profiles()
{
    static const std::vector<Profile> all{touch(),    index(),  vive(),  motion(), go(),
                                          daydream(), simple(), hands(), head(),   gamepad()};
    return all;
}

const Profile* profile_named(const std::string& name)
{
    for (const Profile& one : profiles())
        if (one.name == name) return &one;
    return nullptr;
}

std::string user_of(const std::string& path)
{
    for (const char* user :
         {"/user/hand/left", "/user/hand/right", "/user/head", "/user/gamepad", "/user/treadmill"})
        if (path == user || path.starts_with(std::string(user) + "/")) return user;
    return {};
}

bool offers(const Profile& profile, const std::string& path)
{
    const std::string user = user_of(path);
    if (std::find(profile.users.begin(), profile.users.end(), user) == profile.users.end() ||
        path.size() <= user.size())
        return false;
    const std::string below = path.substr(user.size() + 1);
    return among(profile.offered, below) ||
           among(user == "/user/hand/left" ? profile.left : profile.right, below);
}

}  // namespace knead::replay
