// A live picture: shadow maps if something moved, a multisampled picture of the eye, resolved into
// the caller's framebuffer.
#include "render/eye_painter.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "host/base/errors.h"
#include "render/eye_clay.h"
#include "render/eye_shaders.h"
#include "render/eye_splats.h"
#include "render/gl_state.h"
#include "render/program.h"

namespace knead {
namespace {

// Clay beyond this distance is ignored, so that a stray vertex does not spoil the shadows [m].
constexpr float farthest = 1e4f;
constexpr Vec3<float> selected_glow{0.35f, 0.62f, 1};

void set_glow(Vec3<float> of) { glUniform3f(2, of.x, of.y, of.z); }

void check(const EyeView& view, const EyeLook& look)
{
    const Vec3<float> l = look.light;
    const Ball s = look.stage;
    if (!valid(splat_eye(view)) || !(view.near > 0 && view.near < farthest))
        throw std::invalid_argument("an eye whose pose, sides, near distance or size has no sense");
    if (!std::isfinite(look.floor) || !std::isfinite(look.extrapolation) ||
        !(length(l) > 0 && length(l) < 1e9f) ||
        !(length(s.centre) < farthest && s.radius > 0 && s.radius < farthest))
        throw std::invalid_argument("a floor, light or stage that is not finite");
}

class GlEyePainter final : public EyePainter {
  public:
    GlEyePainter(int samples, bool share);
    const Sharing& sharing(int device) override { return sharings_.with(device); }
    void set_clay(const std::vector<Mesh>& meshes, long version, const std::vector<int>& unseen,
                  const std::vector<int>& hidden, const ClayColours& colours) override;
    void set_device_clay(const DeviceMesh& mesh, long version, const std::vector<int>& unseen,
                         const std::vector<int>& hidden, const ClayColours& colours) override;
    bool is_shown(long version, const std::vector<int>& hidden, const ClayColours& colours) const
    {
        return any_clay_ && version == version_ && hidden == hidden_clay_ &&
               colours.version == colours_version_;
    }
    void set_hands(const std::vector<HandLook>& hands) override;
    void set_splats(int eye, const SplatLayer& layer) override { splats_.upload(eye, layer); }
    void set_splats(int eye, unsigned colour, unsigned depth) override
    {
        splats_.set(eye, colour, depth);
    }
    void set_hidden(int eye, const std::vector<std::array<float, 2>>& corners) override
    {
        hidden_.at(std::size_t(eye)).set(corners);
    }
    bool set_splats(GpuRaster& raster, const SplatFrame& frame,
                    const DeviceGaussians* moved) override
    {
        const bool shared = sharing(raster.device()).shared;
        if (shared) splats_.draw(raster, frame, moved);
        return shared;
    }
    void expect_splats(int width, int height) override { splats_.expect(width, height); }
    double splat_seconds() const override { return splats_.seconds(); }
    void paint(const EyeView& view, const EyeLook& look, const EyeTarget& target, int eye,
               const DrawBetween& between) override;
    std::string name() const override { return name_; }

  private:
    void resize(int width, int height, bool marked);
    void build_maps();
    void light(const EyeLook& look);
    void cast_shadows();
    void aim(const EyeView& view, const EyeLook& look);
    void begin_eye(const EyeView& view);
    void draw_clay(const EyeLook& look);
    void draw_hands();
    void draw_surroundings(const EyeView& view, const EyeLook& look);
    void draw_between(const EyeView& view, const DrawnHidden& hidden, const DrawBetween& between);
    void see(const EyeView& view, const EyeLook& look, const DrawnHidden& hidden,
             const DrawBetween& between);
    void put_out(const EyeView& view, const EyeTarget& target, int eye, bool marked);

