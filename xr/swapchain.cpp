#include "xr/swapchain.h"

#include <algorithm>

#include "xr/headset.h"
#include "xr/two_call.h"

namespace knead::xr {

// SRGB8_ALPHA8, RGBA8; DEPTH_COMPONENT32F, 24, 16. No formats with stencil: Mesa's software
// renderer crashes on those created by another API.
const std::vector<std::int64_t> colour_formats{0x8C43, 0x8058};
const std::vector<std::int64_t> depth_formats{0x8CAC, 0x81A6, 0x81A5};

bool is_srgb(std::int64_t format) { return format == colour_formats[0]; }

std::int64_t chosen_format(const std::vector<std::int64_t>& liked,
                           const std::vector<std::int64_t>& offered)
{
    for (const std::int64_t format : liked)
        if (std::find(offered.begin(), offered.end(), format) != offered.end()) return format;
    return 0;
}

Swapchain::Swapchain(Api& of, XrSession session, std::int64_t format, XrSwapchainUsageFlags usage,
                     int wide, int high)
    : api(of), width(wide), height(high)
{
    auto about = typed<XrSwapchainCreateInfo>(XR_TYPE_SWAPCHAIN_CREATE_INFO);
    about.usageFlags = usage;
    about.format = format;
    about.sampleCount = about.faceCount = about.arraySize = about.mipCount = 1;
    about.width = std::uint32_t(width), about.height = std::uint32_t(height);
    api.create_swapchain(session, &about, &chain);
    // Not by listed(): the call takes an array of the base struct.
    std::uint32_t count = 0;
    api.images(chain, 0, &count, nullptr);
    std::vector<XrSwapchainImageOpenGLKHR> images(count,
                                                  {XR_TYPE_SWAPCHAIN_IMAGE_OPENGL_KHR, nullptr, 0});
    api.images(chain, count, &count, reinterpret_cast<XrSwapchainImageBaseHeader*>(images.data()));
    for (const XrSwapchainImageOpenGLKHR& image : images) textures.push_back(image.image);
}

Swapchain::~Swapchain() { api.destroy_swapchain.raw(chain); }

unsigned Swapchain::acquire(double wait)
{
    if (!acquired) api.acquire_image(chain, nullptr, &index);
    acquired = true;
    auto about = typed<XrSwapchainImageWaitInfo>(XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO);
    about.timeout = XrDuration(1e9 * wait);
    ready = api.wait_image(chain, &about) != XR_TIMEOUT_EXPIRED;
    return ready ? textures.at(index) : 0;
}

void Swapchain::release()
{
    acquired = ready = false;
    api.release_image(chain, nullptr);
}

XrSwapchainSubImage Swapchain::part(float scale) const
{
    return {chain, {{0, 0}, {scaled(width, scale), scaled(height, scale)}}, 0};
}

}  // namespace knead::xr
