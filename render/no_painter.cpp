// Builds without OpenGL: opening a painter throws, with the reason.
#ifndef KNEAD_HAS_GL
#include <stdexcept>

#include "render/coarse_picture.h"

namespace knead {

namespace {
constexpr const char* reason = "no pictures: this build was configured without EGL and OpenGL";
}

std::unique_ptr<Painter> Painter::open() { throw std::runtime_error(reason); }
std::unique_ptr<EyePainter> EyePainter::open(int, bool) { throw std::runtime_error(reason); }
std::unique_ptr<CoarsePicture> CoarsePicture::open() { throw std::runtime_error(reason); }
void load_gl(GlAddress) { throw std::runtime_error(reason); }

}  // namespace knead
#endif
