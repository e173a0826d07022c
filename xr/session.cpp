#include "xr/session.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "xr/hand_shape.h"
#include "xr/two_call.h"

namespace knead::xr {
namespace {

// Tolerance for matching the requested rate to one that the runtime lists.
constexpr double same_rate = 1;  // [1/s]

// Timeout of xrWaitSwapchainImage; on timeout the frame is not drawn [s].
constexpr double image_wait = 0.5;

}  // namespace

Session::Session(Instance& of, Platform& by, const HeadsetOptions& with)
    : instance(of), platform(by), options(with)
{
    gl_error = reinterpret_cast<unsigned (*)()>(platform.address()("glGetError"));
    gl_finish = reinterpret_cast<void (*)()>(platform.address()("glFinish"));
    for (XrView& view : views) view = typed<XrView>(XR_TYPE_VIEW);
    create();
    try {
        make_spaces();
        make_chains();
        actions = std::make_unique<Actions>(instance, session);
        hands = std::make_unique<HandTrackers>(instance, session);
        blend = instance.blend_mode(options.see_through);
        ask_for_rate();
    } catch (...) {
        free_all();
        throw;
    }
}

// xrDestroySwapchain requires that all commands on its images have finished: it frees their memory,
// and a renderer still drawing into it faults.
void Session::finish_gl()
{
    try {
        platform.make_current();
        gl_finish();
    } catch (const std::runtime_error&) {
        // The context is lost: there is nothing to wait for.
    }
}

void Session::free_all()
{
    finish_gl();
    hands.reset(), actions.reset();
    for (int eye = 0; eye < 2; ++eye) colour[eye].reset(), depth[eye].reset();
    if (origin) instance.api.destroy_space.raw(origin);
    if (session) instance.api.destroy_session.raw(session);
    finish_gl();
}

void Session::before_gl()
{
    while (gl_error() != 0) ++gl_errors;
}

void Session::after_gl()
{
    platform.make_current();
    while (gl_error() != 0) ++gl_errors;
}

void Session::create()
{
    // This call is mandatory before xrCreateSession. The painters use OpenGL 4.5.
    auto needs = typed<XrGraphicsRequirementsOpenGLKHR>(XR_TYPE_GRAPHICS_REQUIREMENTS_OPENGL_KHR);
    instance.api.gl_requirements(instance.api.instance, instance.system, &needs);
    if (needs.minApiVersionSupported > XR_MAKE_VERSION(4, 5, 0xffffffff))
        throw HeadsetError("the OpenXR runtime wants a newer OpenGL than 4.5");
    auto about = typed<XrSessionCreateInfo>(XR_TYPE_SESSION_CREATE_INFO);
    about.next = platform.binding();
    about.systemId = instance.system;
    before_gl();
    instance.api.create_session(instance.api.instance, &about, &session);
    after_gl();
}

void Session::make_spaces()
{
    const auto offered =
        listed(instance.api.reference_spaces, XR_REFERENCE_SPACE_TYPE_LOCAL, session);
    const bool stage =
        std::find(offered.begin(), offered.end(), XR_REFERENCE_SPACE_TYPE_STAGE) != offered.end();
    auto about = typed<XrReferenceSpaceCreateInfo>(XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
    floor = stage ? options.floor : Floor::seated;
    about.referenceSpaceType =
        floor == Floor::standing ? XR_REFERENCE_SPACE_TYPE_STAGE : XR_REFERENCE_SPACE_TYPE_LOCAL;
    about.poseInReferenceSpace.orientation.w = 1;
    instance.api.create_reference_space(session, &about, &origin);
}

void Session::move_origin()
{
    const XrSpace before = std::exchange(origin, XR_NULL_HANDLE);
    instance.api.destroy_space.raw(before);
    make_spaces();
}

void Session::make_chains()
{
    const auto offered = listed(instance.api.formats, std::int64_t(0), session);
    colour_format = chosen_format(colour_formats, offered);
    depth_format = instance.has[depth_layer] ? chosen_format(depth_formats, offered) : 0;
    if (colour_format == 0)
        throw HeadsetError("the OpenXR runtime offers neither SRGB8_ALPHA8 nor RGBA8 textures");
    before_gl();
    for (int eye = 0; eye < 2; ++eye) {
        const int width = int(instance.views[eye].recommendedImageRectWidth);
        const int height = int(instance.views[eye].recommendedImageRectHeight);
        colour[eye] = std::make_unique<Swapchain>(
            instance.api, session, colour_format,
            XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_SAMPLED_BIT, width,
            height);
        if (depth_format != 0)
            depth[eye] = std::make_unique<Swapchain>(
                instance.api, session, depth_format,
                XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_SAMPLED_BIT,
                width, height);
    }
    after_gl();
}

void Session::ask_for_rate()
{
    if (!instance.has[xr::refresh_rate] || options.rate <= 0) return;
    const auto offered = listed(instance.api.refresh_rates, 0.f, session);
    for (const float rate : offered)
        if (std::abs(rate - options.rate) < same_rate)
            instance.api.request_refresh_rate.raw(session, rate);
}

double Session::refresh_rate()
{
    float rate = 0;
    if (instance.has[xr::refresh_rate]) instance.api.refresh_rate.raw(session, &rate);
    return rate;
}

void Session::fulfil(SessionAction duty)
{
    if (duty == SessionAction::begin) {
        auto about = typed<XrSessionBeginInfo>(XR_TYPE_SESSION_BEGIN_INFO);
        about.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
        instance.api.begin_session(session, &about);
    } else if (duty == SessionAction::end) {
        instance.api.end_session(session);
    }
    state.did(duty);
}

XrFrameState Session::wait()
{
    auto about = typed<XrFrameWaitInfo>(XR_TYPE_FRAME_WAIT_INFO);
    auto frame = typed<XrFrameState>(XR_TYPE_FRAME_STATE);
    instance.api.wait_frame(session, &about, &frame);
    auto begin = typed<XrFrameBeginInfo>(XR_TYPE_FRAME_BEGIN_INFO);
    before_gl();
    instance.api.begin_frame(session, &begin);
    after_gl();
    return frame;
}

bool Session::locate_eyes(const XrFrameState& frame, HeadsetViews& frame_views)
{
    auto about = typed<XrViewLocateInfo>(XR_TYPE_VIEW_LOCATE_INFO);
    about.viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
    about.displayTime = frame.predictedDisplayTime;
    about.space = origin;
    auto seen = typed<XrViewState>(XR_TYPE_VIEW_STATE);
    std::uint32_t count = 0;
    instance.api.locate_views(session, &about, &seen, 2, &count, views);
    constexpr XrViewStateFlags both =
        XR_VIEW_STATE_POSITION_VALID_BIT | XR_VIEW_STATE_ORIENTATION_VALID_BIT;
    if (count != 2 || (seen.viewStateFlags & both) != both) return false;
    for (int eye = 0; eye < 2; ++eye) {
        const XrFovf& fov = views[eye].fov;
        frame_views.eyes[std::size_t(eye)] = {
            joint_of(views[eye].pose), {fov.angleLeft, fov.angleRight, fov.angleUp, fov.angleDown}};
    }
    return true;
}

// The tracked hand, else a hand posed around the active controller.
TrackedHand Session::hand(Side side, XrTime time)
{
    TrackedHand found = hands->locate(side, origin, time);
    const HeldButtons held = actions->held(side, origin, time);
    found.pinch = held.trigger, found.grasp = held.grasp;
    found.holds = held.active;
    found.lower = held.lower, found.upper = held.upper, found.aim = held.aim;
    if (!found.hand.tracked && held.active) {
        found.hand = hand_around(side, held.grip, held.trigger, held.grasp);
        found.from = HandFrom::posed;
    }
    return found;
}

HeadsetViews Session::locate(const XrFrameState& frame)
{
    HeadsetViews frame_views;
    actions->sync();
    const bool eyes = frame_views.located = locate_eyes(frame, frame_views);
    for (const Side side : {left, right})
        frame_views.hands[std::size_t(side)] = hand(side, frame.predictedDisplayTime);
    frame_views.draw = frame.shouldRender && eyes && open_targets(frame_views);
    return frame_views;
}

bool Session::open_targets(HeadsetViews& frame_views)
{
    before_gl();
    bool all = true;
    for (std::size_t eye = 0; eye < 2 && all; ++eye) {
        const XrViewConfigurationView& view = instance.views[eye];
        EyeTexture& target = frame_views.targets[eye];
        target.width = int(view.recommendedImageRectWidth);
        target.height = int(view.recommendedImageRectHeight);
        target.srgb = is_srgb(colour_format);
        target.colour = colour[eye]->acquire(image_wait);
        all = target.colour != 0;
        if (!depth[eye] || !all) continue;
        target.depth = depth[eye]->acquire(image_wait);
        all = target.depth != 0;
    }
    after_gl();
    return all;
}

void Session::close_targets()
{
    before_gl();
    for (int eye = 0; eye < 2; ++eye) {
        if (colour[eye]->held()) colour[eye]->release();
        if (depth[eye] && depth[eye]->held()) depth[eye]->release();
    }
    after_gl();
}

void Session::end(const XrFrameState& frame, const FrameSubmission& drawn)
{
    close_targets();
    for (const Side side : {left, right})
        if (drawn.vibrate[side] > 0) actions->vibrate(side, drawn.vibrate[side]);
    XrCompositionLayerProjectionView eyes[2];
    XrCompositionLayerDepthInfoKHR depths[2];
    for (int eye = 0; eye < 2; ++eye) {
        eyes[eye] =
            typed<XrCompositionLayerProjectionView>(XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW);
        eyes[eye].pose = views[eye].pose;
        eyes[eye].fov = views[eye].fov;
        eyes[eye].subImage = colour[eye]->part(drawn.scale);
        if (!depth[eye] || !(drawn.near_z > 0)) continue;
        depths[eye] =
            typed<XrCompositionLayerDepthInfoKHR>(XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR);
        depths[eye].subImage = depth[eye]->part(drawn.scale);
        depths[eye].maxDepth = 1;
        depths[eye].nearZ = drawn.near_z, depths[eye].farZ = drawn.far_z;
        eyes[eye].next = &depths[eye];
    }
    auto layer = typed<XrCompositionLayerProjection>(XR_TYPE_COMPOSITION_LAYER_PROJECTION);
    if (blend == XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND)
        layer.layerFlags = XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT;
    layer.space = origin;
    layer.viewCount = 2;
    layer.views = eyes;
    const auto* layers = reinterpret_cast<const XrCompositionLayerBaseHeader*>(&layer);
    auto about = typed<XrFrameEndInfo>(XR_TYPE_FRAME_END_INFO);
    about.displayTime = frame.predictedDisplayTime;
    about.environmentBlendMode = blend;
    about.layerCount = drawn.eyes ? 1 : 0;
    about.layers = &layers;
    before_gl();
    instance.api.end_frame(session, &about);
    after_gl();
}

HiddenArea Session::hidden_area(int eye)
{
    HiddenArea area;
    if (!instance.has[visibility_mask]) return area;
    auto mask = typed<XrVisibilityMaskKHR>(XR_TYPE_VISIBILITY_MASK_KHR);
    const auto ask = [&] {
        return instance.api.visibility_mask.raw(
            session, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, std::uint32_t(eye),
            XR_VISIBILITY_MASK_TYPE_HIDDEN_TRIANGLE_MESH_KHR, &mask);
    };
    if (XR_FAILED(ask())) return area;
    std::vector<XrVector2f> corners(mask.vertexCountOutput);
    std::vector<std::uint32_t> indices(mask.indexCountOutput);
    mask.vertexCapacityInput = std::uint32_t(corners.size()), mask.vertices = corners.data();
    mask.indexCapacityInput = std::uint32_t(indices.size()), mask.indices = indices.data();
    if (corners.empty() || indices.size() % 3 != 0 || XR_FAILED(ask())) return area;
    for (const std::uint32_t index : indices) {
        if (index >= corners.size()) return {};
        const XrVector2f& c = corners[index];
        if (!std::isfinite(c.x) || !std::isfinite(c.y)) return {};
        area.corners.push_back({c.x, c.y});
    }
    return area;
}

void Session::describe(HeadsetInfo& facts) const
{
    facts.srgb = is_srgb(colour_format);
    facts.depth = depth_format != 0;
    facts.see_through = blend == XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND;
    facts.hands = instance.tracks_hands;
    facts.floor = floor;
    facts.width = int(instance.views[0].recommendedImageRectWidth);
    facts.height = int(instance.views[0].recommendedImageRectHeight);
}

}  // namespace knead::xr
