// GLFW functions, loaded when the first window is opened: not needed without a screen.
#pragma once
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace knead {

struct Glfw {
    decltype(&glfwInit) init;
    decltype(&glfwGetError) error;
    decltype(&glfwWindowHint) hint;
    decltype(&glfwCreateWindow) create;
    decltype(&glfwDestroyWindow) destroy;
    decltype(&glfwMakeContextCurrent) make_current;
    decltype(&glfwGetProcAddress) address;
    decltype(&glfwSwapInterval) swap_interval;
    decltype(&glfwSwapBuffers) swap;
    decltype(&glfwPollEvents) poll;
    decltype(&glfwWaitEventsTimeout) wait;
    decltype(&glfwPostEmptyEvent) wake;
    decltype(&glfwGetWindowAttrib) attribute;
    decltype(&glfwSetWindowShouldClose) set_should_close;
    decltype(&glfwSetWindowTitle) set_title;
    decltype(&glfwGetWindowContentScale) content_scale;
    decltype(&glfwGetClipboardString) clipboard;
    decltype(&glfwSetClipboardString) set_clipboard;
    decltype(&glfwGetFramebufferSize) framebuffer_size;
    decltype(&glfwGetWindowSize) window_size;
    decltype(&glfwSetWindowUserPointer) set_user;
    decltype(&glfwGetWindowUserPointer) user;
    decltype(&glfwGetKeyName) key_name;
    decltype(&glfwSetKeyCallback) on_key;
    decltype(&glfwSetCharCallback) on_text;
    decltype(&glfwSetCursorPosCallback) on_move;
    decltype(&glfwSetMouseButtonCallback) on_button;
    decltype(&glfwSetScrollCallback) on_wheel;
    decltype(&glfwSetWindowRefreshCallback) on_refresh;
    decltype(&glfwSetFramebufferSizeCallback) on_size;
    decltype(&glfwSetWindowIconifyCallback) on_iconify;
    decltype(&glfwSetWindowContentScaleCallback) on_content_scale;
    decltype(&glfwSetWindowCloseCallback) on_close;
    decltype(&glfwSetWindowFocusCallback) on_focus;
    decltype(&glfwSetCursorEnterCallback) on_enter;
    decltype(&glfwSetDropCallback) on_drop;
};

// Throws ResourceError if there is no GLFW 3.3 or no screen.
const Glfw& glfw();

}  // namespace knead