    int samples_;
    std::string name_;
    Program shadow_, scene_, ground_, backdrop_, hide_, output_;
    Program marked_output_;  // made when first used
    Texture key_map_ = shadow_maps(key_side, 1);
    Texture zenith_map_ = shadow_maps(zenith_side, 1);
    Texture colours_, depths_;
    Texture marks_;  // 1: no splat covers this sample; made when first used
    Framebuffer key_frame_ = framebuffer(), zenith_frame_ = framebuffer();
    Framebuffer frame_ = framebuffer();
    Buffer lamps_ = buffer(), view_ = buffer();
    VertexArray nothing_ = vertex_array();
    Sharings sharings_;
    EyeClay clay_{farthest};
    Shapes hands_;
    std::vector<DrawnHand> drawn_hands_;
    EyeSplats splats_;
    std::array<DrawnHidden, 2> hidden_;
    int width_ = 0, height_ = 0;  // of the multisample textures [pixels]
    long version_ = 0, colours_version_ = 0;
    std::vector<int> hidden_clay_;  // categories
    bool any_clay_ = false, shadows_stand_ = false;
    Ball lit_{};             // region covered by the shadow maps
    Vec3<float> towards_{};  // direction to the key light
    float floor_ = 0;        // its height [m]
};

GlEyePainter::GlEyePainter(int samples, bool share) : samples_(samples), sharings_(share)
{
    const GLubyte* renderer = glGetString(GL_RENDERER);
    name_ = renderer ? reinterpret_cast<const char*>(renderer) : "unnamed";
    const std::string head = live_constants(samples);
    shadow_ = program({head, common, shadow_vertex}, {head, shadow_fragment}, "live shadow");
    scene_ = program({head, common, live_vertex},
                     {head, common, shading, tones, live_shading, live_fragment}, "live scene");
    ground_ = program({head, common, live_floor_vertex},
                      {head, common, shading, ground, tones, live_shading, live_floor_fragment},
                      "live floor");
    backdrop_ = program({head, live_backdrop_vertex},
                        {head, common, shading, tones, live_backdrop_fragment}, "live backdrop");
    hide_ =
        program({head, common, live_hidden_vertex}, {head, live_hidden_fragment}, "live hidden");
    output_ = program({head, screen_vertex},
                      {head, common, tones, live_output_without_marks, live_output_fragment},
                      "live output");
    build_maps();
    glNamedBufferStorage(lamps_, live_lamps * sizeof(Lamp), nullptr, GL_DYNAMIC_STORAGE_BIT);
    glNamedBufferStorage(view_, sizeof(ViewBlock), nullptr, GL_DYNAMIC_STORAGE_BIT);
    if (const GLenum error = glGetError())
        throw std::runtime_error("no live pictures on " + name_ + ": OpenGL error " +
                                 std::to_string(error));
}

void GlEyePainter::build_maps()
{
    glNamedFramebufferDrawBuffer(key_frame_, GL_NONE);
    glNamedFramebufferTextureLayer(key_frame_, GL_DEPTH_ATTACHMENT, key_map_, 0, 0);
    glNamedFramebufferDrawBuffer(zenith_frame_, GL_NONE);
    glNamedFramebufferTextureLayer(zenith_frame_, GL_DEPTH_ATTACHMENT, zenith_map_, 0, 0);
}

void GlEyePainter::set_clay(const std::vector<Mesh>& meshes, long version,
                            const std::vector<int>& unseen, const std::vector<int>& hidden,
                            const ClayColours& colours)
{
    if (is_shown(version, hidden, colours)) return;
    clay_.set(meshes, unseen, hidden, colours);
    version_ = version, any_clay_ = true, shadows_stand_ = false;
    hidden_clay_ = hidden, colours_version_ = colours.version;
}

void GlEyePainter::set_device_clay(const DeviceMesh& mesh, long version,
                                   const std::vector<int>& unseen, const std::vector<int>& hidden,
                                   const ClayColours& colours)
{
    if (is_shown(version, hidden, colours)) return;
    if (!sharing(mesh.device()).shared)
        return set_clay(mesh.meshes(), version, unseen, hidden, colours);
    clay_.set(mesh, unseen, hidden, colours);
    version_ = version, any_clay_ = true, shadows_stand_ = false;
    hidden_clay_ = hidden, colours_version_ = colours.version;
}

void GlEyePainter::set_hands(const std::vector<HandLook>& hands)
{
    Geometry all{};
    drawn_hands_ = gather_hands(all, hands);
    hands_.upload(all);
    shadows_stand_ = false;
}

// Grows only: both eyes of a headset use the same textures.
void GlEyePainter::resize(int width, int height, bool marked)
{
    marked = marked || marks_;
    if (width <= width_ && height <= height_ && marked == bool(marks_)) return;
    const int w = std::max(width, width_), h = std::max(height, height_);
    width_ = height_ = 0;
    const auto target = [&](GLenum format) {
        Texture made = texture(GL_TEXTURE_2D_MULTISAMPLE);
        glTextureStorage2DMultisample(made, samples_, format, w, h, GL_TRUE);
        return made;
    };
    colours_ = {}, depths_ = {}, marks_ = {};
    colours_ = target(GL_SRGB8_ALPHA8);
    depths_ = target(GL_DEPTH_COMPONENT32F);
    if (marked) marks_ = target(GL_R8);
    glNamedFramebufferTexture(frame_, GL_COLOR_ATTACHMENT0, colours_, 0);
    glNamedFramebufferTexture(frame_, GL_COLOR_ATTACHMENT1, marks_, 0);
    glNamedFramebufferTexture(frame_, GL_DEPTH_ATTACHMENT, depths_, 0);
    bool fits = true;
    while (glGetError() != GL_NO_ERROR) fits = false;
    fits = fits &&
           glCheckNamedFramebufferStatus(frame_, GL_DRAW_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    if (!fits) {
        colours_ = {}, depths_ = {}, marks_ = {};
        throw PictureError("no room for a live picture of " + std::to_string(w) + " x " +
                           std::to_string(h) + " pixels on " + name_);
    }
    width_ = w, height_ = h;
}

// The lit ball is kept while it contains the clay and is at most twice the size needed: if shadow
// maps were placed anew in each frame, shadow edges would flicker.
void GlEyePainter::light(const EyeLook& look)
{
    const float room = 1.5f;  // margin for hands around the clay
    Ball wanted = look.stage;
    const Ball& clay = clay_.about();
    if (!clay_.parts().empty() && room * clay.radius < look.stage.radius)
        wanted = {clay.centre, room * clay.radius};
    const float inner = wanted.radius / room;
    const bool holds = length(wanted.centre - lit_.centre) + inner <= lit_.radius;
    const Vec3<float> towards = (1 / length(look.light)) * look.light;
    if (!holds || wanted.radius < 0.5f * lit_.radius || length(towards - towards_) > 1e-6f ||
        look.floor != floor_) {
        lit_ = wanted;
        towards_ = towards;
        floor_ = look.floor;
        const Lamp all[live_lamps] = {lamp(towards_, lit_), lamp({0, 1, 0}, lit_)};
        glNamedBufferSubData(lamps_, 0, sizeof all, all);
        shadows_stand_ = false;
    }
}

void GlEyePainter::cast_shadows()
{
    if (shadows_stand_) return;
    glUseProgram(shadow_);
    glEnable(GL_DEPTH_CLAMP);
    glEnable(GL_CULL_FACE);
    glDepthFunc(GL_LESS);
    for (int i = 0; i < live_lamps; ++i) {
        const GLuint frame = i == 0 ? key_frame_ : zenith_frame_;
        const int side = i == 0 ? key_side : zenith_side;
        const float far = 1;
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, frame);
        glViewport(0, 0, side, side);
        glClearNamedFramebufferfv(frame, GL_DEPTH, 0, &far);
        glUniform1i(0, i);
        for (std::size_t k = 0; k < clay_.parts().size(); ++k)
            if (clay_.parts()[k].casts) clay_.draw(k);
        for (const DrawnHand& hand : drawn_hands_)
            if (hand.opacity >= 0.5f) hands_.draw(hand.ranges.casting);
    }
    glDisable(GL_DEPTH_CLAMP);
    glDisable(GL_CULL_FACE);
    shadows_stand_ = true;
}

void GlEyePainter::aim(const EyeView& view, const EyeLook& look)
{
    const auto axis = [&](Vec3<float> a) { return rotate(unit(view.rotation), a); };
    const Vec3<float> right = axis({1, 0, 0}), up = axis({0, 1, 0}), forward = axis({0, 0, -1});
    const float wide = (view.right - view.left) / 2, high = (view.up - view.down) / 2;
    const float far = std::max(length(view.position - lit_.centre), lit_.radius);
    // The sky is brighter opposite the key light.
    const Vec3<float> level{-towards_.x, 0, -towards_.z};
    const Vec3<float> aside = length(level) > 1e-3f ? (1 / length(level)) * level : Vec3<float>{};
    ViewBlock block{};
    put(block.eye, view.position, view.near);
    put(block.right, wide * right, 1 / wide);
    put(block.up, high * up, 1 / high);
    put(block.forward, forward, look.floor);
    put(block.ball, lit_.centre, lit_.radius);
    // Line spacing and extent of the floor do not depend on the eye's position.
    const float room = 3 * look.stage.radius;
    put(block.scale,
        {line_spacing(room), std::max(4 * room, 2 * far), 2 * high / float(view.height)}, 0);
    put(block.sky, aside, 0);
    put(block.shift, {(view.right + view.left) / (2 * wide), (view.up + view.down) / (2 * high), 0},
        0);
    glNamedBufferSubData(view_, 0, sizeof block, &block);
}

void GlEyePainter::begin_eye(const EyeView& view)
{
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, frame_);
    glViewport(0, 0, view.width, view.height);
    glEnable(GL_FRAMEBUFFER_SRGB);
    glDepthFunc(GL_GEQUAL);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, lamps_);
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, view_);
    glBindTextureUnit(0, key_map_);
    glBindTextureUnit(1, zenith_map_);
}

