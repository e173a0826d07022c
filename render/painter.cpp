// Pictures by OpenGL: shadow maps of all lamps, then normals, colours and depths, then lighting.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "host/base/errors.h"
#include "render/context.h"
#include "render/geometry.h"
#include "render/gl.h"
#include "render/program.h"
#include "render/shaders.h"

namespace knead {
namespace {

Texture target(GLenum format, int width, int height)
{
    Texture made = texture(GL_TEXTURE_2D);
    glTextureStorage2D(made, 1, format, width, height);
    glTextureParameteri(made, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(made, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    return made;
}

bool is_place(Vec3<float> v) { return std::isfinite(v.x + v.y + v.z); }

void check(const Camera& camera, float floor, int largest_side)
{
    const auto fail = [](const std::string& what) {
        throw std::invalid_argument("camera: " + what);
    };
    if (camera.width < 1 || camera.height < 1 || camera.width > largest_side ||
        camera.height > largest_side) {
        fail("a picture of " + std::to_string(camera.width) + " x " +
             std::to_string(camera.height) + " pixels; expected 1 to " +
             std::to_string(largest_side));
    }
    if (!is_place(camera.eye) || !is_place(camera.target))
        fail("its place or target is not finite");
    if (!(length(camera.target - camera.eye) > 0)) fail("it stands on its target");
    if (!(camera.field > 1e-3f && camera.field < 3.1f)) {
        fail("a field of view of " + std::to_string(camera.field) + " rad; expected 0.001 to 3.1");
    }
    if (!(camera.hands >= 0 && camera.hands <= 1)) {
        fail("hands of opacity " + std::to_string(camera.hands) + "; expected 0 to 1");
    }
    if (!std::isfinite(floor)) throw std::invalid_argument("the height of the floor is not finite");
}

class GlPainter final : public Painter {
  public:
    GlPainter() : bound_(std::make_unique<Context::Bound>(context_)) { build(), bound_.reset(); }
    ~GlPainter() override { bound_ = std::make_unique<Context::Bound>(context_); }

    Image paint(const std::vector<Mesh>& meshes, const std::vector<HandLook>& looks,
                const Camera& camera, float floor, const std::vector<Mesh>& unseen) override
    {
        check(camera, floor, largest_side_);
        near_ = 1e-3f * length(camera.target - camera.eye);
        const bool hands = camera.hands > 0 && !looks.empty();
        const Geometry geometry = gather(meshes, hands ? looks : std::vector<HandLook>{}, unseen);
        const Context::Bound bound(context_);
        resize(camera.width, camera.height);
        upload(geometry);
        aim(geometry, camera, floor);
        cast_shadows(geometry.casting);
        if (hands && camera.hands < 1) {
            see(geometry, false);
            light(1);
        }
        see(geometry, true);
        light(hands ? camera.hands : 1);
        return developed();
    }

    std::vector<float> depths() override;
    std::string name() const override { return context_.name(); }
    int largest_side() const override { return largest_side_; }

  private:
    void build();
    void resize(int width, int height);
    void upload(const Geometry& geometry);
    void aim(const Geometry& geometry, const Camera& camera, float floor);
    void cast_shadows(const std::vector<Range>& ranges);
    void see(const Geometry& geometry, bool hands);
    void light(float opacity);
    Image developed();
    void draw(Range range) const;

    // Members between these are freed while the context is current.
    Context context_;
    std::unique_ptr<Context::Bound> bound_;
    Program shadow_, scene_, light_, tone_;
    Texture key_maps_, dome_maps_, normals_, colours_, depths_, radiances_, picture_;
    Framebuffer shadow_frame_, scene_frame_, light_frame_, picture_frame_;
    Buffer vertices_, triangles_, lamps_, view_;
    VertexArray layout_;
    int width_ = 0, height_ = 0;  // pixels
    float near_ = 0;              // [m]
    int largest_side_ = 0;        // of a picture
};

// Largest side of a square render target [pixels].
int largest_picture()
{
    GLint texture = 0, view[2] = {0, 0};
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &texture);
    glGetIntegerv(GL_MAX_VIEWPORT_DIMS, view);
    return std::min({texture, view[0], view[1]}) / samples_across;
}

void GlPainter::build()
{
    largest_side_ = largest_picture();
    const std::string head = still_constants();
    shadow_ = program({head, common, shadow_vertex}, {head, shadow_fragment}, "shadow");
    scene_ = program({head, common, scene_vertex}, {head, scene_fragment}, "scene");
    light_ =
        program({head, screen_vertex}, {head, common, shading, ground, light_fragment}, "light");
    tone_ = program({head, screen_vertex}, {head, tones, tone_fragment}, "tone");
    key_maps_ = shadow_maps(key_map_side, key_lamps);
    dome_maps_ = shadow_maps(dome_map_side, dome_lamps);
    shadow_frame_ = framebuffer();
    glNamedFramebufferDrawBuffer(shadow_frame_, GL_NONE);
    scene_frame_ = framebuffer();
    const GLenum both[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    glNamedFramebufferDrawBuffers(scene_frame_, 2, both);
    light_frame_ = framebuffer();
    picture_frame_ = framebuffer();
    vertices_ = buffer();
    triangles_ = buffer();
    lamps_ = buffer();
    glNamedBufferStorage(lamps_, sizeof(Lamps), nullptr, GL_DYNAMIC_STORAGE_BIT);
    view_ = buffer();
    glNamedBufferStorage(view_, sizeof(ViewBlock), nullptr, GL_DYNAMIC_STORAGE_BIT);
    layout_ = paint_layout(vertices_, triangles_);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
}

void GlPainter::resize(int width, int height)
{
    if (width == width_ && height == height_) return;
    width_ = height_ = 0;
    normals_ = {}, colours_ = {}, depths_ = {}, radiances_ = {}, picture_ = {};
    const int w = samples_across * width, h = samples_across * height;
    normals_ = target(GL_RGBA16F, w, h);
    colours_ = target(GL_RGBA16F, w, h);
    depths_ = target(GL_DEPTH_COMPONENT32F, w, h);
    radiances_ = target(GL_RGBA16F, w, h);
    picture_ = target(GL_RGBA8, width, height);
    glNamedFramebufferTexture(scene_frame_, GL_COLOR_ATTACHMENT0, normals_, 0);
    glNamedFramebufferTexture(scene_frame_, GL_COLOR_ATTACHMENT1, colours_, 0);
    glNamedFramebufferTexture(scene_frame_, GL_DEPTH_ATTACHMENT, depths_, 0);
    glNamedFramebufferTexture(light_frame_, GL_COLOR_ATTACHMENT0, radiances_, 0);
    glNamedFramebufferTexture(picture_frame_, GL_COLOR_ATTACHMENT0, picture_, 0);
    // Each texture that does not fit raises its own error: read all of them.
    bool fits = true;
    while (glGetError() != GL_NO_ERROR) fits = false;
    for (const GLuint frame : {GLuint(scene_frame_), GLuint(light_frame_), GLuint(picture_frame_)})
        fits = fits &&
               glCheckNamedFramebufferStatus(frame, GL_DRAW_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    if (!fits) {
        normals_ = {}, colours_ = {}, depths_ = {}, radiances_ = {}, picture_ = {};
        throw PictureError("no room for a picture of " + std::to_string(width) + " x " +
                           std::to_string(height) + " pixels on " + context_.name());
    }
    width_ = width;
    height_ = height;
}

void GlPainter::upload(const Geometry& geometry)
{
    glNamedBufferData(vertices_, GLsizeiptr(geometry.vertices.size() * sizeof(PaintVertex)),
                      geometry.vertices.data(), GL_STREAM_DRAW);
    glNamedBufferData(triangles_, GLsizeiptr(geometry.triangles.size() * sizeof(Int3)),
                      geometry.triangles.data(), GL_STREAM_DRAW);
}

// The key light moves with the camera, from its upper left, so that visible dents are lit from the
// side.
void GlPainter::aim(const Geometry& geometry, const Camera& camera, float floor)
{
    const Vec3<float> gaze = camera.target - camera.eye;
    const float distance = length(gaze);
    const Vec3<float> forward = (1 / distance) * gaze;
    const Vec3<float> level{-forward.z, 0, forward.x};
    const Vec3<float> right =
        length(level) > 1e-4f ? (1 / length(level)) * level : Vec3<float>{1, 0, 0};
    const Vec3<float> up = cross(right, forward);
    const float tangent = std::tan(camera.field / 2);
    const float wide = tangent * float(camera.width) / float(camera.height);
    const Vec3<float> near = cross(right, Vec3<float>{0, 1, 0});  // level, towards the camera
    const Vec3<float> key = Vec3<float>{0, 0.95f, 0} - 0.95f * right + 0.35f * near;
    const Ball ball = around(geometry, camera.target, 1.5f * distance);
    const Lamps all = lamps_about(ball, (1 / length(key)) * key, 0.06f);
    ViewBlock view{};
    put(view.eye, camera.eye, near_);
    put(view.right, wide * right, 1 / wide);
    put(view.up, tangent * up, 1 / tangent);
    put(view.forward, forward, floor);
    put(view.ball, ball.centre, ball.radius);
    put(view.sky, right - 0.5f * forward, 0);
    put(view.scale, {line_spacing(distance), 4 * distance, 2 * tangent / float(camera.height)}, 0);
    glNamedBufferSubData(lamps_, 0, sizeof all, all.data());
    glNamedBufferSubData(view_, 0, sizeof view, &view);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, lamps_);
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, view_);
}

void GlPainter::draw(Range range) const
{
    if (range.count == 0) return;
    glDrawElements(GL_TRIANGLES, 3 * range.count, GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>(std::size_t(range.first) * sizeof(Int3)));
}

void GlPainter::cast_shadows(const std::vector<Range>& ranges)
{
    glUseProgram(shadow_);
    glBindVertexArray(layout_);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, shadow_frame_);
    glEnable(GL_DEPTH_TEST);
    glEnable(GL_DEPTH_CLAMP);
    glEnable(GL_CULL_FACE);
    glDepthFunc(GL_LESS);
    for (int i = 0; i < lamps; ++i) {
        const bool key = i < key_lamps;
        const int side = key ? key_map_side : dome_map_side;
        glNamedFramebufferTextureLayer(shadow_frame_, GL_DEPTH_ATTACHMENT,
                                       key ? key_maps_ : dome_maps_, 0, key ? i : i - key_lamps);
        glViewport(0, 0, side, side);
        const float far = 1;
        glClearNamedFramebufferfv(shadow_frame_, GL_DEPTH, 0, &far);
        glUniform1i(0, i);
        for (const Range& range : ranges) draw(range);
    }
    glDisable(GL_DEPTH_CLAMP);
    glDisable(GL_CULL_FACE);
}

void GlPainter::see(const Geometry& geometry, bool hands)
{
    glUseProgram(scene_);
    glBindVertexArray(layout_);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, scene_frame_);
    glViewport(0, 0, samples_across * width_, samples_across * height_);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    const float zero[4] = {0, 0, 0, 0};
    glClearNamedFramebufferfv(scene_frame_, GL_COLOR, 0, zero);
    glClearNamedFramebufferfv(scene_frame_, GL_COLOR, 1, zero);
    glClearNamedFramebufferfv(scene_frame_, GL_DEPTH, 0, zero);
    draw(geometry.clay);
    if (hands)
        for (const Range& range : geometry.seen) draw(range);
    glDisable(GL_DEPTH_TEST);
}

void GlPainter::light(float opacity)
{
    glUseProgram(light_);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, light_frame_);
    const GLuint sources[] = {normals_, colours_, depths_, key_maps_, dome_maps_};
    glBindTextures(0, 5, sources);
    glUniform2f(0, float(samples_across * width_), float(samples_across * height_));
    if (opacity < 1) {
        glEnable(GL_BLEND);
        glBlendColor(0, 0, 0, opacity);
        glBlendFunc(GL_CONSTANT_ALPHA, GL_ONE_MINUS_CONSTANT_ALPHA);
    }
    // Lighting takes most of the time, so it is drawn in bands of at most this many samples: 0.1 s
    // or less in software OpenGL.
    constexpr int samples_at_a_time = 1 << 18;
    const int across = samples_across * width_, rows = samples_across * height_;
    const int band = std::max(1, samples_at_a_time / across);
    glEnable(GL_SCISSOR_TEST);
    bool stopped = false;
    for (int low = 0; low < rows && !stopped; low += band) {
        glScissor(0, low, across, band);
        glDrawArrays(GL_TRIANGLES, 0, 3);
        glFinish();
        stopped = given_up();
    }
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_BLEND);
    if (stopped) throw PictureError("given up");
}

