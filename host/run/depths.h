// How deep particles are inside tools, over many frames.
#pragma once
#include <vector>

namespace knead {

// Depths [m] of the particles that projection left inside a tool.
struct Depths {
    long count = 0;
    double mean = 0, p99 = 0, max = 0;
};
Depths depths_of(std::vector<double> found);

// Counts depths in bins of 10 micrometres, with a last bin for all deeper ones: constant memory.
struct DepthCount {
    static constexpr double bin = 1e-5;  // [m]
    static constexpr int bin_count = 20000;
    std::vector<long> bins = std::vector<long>(bin_count);
    long count = 0;
    double sum = 0, max = 0;

    void add(const std::vector<double>& depths);
    Depths summary() const;
};

}  // namespace knead
