#include "host/run/depths.h"

#include <algorithm>

namespace knead {

Depths depths_of(std::vector<double> found)
{
    Depths d;
    d.count = long(found.size());
    if (found.empty()) return d;
    std::sort(found.begin(), found.end());
    for (double x : found) d.mean += x / double(found.size());
    d.p99 = found[std::size_t(0.99 * double(found.size() - 1))];
    d.max = found.back();
    return d;
}

void DepthCount::add(const std::vector<double>& depths)
{
    for (double d : depths) {
        ++bins[std::min(std::size_t(d / bin), bins.size() - 1)];
        ++count, sum += d, max = std::max(max, d);
    }
}

Depths DepthCount::summary() const
{
    Depths all{count, count ? sum / double(count) : 0, 0, max};
    long seen = 0;
    for (std::size_t i = 0; i < bins.size() && seen * 100 < count * 99; ++i)
        seen += bins[i], all.p99 = std::min(bin * double(i + 1), max);
    return all;
}

}  // namespace knead
