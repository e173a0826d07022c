// Builds without the GLFW headers, Dear ImGui or OpenGL: opening a window throws, with the reason.
#ifndef KNEAD_HAS_WINDOW
#include "host/base/errors.h"
#include "render/view/window.h"

namespace knead {

void Window::wake() {}

std::unique_ptr<Window> Window::open(const std::string&, int, int)
{
    throw ResourceError(
        "no window: this build was configured without GLFW (libglfw3-dev), Dear ImGui "
        "(libimgui-dev) or OpenGL");
}

}  // namespace knead
#endif