void GlEyePainter::draw_clay(const EyeLook& look)
{
    glUseProgram(scene_);
    glUniform1f(1, 1);
    glUniform1f(3, look.extrapolation);
    for (std::size_t k = 0; k < clay_.parts().size(); ++k) {
        const EyeClay::Part& part = clay_.parts()[k];
        set_glow(part.category == look.highlight ? selected_glow : Vec3<float>{0, 0, 0});
        if (part.seen) clay_.draw(k);
    }
}

void GlEyePainter::draw_hands()
{
    glUseProgram(scene_);
    for (const DrawnHand& hand : drawn_hands_) {
        glUniform1f(1, clamp(hand.opacity, 0.0f, 1.0f));
        set_glow(hand.glow);
        if (hand.opacity > 0) hands_.draw(hand.ranges.seen);
    }
}

void GlEyePainter::draw_surroundings(const EyeView& view, const EyeLook& look)
{
    glBindVertexArray(nothing_);
    if (look.floor_seen && view.position.y > look.floor) {
        glUseProgram(ground_);
        glUniform1f(1, look.transparent ? 0.0f : 1.0f);
        glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    }
    if (!look.transparent) {
        glUseProgram(backdrop_);
        glDrawArrays(GL_TRIANGLES, 0, 3);
    }
}

