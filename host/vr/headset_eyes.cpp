#include "host/vr/headset_eyes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "host/base/machine.h"
#include "host/vr/headset_loop.h"

#ifdef KNEAD_HAS_GL
#include "host/picture/live_look.h"
#include "host/picture/splat_layer.h"
#include "host/vr/panel_quad.h"
#include "render/draw_timer.h"
#include "render/gl.h"
#include "render/pace.h"
#endif

namespace knead {

EyesOptions EyesOptions::of(const HeadsetLoopOptions& options)
{
    const bool on_gpu = options.device.kind == DeviceKind::cuda;
    EyesOptions eyes;
    eyes.device = options.device;
    eyes.samples = options.samples > 0 ? options.samples : on_gpu ? 4 : 1;
    eyes.least = options.min_scale, eyes.foveate = options.foveate;
    if (options.samples == 0 && on_gpu && !options.stepped)
        eyes.budget = gl_share * usual_period(options);
    return eyes;
}

double EyesOptions::usual_period(const HeadsetLoopOptions& options)
{
    return 1 / (options.headset.rate > 0 ? options.headset.rate : 90);
}

#ifdef KNEAD_HAS_GL
namespace {

constexpr double splat_budget = 4e-3;  // for the splats of an eye [s]

// Own textures with the size and format of an eye of the headset.
struct EyeOfOurs {
    Texture colour = texture(GL_TEXTURE_2D), depth = texture(GL_TEXTURE_2D);
    EyeTexture as;

    explicit EyeOfOurs(const HeadsetInfo& about)
        : as{colour, depth, about.width, about.height, about.srgb}
    {
        glTextureStorage2D(colour, 1, about.srgb ? GL_SRGB8_ALPHA8 : GL_RGBA8, about.width,
                           about.height);
        glTextureStorage2D(depth, 1, GL_DEPTH_COMPONENT32F, about.width, about.height);
    }
};

}  // namespace

struct HeadsetEyes::Parts {
    Parts(Headset& of, const EyesOptions& by) : headset(of), options(by) {}

    struct KeptMotion {
        std::shared_ptr<const std::vector<Gaussian<double>>> host, before;
        std::shared_ptr<const DeviceGaussians> device;
        MotionStamp stamp;

        explicit KeptMotion(const LiveState& state)
            : host(state.gaussians),
              before(state.gaussians_before),
              device(state.gaussians_on_device),
              stamp(state.gaussian_stamp)
        {
        }
        KeptMotion() = default;
        SplatMotion at(double now) const
        {
            return {host.get(), device.get(), before.get(), stamp.extrapolation(now)};
        }
    };

    Headset& headset;
    EyesOptions options;
    std::unique_ptr<EyePainter> painter;
    Framebuffer target;
    Texture own_depth;                    // if the headset has none
    std::unique_ptr<PanelDrawing> panel;  // null: none
    std::unique_ptr<PanelQuad> quad;
    Texture panel_picture;
    Framebuffer panel_target;
    std::unique_ptr<SplatDrawer> splats;
    std::array<HiddenTiles, 2> hidden;
    int splats_of = -1;  // history
    long splat_version = -1, coming_version = -1;
    // Last known motion of the splats that are drawn, and of those that are prepared.
    KeptMotion motion, coming_motion;
    int errors = 0;
    std::unique_ptr<DrawTimer> timer;
    std::optional<Pace> pace;  // of both eyes; none: full resolution
    int timed = 0;             // pictures
    double first_scale = 1;
    std::string message;

