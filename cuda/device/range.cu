// Separate from launch.cuh, because NVTX's header takes longer to compile than most of its users.
#include <nvtx3/nvtx3.hpp>

#include "cuda/device/launch.cuh"

namespace knead::gpu {
namespace {

struct ProfilerDomain {
    static constexpr const char* name = "knead";
};

}  // namespace

ProfilerRange::ProfilerRange(const char* name)
{
    nvtxDomainRangePushEx(nvtx3::domain::get<ProfilerDomain>(),
                          nvtx3::event_attributes{name}.get());
}
ProfilerRange::~ProfilerRange() { nvtxDomainRangePop(nvtx3::domain::get<ProfilerDomain>()); }

}  // namespace knead::gpu
