// Layers: whether they may be submitted, and what they show.
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/openxr_replay/pictures.h"
#include "tests/openxr_replay/runtime.h"

namespace knead::replay {
namespace {

constexpr std::uint32_t most_layers = 16;

void check_image(const XrSwapchainSubImage& image, bool depth)
{
    const SwapchainObject& chain = runtime().get<SwapchainObject>(image.swapchain);
    refuse_if(chain.depth != depth, XR_ERROR_VALIDATION_FAILURE, "a texture of the wrong kind");
    refuse_if(!chain.order.ever_released(), XR_ERROR_LAYER_INVALID, "an image never released");
    refuse_if(chain.order.held(), XR_ERROR_LAYER_INVALID, "an image that is still held");
    const auto& [offset, extent] = image.imageRect;
    const bool inside = offset.x >= 0 && offset.y >= 0 && extent.width > 0 && extent.height > 0 &&
                        offset.x + extent.width <= chain.width &&
                        offset.y + extent.height <= chain.height;
    refuse_if(!inside, XR_ERROR_SWAPCHAIN_RECT_INVALID, "a rectangle beyond the image");
    refuse_if(image.imageArrayIndex >= chain.layers, XR_ERROR_VALIDATION_FAILURE,
              "an image beyond the array");
}

void check_depth(const XrCompositionLayerDepthInfoKHR& depth)
{
    refuse_if(the_instance().enabled.count("XR_KHR_composition_layer_depth") == 0,
              XR_ERROR_LAYER_INVALID, "XR_KHR_composition_layer_depth is not enabled");
    check_image(depth.subImage, true);
    refuse_if(!(depth.minDepth >= 0 && depth.maxDepth <= 1 && depth.minDepth < depth.maxDepth),
              XR_ERROR_VALIDATION_FAILURE, "depths beyond [0, 1]");
    refuse_if(!(depth.nearZ > 0) || depth.nearZ == depth.farZ, XR_ERROR_VALIDATION_FAILURE,
              "no distances");
}

void check_projection(const XrCompositionLayerProjection& layer)
{
    refuse_if(layer.viewCount != 2 || !layer.views, XR_ERROR_VALIDATION_FAILURE, "not two views");
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

void check_quad(const XrCompositionLayerQuad& quad)
{
    check_pose(quad.pose);
    check_image(quad.subImage, false);
    refuse_if(
        quad.eyeVisibility < XR_EYE_VISIBILITY_BOTH || quad.eyeVisibility > XR_EYE_VISIBILITY_RIGHT,
        XR_ERROR_VALIDATION_FAILURE, "not eyes");
    refuse_if(!(quad.size.width >= 0 && quad.size.height >= 0), XR_ERROR_VALIDATION_FAILURE,
              "a size that cannot be");
}

void check_layer(const XrCompositionLayerBaseHeader* base)
{
    refuse_if(!base, XR_ERROR_LAYER_INVALID, "a layer is missing");
    const bool quad = base->type == XR_TYPE_COMPOSITION_LAYER_QUAD;
    refuse_if(!quad && base->type != XR_TYPE_COMPOSITION_LAYER_PROJECTION, XR_ERROR_LAYER_INVALID,
              "a layer of type " + std::to_string(int(base->type)));
    check_struct(base, base->type);
    constexpr XrCompositionLayerFlags known = 7;
    refuse_if((base->layerFlags & ~known) != 0, XR_ERROR_VALIDATION_FAILURE, "not a layer's flags");
    runtime().get<SpaceObject>(base->space);
    if (quad)
        check_quad(*reinterpret_cast<const XrCompositionLayerQuad*>(base));
    else
        check_projection(*reinterpret_cast<const XrCompositionLayerProjection*>(base));
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
    const auto texture = [&](const XrSwapchainSubImage& image) {
        const SwapchainObject& chain = r.get<SwapchainObject>(image.swapchain);
        return ShownTexture{chain.textures[std::size_t(chain.order.last_released())],
                            chain.layers > 1 ? int(image.imageArrayIndex) : ShownTexture::whole};
    };
    write_png(file,
              colour_of(texture(view.subImage), offset.x, offset.y, extent.width, extent.height));
    nlohmann::json eye{{"file", file}};
    const void* found = in_chain(&view, XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR);
    if (!found) return eye;
    const auto& depth = *static_cast<const XrCompositionLayerDepthInfoKHR*>(found);
    const DepthInfo facts =
        depth_of(texture(depth.subImage), offset.x, offset.y, extent.width, extent.height);
    eye["depth"] = {{"near", depth.nearZ},
                    {"far", std::isfinite(depth.farZ) ? nlohmann::json(depth.farZ) : "infinity"},
                    {"nearest", facts.nearest},
                    {"farthest", facts.farthest},
                    {"covered", facts.covered},
                    {"mean", facts.mean}};
    return eye;
}

}  // namespace

void check_layers(const SessionObject& session, const XrFrameEndInfo& end)
{
    refuse_if(end.layerCount > 0 && !end.layers, XR_ERROR_VALIDATION_FAILURE, "a list is missing");
    refuse_if(end.layerCount > most_layers, XR_ERROR_LAYER_LIMIT_EXCEEDED, "too many layers");
    complain_if(end.layerCount > 0 && !session.begun_to_render,
                "a layer, though nothing was to be rendered");
    for (std::uint32_t i = 0; i < end.layerCount; ++i) check_layer(end.layers[i]);
}

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
        if (end.layers[i]->type != XR_TYPE_COMPOSITION_LAYER_PROJECTION) continue;
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

}  // namespace knead::replay