void GlEyePainter::draw_between(const EyeView& view, const DrawnHidden& hidden,
                                const DrawBetween& between)
{
    const GLenum buffers[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    const float zero[4] = {0, 0, 0, 0};
    glNamedFramebufferDrawBuffers(frame_, 2, buffers);
    glClearNamedFramebufferfv(frame_, GL_COLOR, 1, zero);
    EyeTarget target{frame_};
    target.linear = true;
    between(target);
    glNamedFramebufferDrawBuffers(frame_, 1, buffers);
    set_state();
    begin_eye(view);
    if (!hidden.any()) return;
    // Marks the hidden area again where it was drawn over.
    glDepthFunc(GL_ALWAYS);
    glUseProgram(hide_);
    hidden.draw();
    glDepthFunc(GL_GEQUAL);
}

void GlEyePainter::see(const EyeView& view, const EyeLook& look, const DrawnHidden& hidden,
                       const DrawBetween& between)
{
    begin_eye(view);
    const float zero[4] = {0, 0, 0, 0};
    glClearNamedFramebufferfv(frame_, GL_COLOR, 0, zero);
    glClearNamedFramebufferfv(frame_, GL_DEPTH, 0, zero);
    if (hidden.any()) {
        glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
        glUseProgram(hide_);
        hidden.draw();
        glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    }
    draw_clay(look);
    if (!between) draw_hands();
    draw_surroundings(view, look);
    if (!between) return;
    draw_between(view, hidden, between);
    draw_hands();
}

void GlEyePainter::put_out(const EyeView& view, const EyeTarget& target, int eye, bool marked)
{
    const DrawnSplats& splats = splats_.of(eye);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.framebuffer);
    glViewport(target.x, target.y, view.width, view.height);
    (target.linear ? glEnable : glDisable)(GL_FRAMEBUFFER_SRGB);
    glDepthFunc(GL_ALWAYS);
    glUseProgram(marked ? marked_output_ : output_);
    const GLuint sources[] = {colours_, depths_, splats.colour_name, splats.depth_name, marks_};
    glBindTextures(0, marked ? 5 : 4, sources);
    glUniform4f(1, float(target.x), float(target.y), float(view.width), float(view.height));
    glUniform1i(2, target.linear);
    glUniform1i(3, splats.colour_name != 0);
    glUniform1i(4, hidden_[std::size_t(eye)].any());
    glUniform2f(5, float(splats.shown_width), float(splats.shown_height));
    glBindVertexArray(nothing_);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void GlEyePainter::paint(const EyeView& view, const EyeLook& look, const EyeTarget& target, int eye,
                         const DrawBetween& between)
{
    check(view, look);
    const DrawnHidden& hidden = hidden_.at(std::size_t(eye));
    if (glCheckNamedFramebufferStatus(target.framebuffer, GL_DRAW_FRAMEBUFFER) !=
        GL_FRAMEBUFFER_COMPLETE)
        throw PictureError("the framebuffer that is to be drawn into is not complete");
    const bool marked = bool(between);
    resize(view.width, view.height, marked);
    if (marked && !marked_output_) {
        const std::string head = live_constants(samples_);
        marked_output_ = program({head, screen_vertex},
                                 {head, common, tones, live_output_marks, live_output_fragment},
                                 "live output with marks");
    }
    set_state();
    light(look);
    aim(view, look);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, lamps_);
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, view_);
    cast_shadows();
    see(view, look, hidden, between);
    put_out(view, target, eye, marked);
    reset_state();
}

}  // namespace

std::unique_ptr<EyePainter> EyePainter::open(int samples, bool share)
{
    if (samples != 1 && samples != 2 && samples != 4 && samples != 8)
        throw std::runtime_error("no live pictures of " + std::to_string(samples) +
                                 " samples a pixel; expected 1, 2, 4 or 8");
    if (!glCreateTextures) throw std::runtime_error("no live pictures: OpenGL was not loaded");
    return std::make_unique<GlEyePainter>(samples, share);
}

void load_gl(GlAddress address)
{
    if (!load_gl_functions(address))
        throw std::runtime_error("no live pictures: OpenGL 4.5 does not load");
}

}  // namespace knead
