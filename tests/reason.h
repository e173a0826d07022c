// What an action is refused with.
#pragma once
#include <string>

namespace knead {

// The text of the error that it throws, empty if there is none; errors of other types pass on.
template <class Error, class Action>
std::string reason(Action&& action)
{
    try {
        action();
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

}  // namespace knead
