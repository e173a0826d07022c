// Kinds of controllers, by the specification's interaction profiles, and what each offers.
#pragma once
#include <string>
#include <vector>

namespace knead::replay {

struct Profile {
    std::string name;                      // "/interaction_profiles/khr/simple_controller"
    std::vector<std::string> users;        // top level paths
    std::vector<std::string> offered;      // below each: "input/select/click"
    std::vector<std::string> left, right;  // below one hand alone

    bool of_hands() const { return users.size() == 2; }
};

// The one that a scripted controller is sooner comes first.
const std::vector<Profile>& profiles();
// Null where it is not known.
const Profile* profile_named(const std::string& name);
// Whether a path is a part of it: "/user/hand/left/input/select/click", or its ".../input/select".
bool offers(const Profile& profile, const std::string& path);
// "/user/hand/left" and its like; "": the path starts with none.
std::string user_of(const std::string& path);

}  // namespace knead::replay
