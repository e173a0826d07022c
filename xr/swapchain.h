// An OpenXR swapchain of GL textures.
#pragma once
#include <cstdint>
#include <vector>

#include "xr/api.h"

namespace knead::xr {

// GL internal formats that the painters can write, by number in the GL registry, best first.
extern const std::vector<std::int64_t> colour_formats, depth_formats;
bool is_srgb(std::int64_t format);
// The first of `liked` that is in `offered`; 0: none.
std::int64_t chosen_format(const std::vector<std::int64_t>& liked,
                           const std::vector<std::int64_t>& offered);

class Swapchain {
  public:
    Swapchain(Api& api, XrSession session, std::int64_t format, XrSwapchainUsageFlags usage,
              int width, int height);
    ~Swapchain();
    Swapchain(const Swapchain&) = delete;

    // Acquires an image and waits up to `wait` [s] for it. Returns its texture, valid until
    // release(); 0 on timeout: the image stays acquired and the next call waits for it again.
    unsigned acquire(double wait);
    void release();
    bool held() const { return ready; }  // waited for, not released
    // Subimage for a composition layer: the fraction `scale` of both sides (rounded), from the
    // lower left corner.
    XrSwapchainSubImage part(float scale) const;

  private:
    Api& api;
    XrSwapchain chain = XR_NULL_HANDLE;
    int width, height;
    std::vector<unsigned> textures;
    std::uint32_t index = 0;  // of the acquired image
    bool acquired = false, ready = false;
};

}  // namespace knead::xr
