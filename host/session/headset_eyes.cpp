#include "host/session/headset_eyes.h"

#include <stdexcept>

#ifdef KNEAD_HAS_GL
#include "host/session/live_look.h"
#include "host/session/panel_quad.h"
#include "host/session/splat_layer.h"
#include "render/gl.h"
#endif

namespace knead {
#ifdef KNEAD_HAS_GL
namespace {

constexpr double splat_budget = 4e-3;  // for the splats of an eye [s]

}  // namespace

struct HeadsetEyes::Parts {
    Headset& headset;
    Device device;
    std::unique_ptr<EyePainter> painter;
    Framebuffer target;
    Texture own_depth;  // where the headset takes none
    std::unique_ptr<PanelQuad> quad;
    std::unique_ptr<SplatDrawer> splats;
    HiddenTiles hidden[2];
    int splats_of = -1;  // history
    long splat_version = -1;
    int errors = 0;

    void follow(const LiveState& state);
    void draw(int eye, const EyeTexture& to, const EyeView& view, const HeadsetPicture& picture);
    void draw_panel(const EyeView& view, const EyeTarget& to, const HeadsetPicture& picture);
};

HeadsetEyes::HeadsetEyes(Headset& headset, int samples, Device device)
    : parts(new Parts{headset, device, {}, {}, {}, {}, {}, {}})
{
    load_gl(headset.gl_address());
    parts->painter = EyePainter::open(samples);
    parts->target = framebuffer();
    renew();
}

HeadsetEyes::~HeadsetEyes() { parts->headset.make_current(); }

int HeadsetEyes::gl_errors() const { return parts->errors; }

void HeadsetEyes::renew()
{
    parts->headset.make_current();
    const HeadsetFacts& facts = parts->headset.facts();
    parts->own_depth = {};
    if (facts.depth) return;
    parts->own_depth = texture(GL_TEXTURE_2D);
    glTextureStorage2D(parts->own_depth, 1, GL_DEPTH_COMPONENT32F, facts.width, facts.height);
}

void HeadsetEyes::Parts::follow(const LiveState& state)
{
    static const std::vector<Mesh> nothing;
    const bool any = state.scene != nullptr;
    painter->set_clay(state.meshes ? *state.meshes : nothing, clay_version(state),
                      any ? splat_categories(state.scene->scene) : std::vector<int>());
    if (state.history == splats_of && state.splat_version == splat_version) return;
    const bool other = state.history != splats_of || !splats;
    splats_of = state.history, splat_version = state.splat_version;
    if (!other) return splats->set(*state.splats);
    splats.reset();
    painter->set_splats(0, SplatLayer{}), painter->set_splats(1, SplatLayer{});
    if (state.splats) splats = std::make_unique<SplatDrawer>(*state.splats, device, splat_budget);
}

void HeadsetEyes::draw(const Sight& sight, const HeadsetPicture& picture)
{
    parts->follow(picture.state);
    parts->painter->set_hands(picture.hands);
    for (int eye = 0; eye < 2; ++eye) {
        const EyeTexture& to = sight.targets[std::size_t(eye)];
        const EyeView view = eye_view(sight.eyes[std::size_t(eye)], to.width, to.height,
                                      picture.workplace, picture.rule, picture.nearest);
        parts->draw(eye, to, view, picture);
    }
    while (glGetError() != GL_NO_ERROR) ++parts->errors;
}

void HeadsetEyes::Parts::draw(int eye, const EyeTexture& to, const EyeView& view,
                              const HeadsetPicture& picture)
{
    static const Scene none{};
    EyeLook look = live_look(picture.state.scene ? picture.state.scene->scene : none);
    look.transparent = headset.facts().see_through;
    look.floor_seen = !look.transparent;
    glNamedFramebufferTexture(target, GL_COLOR_ATTACHMENT0, to.colour, 0);
    glNamedFramebufferTexture(target, GL_DEPTH_ATTACHMENT, to.depth ? to.depth : own_depth, 0);
    const HiddenArea& unseen = headset.facts().hidden[std::size_t(eye)];
    painter->set_hidden(eye, unseen.corners);
    hidden[eye].set(unseen.corners);
    if (splats && picture.state.gaussians)
        painter->set_splats(eye,
                            splats->layer(view, *picture.state.gaussians, false, &hidden[eye]));
    const EyeTarget into{target, 0, 0, to.srgb};
    painter->paint(view, look, into, eye);
    if (picture.panel) draw_panel(view, into, picture);
    // The texture is the runtime's again.
    glNamedFramebufferTexture(target, GL_COLOR_ATTACHMENT0, 0, 0);
    glNamedFramebufferTexture(target, GL_DEPTH_ATTACHMENT, 0, 0);
}

void HeadsetEyes::Parts::draw_panel(const EyeView& view, const EyeTarget& to,
                                    const HeadsetPicture& picture)
{
    if (picture.canvas) {
        if (!quad)
            quad = std::make_unique<PanelQuad>(picture.canvas->width(), picture.canvas->height(),
                                               to.linear);
        quad->upload(*picture.canvas);
    }
    if (!quad) return;
    const Joint<float>& at = *picture.panel;
    const float x = 0.5f * picture.panel_width, y = 0.5f * picture.panel_height;
    std::array<Vec3<float>, 4> corners{{{-x, y, 0}, {x, y, 0}, {-x, -y, 0}, {x, -y, 0}}};
    for (Vec3<float>& corner : corners)
        corner =
            cast<float>(picture.rule.at) + float(picture.rule.zoom) * (at.p + rotate(at.q, corner));
    quad->draw(corners, view, to);
}

#else
struct HeadsetEyes::Parts {};

HeadsetEyes::HeadsetEyes(Headset&, int, Device)
{
    throw std::runtime_error("this program was built without OpenGL");
}
HeadsetEyes::~HeadsetEyes() = default;
void HeadsetEyes::renew() {}
void HeadsetEyes::draw(const Sight&, const HeadsetPicture&) {}
int HeadsetEyes::gl_errors() const { return 0; }
#endif
}  // namespace knead
