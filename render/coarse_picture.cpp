#include "render/coarse_picture.h"

#include <algorithm>
#include <cmath>

#include "render/gl.h"

namespace knead {
namespace {

class GlCoarsePicture final : public CoarsePicture {
  public:
    void paint(EyePainter& painter, const EyeView& view, const EyeLook& look, double scale,
               bool keep) override
    {
        if (scale >= 1 && !keep) return painter.paint(view, look, {});
        EyeView coarse = view;
        coarse.width = std::max(1, int(std::lround(std::min(scale, 1.0) * view.width)));
        coarse.height = std::max(1, int(std::lround(std::min(scale, 1.0) * view.height)));
        resize(view.width, view.height);
        painter.paint(coarse, look, {frame_});
        drawn_ = coarse;
        repeat();
    }

    void repeat() override
    {
        glBlitNamedFramebuffer(frame_, 0, 0, 0, drawn_.width, drawn_.height, 0, 0, width_, height_,
                               GL_COLOR_BUFFER_BIT,
                               drawn_.width == width_ ? GL_NEAREST : GL_LINEAR);
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    }

  private:
    void resize(int width, int height)
    {
        if (width == width_ && height == height_) return;
        colours_ = texture(GL_TEXTURE_2D);
        glTextureStorage2D(colours_, 1, GL_RGBA8, width, height);
        glNamedFramebufferTexture(frame_, GL_COLOR_ATTACHMENT0, colours_, 0);
        width_ = width, height_ = height;
    }

    Framebuffer frame_ = framebuffer();
    Texture colours_;
    int width_ = 0, height_ = 0;
    EyeView drawn_;
};

}  // namespace

std::unique_ptr<CoarsePicture> CoarsePicture::open() { return std::make_unique<GlCoarsePicture>(); }

}  // namespace knead
