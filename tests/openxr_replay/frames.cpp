// Frames: waiting, beginning, ending, and where the eyes are.
#include <chrono>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "render/gl.h"
#include "tests/openxr_replay/pictures.h"
#include "tests/openxr_replay/runtime.h"

namespace knead::replay {
namespace {

// Of the left eye; the right one's is its mirror image. Inwards less than outwards, as lenses have.
constexpr float outwards = 0.82f, inwards = 0.70f, upwards = 0.76f, downwards = 0.84f;  // [rad]

std::int64_t monotonic()  // [ns]
{
    return std::chrono::duration_cast<std::chrono::nanoseconds>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

XrFovf fov_of(int eye)
{
    return eye == 0 ? XrFovf{-outwards, inwards, upwards, -downwards}
                    : XrFovf{-inwards, outwards, upwards, -downwards};
}

// In real time the script's clock begins when the first frame is waited for.
std::int64_t now_of(Runtime& r)
{
    static const std::int64_t began = monotonic();
    return r.script.real_time ? Runtime::zero + monotonic() - began : 0;
}

XrResult XRAPI_CALL wait(XrSession handle, const XrFrameWaitInfo* info, XrFrameState* to)
{
    std::int64_t sleep = 0;
    const XrResult result = answered("xrWaitFrame", [&](Runtime& r) {
        SessionObject& session = session_of(handle);
        if (info) check_struct(info, XR_TYPE_FRAME_WAIT_INFO);
        check_struct(to, XR_TYPE_FRAME_STATE);
        refuse_if(!session.flow.running(), XR_ERROR_SESSION_NOT_RUNNING, "it is not running");
        refuse_if(!session.order.may_wait(), XR_ERROR_CALL_ORDER_INVALID,
                  "waited for twice without a beginning: this would block");
        ++r.frame;
        play_faults(session);
        session_of(handle);  // may be lost by now
        session.order.wait();
        const std::int64_t now = now_of(r);
        session.waited = r.clock.next(now);
        session.will_render = session.flow.visible() && r.frame % r.script.render_every == 0 &&
                              !r.script.has(FaultKind::no_render, r.frame);
        to->predictedDisplayTime = session.waited;
        to->predictedDisplayPeriod = r.clock.period();
        to->shouldRender = session.will_render;
        if (now > 0) sleep = session.waited - r.clock.lead() - now;
    });
    if (sleep > 0) std::this_thread::sleep_for(std::chrono::nanoseconds(sleep));
    return result;
}

// Some runtimes fail where an error was left before the call.
void check_no_gl_error(SessionObject& session)
{
    const auto held = session.gl->bind();
    const unsigned error = glGetError();
    refuse_if(error != 0, XR_ERROR_RUNTIME_FAILURE,
              "called with a GL error pending: " + std::to_string(error));
}

XrResult XRAPI_CALL begin(XrSession handle, const XrFrameBeginInfo* info)
{
    return answered("xrBeginFrame", [&](Runtime& r) -> XrResult {
        SessionObject& session = session_of(handle);
        if (info) check_struct(info, XR_TYPE_FRAME_BEGIN_INFO);
        refuse_if(!session.flow.running(), XR_ERROR_SESSION_NOT_RUNNING, "it is not running");
        check_no_gl_error(session);
        bool discarded = false;
        allowed(session.order.begin(discarded));
        session.begun = session.waited, session.begun_frame = r.frame;
        refuse_if(discarded, XR_FRAME_DISCARDED, "a frame was begun and never ended");
        return XR_SUCCESS;
    });
}

const SwapchainObject& check_image(const XrSwapchainSubImage& image, bool depth)
{
    const SwapchainObject& chain = runtime().get<SwapchainObject>(image.swapchain);
    refuse_if(chain.depth != depth, XR_ERROR_VALIDATION_FAILURE, "a texture of the wrong kind");
    refuse_if(!chain.order.ever_released(), XR_ERROR_LAYER_INVALID, "an image never released");
    refuse_if(chain.order.held(), XR_ERROR_LAYER_INVALID, "an image that is still held");
    const auto& [offset, extent] = image.imageRect;
    const bool inside = offset.x >= 0 && offset.y >= 0 && extent.width > 0 && extent.height > 0 &&
                        offset.x + extent.width <= chain.width &&
                        offset.y + extent.height <= chain.height;
    refuse_if(!inside || image.imageArrayIndex != 0, XR_ERROR_SWAPCHAIN_RECT_INVALID,
              "a rectangle beyond the image");
    return chain;
}

void check_depth(const XrCompositionLayerDepthInfoKHR& depth)
{
    check_enabled("XR_KHR_composition_layer_depth");
    check_image(depth.subImage, true);
    refuse_if(!(depth.minDepth >= 0 && depth.maxDepth <= 1 && depth.minDepth < depth.maxDepth),
              XR_ERROR_VALIDATION_FAILURE, "depths beyond [0, 1]");
    refuse_if(!(depth.nearZ > 0) || depth.nearZ == depth.farZ, XR_ERROR_VALIDATION_FAILURE,
              "no distances");
}

void check_layer(const SessionObject& session, const XrCompositionLayerBaseHeader* base)
{
    check_struct(base, XR_TYPE_COMPOSITION_LAYER_PROJECTION);
    const auto& layer = *reinterpret_cast<const XrCompositionLayerProjection*>(base);
    runtime().get<SpaceObject>(layer.space);
    refuse_if(layer.viewCount != 2 || !layer.views, XR_ERROR_VALIDATION_FAILURE, "not two views");
    refuse_if(!session.will_render, XR_ERROR_LAYER_INVALID,
              "a layer, though nothing was to be rendered");
    for (int eye = 0; eye < 2; ++eye) {
        const XrCompositionLayerProjectionView& view = layer.views[eye];
        check_struct(&view, XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW,
                     {XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR});
        check_pose(view.pose);
        check_image(view.subImage, false);
        const XrFovf truth = fov_of(eye);
        refuse_if(view.fov.angleLeft != truth.angleLeft || view.fov.angleUp != truth.angleUp ||
                      view.fov.angleRight != truth.angleRight ||
                      view.fov.angleDown != truth.angleDown,
                  XR_ERROR_VALIDATION_FAILURE, "another field of view than was located");
        if (const void* depth = in_chain(&view, XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR))
            check_depth(*static_cast<const XrCompositionLayerDepthInfoKHR*>(depth));
    }
}

XrResult XRAPI_CALL end(XrSession handle, const XrFrameEndInfo* info)
{
    return answered("xrEndFrame", [&](Runtime& r) {
        SessionObject& session = session_of(handle);
        check_struct(info, XR_TYPE_FRAME_END_INFO);
        check_no_gl_error(session);
        allowed(session.order.end());
        refuse_if(info->displayTime != session.begun, XR_ERROR_TIME_INVALID,
                  "another display time than the frame's");
        const bool opaque = info->environmentBlendMode == XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
        const bool alpha = info->environmentBlendMode == XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND;
        refuse_if(!opaque && !(alpha && r.script.passthrough),
                  XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED, "a mode that is not offered");
        for (std::uint32_t i = 0; i < info->layerCount; ++i) check_layer(session, info->layers[i]);
        log_layers(session, *info);
        session.flow.frame_ended();
        if (r.script.has(FaultKind::gl_error, session.begun_frame)) {
            const auto held = session.gl->bind();
            glEnable(0xffff);
        }
        if (r.context_stolen) session.gl->steal();
    });
}

XrResult XRAPI_CALL locate(XrSession handle, const XrViewLocateInfo* info, XrViewState* state,
                           std::uint32_t capacity, std::uint32_t* count, XrView* to)
{
    return answered("xrLocateViews", [&](Runtime& r) {
        session_of(handle);
        check_struct(info, XR_TYPE_VIEW_LOCATE_INFO);
        check_struct(state, XR_TYPE_VIEW_STATE);
        const SpaceObject& base = r.get<SpaceObject>(info->space);
        refuse_if(info->displayTime <= 0, XR_ERROR_TIME_INVALID, "not a time");
        for (std::uint32_t i = 0; to && i < capacity; ++i) check_struct(&to[i], XR_TYPE_VIEW);
        state->viewStateFlags =
            XR_VIEW_STATE_POSITION_VALID_BIT | XR_VIEW_STATE_ORIENTATION_VALID_BIT |
            XR_VIEW_STATE_POSITION_TRACKED_BIT | XR_VIEW_STATE_ORIENTATION_TRACKED_BIT;
        std::vector<XrView> all;
        const double time = r.script_time(info->displayTime);
        for (int eye = 0; eye < 2; ++eye) {
            Joint<double> pose = eye_at(r.script, time, eye);
            pose.p.y += higher_in(base);
            all.push_back({XR_TYPE_VIEW, nullptr, pose_of(pose), fov_of(eye)});
        }
        return give(all, capacity, count, to);
    });
}

nlohmann::json json_of(const XrPosef& pose)
{
    const auto& [q, p] = pose;
    return {{"p", {p.x, p.y, p.z}}, {"q", {q.w, q.x, q.y, q.z}}};
}

nlohmann::json look_at(const XrCompositionLayerProjectionView& view, const std::string& file)
{
    Runtime& r = runtime();
    const auto& [offset, extent] = view.subImage.imageRect;
    const auto texture = [&](XrSwapchain handle) {
        const SwapchainObject& chain = r.get<SwapchainObject>(handle);
        return chain.textures[std::size_t(chain.order.last_released())];
    };
    write_png(file, colour_of(texture(view.subImage.swapchain), offset.x, offset.y, extent.width,
                              extent.height));
    nlohmann::json eye{{"file", file}};
    const void* found = in_chain(&view, XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR);
    if (!found) return eye;
    const auto& depth = *static_cast<const XrCompositionLayerDepthInfoKHR*>(found);
    const DepthFacts facts = depth_of(texture(depth.subImage.swapchain), offset.x, offset.y,
                                      extent.width, extent.height);
    eye["depth"] = {{"near", depth.nearZ},
                    {"far", std::isfinite(depth.farZ) ? nlohmann::json(depth.farZ) : "infinity"},
                    {"nearest", facts.nearest},
                    {"farthest", facts.farthest},
                    {"covered", facts.covered},
                    {"mean", facts.mean}};
    return eye;
}

}  // namespace

void log_layers(SessionObject& session, const XrFrameEndInfo& end)
{
    Runtime& r = runtime();
    nlohmann::json line{{"frame", session.begun_frame},
                        {"time", r.script_time(end.displayTime)},
                        {"layers", end.layerCount},
                        {"blend", int(end.environmentBlendMode)},
                        {"focused", session.flow.focused()}};
    const bool dumps = !r.script.dump.empty() && session.begun_frame % r.script.dump_every == 0;
    for (std::uint32_t i = 0; i < end.layerCount; ++i) {
        const auto& layer = *reinterpret_cast<const XrCompositionLayerProjection*>(end.layers[i]);
        for (int eye = 0; eye < 2; ++eye) {
            const XrCompositionLayerProjectionView& view = layer.views[eye];
            nlohmann::json one = json_of(view.pose);
            one["fov"] = {view.fov.angleLeft, view.fov.angleRight, view.fov.angleUp,
                          view.fov.angleDown};
            one["has_depth"] = in_chain(&view, XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR) != nullptr;
            if (dumps) {
                char name[64];
                std::snprintf(name, sizeof name, "frame_%05d_%s.png", session.begun_frame,
                              eye == 0 ? "left" : "right");
                std::filesystem::create_directories(r.script.dump);
                const auto held = session.gl->bind();
                one.update(look_at(view, r.script.dump + "/" + name));
            }
            line["eyes"].push_back(one);
        }
    }
    r.note(line);
}

void add_frame_functions(Table& to)
{
    to["xrWaitFrame"] = entry(wait);
    to["xrBeginFrame"] = entry(begin);
    to["xrEndFrame"] = entry(end);
    to["xrLocateViews"] = entry(locate);
}

}  // namespace knead::replay