    double seconds_of_empty_eyes();
    void choose();
    float scale(const HeadsetPicture& picture);
    void follow(const LiveState& state, bool at_once);
    void follow_splats(const LiveState& state, bool at_once);
    void prepare_again(const LiveState& state);
    void draw(int eye, const EyeTexture& to, const EyeView& view, const HeadsetPicture& picture);
    void draw_panels(const EyeView& view, const EyeTarget& to, const HeadsetPicture& picture);
    void draw_panel_picture();
};

HeadsetEyes::HeadsetEyes(Headset& headset, const EyesOptions& options)
    : parts(new Parts(headset, options))
{
    load_gl(headset.gl_address());
    parts->painter = EyePainter::open(options.samples);
    parts->timer = std::make_unique<DrawTimer>();
    parts->target = framebuffer();
    if (options.budget > 0) parts->choose();
    renew();
}

std::string HeadsetEyes::message() const { return parts->message; }

// Minimum over some pictures, except the first, which includes loading.
double HeadsetEyes::Parts::seconds_of_empty_eyes()
{
    const HeadsetInfo& about = headset.facts();
    const EyeOfOurs one(about);
    glNamedFramebufferTexture(target, GL_COLOR_ATTACHMENT0, one.colour, 0);
    glNamedFramebufferTexture(target, GL_DEPTH_ATTACHMENT, one.depth, 0);
    EyeView view;
    view.position = {0.5f, 1, 1.5f}, view.width = about.width, view.height = about.height;
    double least = 1e30;
    for (int k = 0; k < 4; ++k) {
        timer->begin(1);
        for (int eye = 0; eye < 2; ++eye) painter->paint(view, {}, {target, 0, 0, about.srgb}, eye);
        timer->end();
        glFinish();
        while (const auto reading = timer->poll())
            if (k > 0) least = std::min(least, reading->seconds);
    }
    glNamedFramebufferTexture(target, GL_COLOR_ATTACHMENT0, 0, 0);
    glNamedFramebufferTexture(target, GL_DEPTH_ATTACHMENT, 0, 0);
    return least;
}

// Reduces samples before resolution: four times the pixels look better than four samples.
void HeadsetEyes::Parts::choose()
{
    double takes = seconds_of_empty_eyes();
    if (takes > options.budget && options.samples > 1) {
        message =
            fmt::format("one sample per pixel: {} of {} x {} would take {:.1f} ms", options.samples,
                        headset.facts().width, headset.facts().height, 1e3 * takes);
        painter = EyePainter::open(1);
        takes = seconds_of_empty_eyes();
    }
    if (takes > options.budget && takes < 1e30)
        first_scale = std::max(options.least, std::sqrt(options.budget / takes));
}

HeadsetEyes::~HeadsetEyes() { parts->headset.make_current(); }

int HeadsetEyes::gl_errors() const { return parts->errors; }

Sharing HeadsetEyes::sharing() const
{
    if (parts->options.device.kind != DeviceKind::cuda) return {};
    parts->headset.make_current();
    return parts->painter->sharing(parts->options.device.index);
}

void HeadsetEyes::renew()
{
    parts->headset.make_current();
    const HeadsetInfo& facts = parts->headset.facts();
    parts->painter->expect_splats(facts.width, facts.height);
    parts->own_depth = {};
    if (facts.depth) return;
    parts->own_depth = texture(GL_TEXTURE_2D);
    glTextureStorage2D(parts->own_depth, 1, GL_DEPTH_COMPONENT32F, facts.width, facts.height);
}

void HeadsetEyes::Parts::follow(const LiveState& state, bool at_once)
{
    show_clay(*painter, state);
    const bool other = state.history != splats_of || !splats;
    if (!other) return follow_splats(state, at_once);
    if (state.history == splats_of && state.splat_version == splat_version) return;
    splats_of = state.history, splat_version = state.splat_version;
    splats.reset();
    painter->set_splats(0, SplatLayer{}), painter->set_splats(1, SplatLayer{});
    if (state.splats) {
        splats = std::make_unique<SplatDrawer>(*state.splats, options.device, splat_budget);
        if (options.foveate > 0) splats->foveate(fovea_of(options.foveate));
    }
    motion = KeptMotion(state);
}

// Splats and their motion must match: while new splats are prepared, the old ones are drawn at
// their last known positions.
void HeadsetEyes::Parts::follow_splats(const LiveState& state, bool at_once)
{
    const KeptMotion now(state);
    if (splats->preparing() && state.splat_version == coming_version) coming_motion = now;
    if (splats->adopt()) splat_version = coming_version, motion = coming_motion;
    if (state.splat_version == splat_version) {
        motion = now;
    } else if (at_once) {
        splats->set(*state.splats);
        splat_version = state.splat_version, motion = now;
    } else if (!splats->preparing()) {
        splats->prepare(state.splats);
        coming_version = state.splat_version, coming_motion = now;
    }
}

// Uploads the same splats once more, to allocate the memory for a replacement.
void HeadsetEyes::Parts::prepare_again(const LiveState& state)
{
    if (!splats || !state.splats) return;
    splats->prepare(state.splats);
    coming_version = state.splat_version, coming_motion = KeptMotion(state);
}

// Resolution scale from the times of the last pictures. Pictures submitted at another scale are
// ignored.
float HeadsetEyes::Parts::scale(const HeadsetPicture& picture)
{
    if (!(picture.budget > 0)) {
        pace.reset();
        return 1;
    }
    if (!pace) pace.emplace(picture.budget, options.least, first_scale);
    constexpr int first = 4;  // pictures to ignore: they load resources
    while (const auto reading = timer->poll())
        if (++timed > first && reading->scale == float(pace->scale())) pace->took(reading->seconds);
    return float(pace->scale());
}

EyesDrawn HeadsetEyes::draw(const HeadsetViews& views, const HeadsetPicture& picture)
{
    const float scale = parts->scale(picture);
    parts->follow(picture.state, picture.at_once);
    parts->painter->set_hands(picture.hands);
    std::vector<EyeView> eye_views;
    for (std::size_t eye = 0; eye < 2; ++eye)
        eye_views.push_back(eye_view(views.eyes[eye], scaled(views.targets[eye].width, scale),
                                     scaled(views.targets[eye].height, scale), picture.workplace,
                                     picture.options, picture.near_plane));
    for (std::size_t eye = 0; eye < 2; ++eye) {
        const HiddenArea& unseen = parts->headset.facts().hidden[eye];
        parts->painter->set_hidden(int(eye), unseen.corners);
        parts->hidden[eye].set(unseen.corners);
    }
    parts->timer->begin(scale);
    if (parts->panel && picture.panel_changed) parts->draw_panel_picture();
    EyesDrawn drawn{scale};
    if (splats_hidden(picture.state)) {
        for (int eye = 0; eye < 2; ++eye) parts->painter->set_splats(eye, SplatLayer{});
    } else if (const SplatMotion motion = parts->motion.at(picture.now);
               parts->splats && motion.any()) {
        parts->splats->draw(*parts->painter, eye_views, motion, parts->options.full_resolution(),
                            &parts->hidden);
        drawn.splat_scale = float(parts->splats->scale()), drawn.splats = parts->splats->seconds();
    }
    for (std::size_t eye = 0; eye < 2; ++eye)
        parts->draw(int(eye), views.targets[eye], eye_views[eye], picture);
    parts->timer->end();
    while (glGetError() != GL_NO_ERROR) ++parts->errors;
    return drawn;
}

PanelDrawing* HeadsetEyes::open_panel(const PanelDrawingOptions& layout)
{
    parts->headset.make_current();
    parts->panel.reset();
    parts->panel = PanelDrawing::open(layout);
    if (!parts->panel) return nullptr;
    if (!parts->quad) parts->quad = std::make_unique<PanelQuad>();
    const int width = parts->panel->picture_width(), height = parts->panel->picture_height();
    Texture& picture = parts->panel_picture = texture(GL_TEXTURE_2D);
    glTextureStorage2D(picture, 4, GL_SRGB8_ALPHA8, width, height);
    glTextureParameteri(picture, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    glTextureParameteri(picture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(picture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(picture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    parts->panel_target = framebuffer();
    glNamedFramebufferTexture(parts->panel_target, GL_COLOR_ATTACHMENT0, picture, 0);
    return parts->panel.get();
}

void HeadsetEyes::rehearse(const HeadsetPicture& picture)
{
    parts->headset.make_current();
    const EyeOfOurs one(parts->headset.facts());
    HeadsetViews views;
    for (std::size_t eye = 0; eye < 2; ++eye) {
        views.eyes[eye].pose.p = cast<float>(picture.workplace.at) + Vec3<float>{0, 0.2f, 0.5f};
        views.eyes[eye].field = {-0.8f, 0.8f, 0.8f, -0.8f};
        views.targets[eye] = one.as;
    }
    // Enough for the resolution to settle, but at most half a second.
    constexpr int most = 16;
    constexpr double enough = 0.5;  // [s]
    const double begin = wall_seconds();
    try {
        for (int k = 0; k < most && (k < 2 || wall_seconds() - begin < enough); ++k) {
            draw(views, picture);
            glFinish();
            if (k == 0) parts->prepare_again(picture.state);
        }
    } catch (const std::exception&) {
    }
    glFinish();
}

void HeadsetEyes::Parts::draw(int eye, const EyeTexture& to, const EyeView& view,
                              const HeadsetPicture& picture)
{
    static const Scene none{};
    EyeLook look = live_look(picture.state.scene ? picture.state.scene->scene : none);
    look.transparent = headset.facts().see_through;
    look.floor_seen = !look.transparent;
    look.extrapolation = picture.state.mesh_stamp.extrapolation(picture.now);
    glNamedFramebufferTexture(target, GL_COLOR_ATTACHMENT0, to.colour, 0);
    glNamedFramebufferTexture(target, GL_DEPTH_ATTACHMENT, to.depth ? to.depth : own_depth, 0);
    const EyeTarget into{target, 0, 0, to.srgb};
    EyePainter::DrawBetween panels;
    if (panel && !picture.panels.empty())
        panels = [&](const EyeTarget& between) { draw_panels(view, between, picture); };
    painter->paint(view, look, into, eye, panels);
    // Detaches the textures: they belong to the runtime.
    glNamedFramebufferTexture(target, GL_COLOR_ATTACHMENT0, 0, 0);
    glNamedFramebufferTexture(target, GL_DEPTH_ATTACHMENT, 0, 0);
}

// The colours of the panel are sRGB values, which its drawing blends as they are.
void HeadsetEyes::Parts::draw_panel_picture()
{
    glBindFramebuffer(GL_FRAMEBUFFER, panel_target);
    glDisable(GL_FRAMEBUFFER_SRGB);
    glDisable(GL_SCISSOR_TEST);
    constexpr float black[] = {0, 0, 0, 1};
    glClearNamedFramebufferfv(panel_target, GL_COLOR, 0, black);
    panel->draw(panel_target);
    glGenerateTextureMipmap(panel_picture);
}

// Over clay, also nearer one; from the farthest to the nearest.
void HeadsetEyes::Parts::draw_panels(const EyeView& view, const EyeTarget& to,
                                     const HeadsetPicture& picture)
{
    const float zoom = float(picture.options.zoom);
    const Vec3<float> origin = cast<float>(picture.options.at);
    std::vector<std::pair<float, const TouchPanel*>> order;
    for (const TouchPanel& one : picture.panels)
        order.emplace_back(length(origin + zoom * one.pose.p - view.position), &one);
    std::sort(order.begin(), order.end(), std::greater<>());
    const float wide = float(panel->picture_width()), high = float(panel->picture_height());
    for (const auto& [distance, one] : order) {
        const float x = 0.5f * one->width, y = 0.5f * one->height;
        std::array<Vec3<float>, 4> corners{{{-x, y, 0}, {x, y, 0}, {-x, -y, 0}, {x, -y, 0}}};
        for (Vec3<float>& corner : corners)
            corner = origin + zoom * (one->pose.p + rotate(one->pose.q, corner));
        const PanelTexture part = PanelTexture::part(
            panel_picture, one->x, one->y, one->picture_width, one->picture_height, wide, high);
        quad->draw(corners, view, to, part);
    }
}

#else
struct HeadsetEyes::Parts {};

HeadsetEyes::HeadsetEyes(Headset&, const EyesOptions&)
{
    throw std::runtime_error("this program was built without OpenGL");
}
HeadsetEyes::~HeadsetEyes() = default;
void HeadsetEyes::renew() {}
EyesDrawn HeadsetEyes::draw(const HeadsetViews&, const HeadsetPicture&) { return {}; }
void HeadsetEyes::rehearse(const HeadsetPicture&) {}
PanelDrawing* HeadsetEyes::open_panel(const PanelDrawingOptions&) { return nullptr; }
int HeadsetEyes::gl_errors() const { return 0; }
std::string HeadsetEyes::message() const { return {}; }
Sharing HeadsetEyes::sharing() const { return {}; }
#endif
}  // namespace knead
