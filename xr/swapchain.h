// A queue of GL textures that the runtime shows.
#pragma once
#include <cstdint>
#include <vector>

#include "xr/api.h"

namespace knead::xr {

// GL formats, by their numbers in the GL registry, best first: those that the painters write.
extern const std::vector<std::int64_t> colour_formats, depth_formats;
bool is_srgb(std::int64_t format);
// The first of `liked` that is offered; 0: none.
std::int64_t chosen_format(const std::vector<std::int64_t>& liked,
                           const std::vector<std::int64_t>& offered);

class Swapchain {
  public:
    Swapchain(Api& api, XrSession session, std::int64_t format, XrSwapchainUsageFlags usage,
              int width, int height);
    ~Swapchain();
    Swapchain(const Swapchain&) = delete;

    // A texture that may be drawn into, until release(); 0: the runtime still reads it after `wait`
    // seconds. It remains acquired, and the next call waits again.
    unsigned acquire(double wait);
    void release();
    bool held() const { return ready; }  // may be drawn into
    // As layers name it: of its sides the share `scale`, rounded, from the lower left corner.
    XrSwapchainSubImage part(float scale) const;

  private:
    Api& api;
    XrSwapchain chain = XR_NULL_HANDLE;
    int width, height;
    std::vector<unsigned> textures;
    std::uint32_t index = 0;  // of the texture that is acquired
    bool acquired = false, ready = false;
};

}  // namespace knead::xr
