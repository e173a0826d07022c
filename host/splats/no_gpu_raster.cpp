// Stubs of the GPU rasteriser for builds without CUDA.
#ifndef KNEAD_HAS_CUDA
#include <stdexcept>

#include "host/splats/device_gaussians.h"
#include "host/splats/gpu_raster.h"

namespace knead {
namespace {

[[noreturn]] void refuse()
{
    throw std::runtime_error("no CUDA device: this build has no CUDA side");
}

}  // namespace

struct GpuRaster::State {};
GpuRaster::GpuRaster(const SplatCloud&, std::size_t, int, std::size_t) { refuse(); }
GpuRaster::~GpuRaster() = default;
bool GpuRaster::serves(const SplatCloud&) const { refuse(); }
void GpuRaster::prepare(const SplatCloud&) { refuse(); }
void GpuRaster::show_prepared() { refuse(); }
void GpuRaster::reserve(std::size_t) { refuse(); }
std::vector<Picture> GpuRaster::pictures(const SplatFrame&) { refuse(); }
void GpuRaster::launch(const SplatFrame&, const gpu::MovedSplats*, const gpu::RasterTarget*, void*)
{
    refuse();
}
int GpuRaster::device() const { refuse(); }
RasterStats GpuRaster::stats() const { refuse(); }
std::vector<double> GpuRaster::replays(int) { refuse(); }
std::vector<StageTime> GpuRaster::stage_times() { refuse(); }
std::size_t GpuRaster::memory() const { refuse(); }
std::size_t GpuRaster::room() const { refuse(); }

DeviceGaussians::DeviceGaussians(std::shared_ptr<gpu::KeptGaussians>,
                                 std::shared_ptr<gpu::KeptGaussians>)
{
    refuse();
}
int DeviceGaussians::device() const { refuse(); }
std::size_t DeviceGaussians::count() const { refuse(); }
void DeviceGaussians::fetch(SplatFrame&) const { refuse(); }
struct GaussianKeeper::State {};
GaussianKeeper::GaussianKeeper() = default;  // never called
GaussianKeeper::~GaussianKeeper() = default;
std::shared_ptr<const DeviceGaussians> GaussianKeeper::kept(const gpu::MovedGaussians&, bool)
{
    refuse();
}

}  // namespace knead
#endif