Image GlPainter::developed()
{
    glUseProgram(tone_);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, picture_frame_);
    glViewport(0, 0, width_, height_);
    glBindTextureUnit(0, radiances_);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, picture_frame_);
    const std::size_t row = std::size_t(3) * std::size_t(width_);
    std::vector<std::uint8_t> upside_down(row * std::size_t(height_));
    glReadPixels(0, 0, width_, height_, GL_RGB, GL_UNSIGNED_BYTE, upside_down.data());
    if (const GLenum error = glGetError()) {
        throw PictureError(std::string("painting on ") + context_.name() + ": " +
                           (error == GL_OUT_OF_MEMORY ? "out of memory"
                                                      : "OpenGL error " + std::to_string(error)));
    }
    Image image{width_, height_, std::vector<std::uint8_t>(upside_down.size())};
    for (int y = 0; y < height_; ++y) {
        std::copy_n(upside_down.begin() + std::ptrdiff_t(row) * (height_ - 1 - y), row,
                    image.rgb.begin() + std::ptrdiff_t(row) * y);
    }
    return image;
}

// The nearest of each pixel's samples.
std::vector<float> GlPainter::depths()
{
    const Context::Bound bound(context_);
    const int across = samples_across * width_, rows = samples_across * height_;
    std::vector<float> samples(std::size_t(across) * std::size_t(rows));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, scene_frame_);
    glReadPixels(0, 0, across, rows, GL_DEPTH_COMPONENT, GL_FLOAT, samples.data());
    if (const GLenum error = glGetError())
        throw PictureError(std::string("reading depths on ") + context_.name() + ": OpenGL error " +
                           std::to_string(error));
    std::vector<float> nearest(std::size_t(width_) * std::size_t(height_));
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < across; ++x) {
            const int pixel = (height_ - 1 - y / samples_across) * width_ + x / samples_across;
            float& to = nearest[std::size_t(pixel)];
            to = max(to, samples[std::size_t(y) * std::size_t(across) + std::size_t(x)]);
        }
    for (float& d : nearest) d = near_ / d;
    return nearest;
}

}  // namespace

std::unique_ptr<Painter> Painter::open() { return std::make_unique<GlPainter>(); }

}  // namespace knead
