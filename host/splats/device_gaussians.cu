#include <algorithm>
#include <utility>
#include <vector>

#include "cuda/splats/deform.cuh"
#include "cuda/splats/extrapolate.h"
#include "host/splats/device_gaussians.cuh"

namespace knead {

using namespace gpu;

MovedSplats KeptGaussians::moved(const KeptGaussians* before, float extrapolation) const
{
    constexpr int each = MovedGaussians::floats_each;
    MovedSplats m{count, rows.data(), each, rows.data() + 3, each};
    if (before && extrapolation > 0)
        m.centre_before = before->rows.data(), m.F_before = before->rows.data() + 3,
        m.extrapolation = extrapolation;
    return m;
}

DeviceGaussians::DeviceGaussians(std::shared_ptr<KeptGaussians> kept,
                                 std::shared_ptr<KeptGaussians> before)
    : kept_(std::move(kept)), before_(std::move(before))
{
}
int DeviceGaussians::device() const { return kept_->device; }
std::size_t DeviceGaussians::count() const { return std::size_t(kept_->count); }

namespace {

std::vector<float> rows_of(const KeptGaussians& kept)
{
    gpu::wait(kept.written, "splats");
    std::vector<float> rows(std::size_t(MovedGaussians::floats_each) * std::size_t(kept.count));
    if (!rows.empty())
        check(cudaMemcpy(rows.data(), kept.rows.data(), rows.size() * sizeof(float),
                         cudaMemcpyDefault),
              "download");
    return rows;
}

}  // namespace

void DeviceGaussians::fetch(SplatFrame& frame) const
{
    constexpr std::size_t each = MovedGaussians::floats_each;
    check(cudaSetDevice(device()), "device");
    const std::vector<float> rows = rows_of(*kept_);
    std::vector<float> before;
    if (before_ && frame.extrapolation > 0) before = rows_of(*before_);
    const auto column = [](const std::vector<float>& of, std::size_t at) {
        return Vec3<float>{of[at], of[at + 1], of[at + 2]};
    };
    const auto by_then = [&](std::size_t at) {
        const Vec3<float> now = column(rows, at);
        return before.empty() ? now : extrapolated(now, column(before, at), frame.extrapolation);
    };
    frame.moved_centre.resize(count()), frame.moved_F.resize(count());
    for (std::size_t i = 0; i < count(); ++i) {
        const std::size_t at = each * i;
        frame.moved_centre[i] = by_then(at);
        frame.moved_F[i] = {by_then(at + 3), by_then(at + 6), by_then(at + 9)};
    }
}

struct GaussianKeeper::State {
    std::vector<std::shared_ptr<KeptGaussians>> all;
    std::shared_ptr<KeptGaussians> last;
};
GaussianKeeper::GaussianKeeper() : state(std::make_unique<State>()) {}
GaussianKeeper::~GaussianKeeper() = default;

std::shared_ptr<const DeviceGaussians> GaussianKeeper::kept(const MovedGaussians& moved, bool same)
{
    const std::size_t floats = std::size_t(moved.count) * MovedGaussians::floats_each;
    std::erase_if(state->all, [&](const auto& one) { return one->rows.size() < floats; });
    auto free = std::find_if(state->all.begin(), state->all.end(),
                             [](const auto& one) { return one.use_count() == 1; });
    if (free == state->all.end()) {
        auto made = std::make_shared<KeptGaussians>();
        check(cudaGetDevice(&made->device), "device");
        made->rows = DeviceArray<float>(floats + floats / 4);
        state->all.push_back(std::move(made));
        free = state->all.end() - 1;
    }
    KeptGaussians& to = **free;
    to.count = moved.count;
    check(cudaStreamWaitEvent(moved.stream, to.read, 0), "splats");
    if (floats)
        check(cudaMemcpyAsync(to.rows.data(), moved.rows, floats * sizeof(float),
                              cudaMemcpyDeviceToDevice, moved.stream),
              "splats");
    check(cudaEventRecord(to.written, moved.stream), "splats");
    const std::shared_ptr<KeptGaussians> before = std::exchange(state->last, *free);
    const bool goes_on = same && before && before->count == to.count;
    return std::make_shared<const DeviceGaussians>(*free, goes_on ? before : nullptr);
}

}  // namespace knead
