// Pictures in a build without OpenGL: none, and the reason.
#ifndef KNEAD_HAS_GL
#include <stdexcept>

#include "render/painter.h"

namespace knead {

std::unique_ptr<Painter> Painter::open()
{
    throw std::runtime_error("no pictures: this build was configured without EGL and OpenGL");
}

}  // namespace knead
#endif
