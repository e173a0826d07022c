#include "host/splats/carried.h"

#include "host/base/parallel.h"

namespace knead {

void append(CarriedSplats& to, const SplatCloud& from, const std::vector<std::uint32_t>& indices)
{
    const std::size_t before = to.count();
    resize(to.cloud, before + indices.size()), to.extent.resize(to.count());
    const int count = int(indices.size());
    parallel_for(count, [&](int k) {
        const std::size_t i = indices[std::size_t(k)], at = before + std::size_t(k);
        const Vec3<float> s = from.scale[i];
        set_splat(to.cloud, at, from, i);
        to.extent[at] = max(s.x, max(s.y, s.z));
    });
}

}  // namespace knead
