// What the files of actions and spaces know of each other.
#pragma once
#include "tests/openxr_replay/runtime.h"

namespace knead::replay {

// Refuses a path that is none, or that the action was not made for. Null stands for any.
void check_subaction(const ActionObject& action, XrPath of);
// The attached action of a call; refuses one of a set that is not attached.
const ActionObject& attached_action(const SessionObject& session, XrAction handle);
// What is bound to an action now, below one top level path, or, of "", below all.
std::vector<std::string> sources_of(const SessionObject& session, XrAction handle,
                                    const std::string& user);
// The controller whose pose an action space is; null where the action is not active.
const Controller* pointed_by(const SpaceObject& space, double time);

}  // namespace knead::replay
