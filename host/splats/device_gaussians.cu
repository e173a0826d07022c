#include <algorithm>
#include <utility>
#include <vector>

#include "cuda/splats/deform.cuh"
#include "host/splats/device_gaussians.cuh"

namespace knead {

using namespace gpu;

MovedSplats KeptGaussians::moved(const KeptGaussians* before, float ahead) const
{
    constexpr int each = MovedGaussians::floats_each;
    MovedSplats m{count, rows.data(), each, rows.data() + 3, each};
    if (before && ahead > 0)
        m.centre_before = before->rows.data(), m.F_before = before->rows.data() + 3,
        m.ahead = ahead;
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
    std::vector<float> rows = rows_of(*kept_);
    if (before_ && frame.ahead > 0) {
        const std::vector<float> old = rows_of(*before_);
        for (std::size_t k = 0; k < rows.size(); ++k)
            rows[k] += frame.ahead * (rows[k] - old[k]);  // gone_on()
    }
    frame.moved_centre.resize(count()), frame.moved_F.resize(count());
    for (std::size_t i = 0; i < count(); ++i) {
        const float* const r = rows.data() + each * i;
        frame.moved_centre[i] = {r[0], r[1], r[2]};
        frame.moved_F[i] = {{r[3], r[4], r[5]}, {r[6], r[7], r[8]}, {r[9], r[10], r[11]}};
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
