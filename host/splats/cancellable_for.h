// Cancellable loops, for long work without a visible result: each polls frame.stopped() every few
// milliseconds and returns false if the frame was stopped.
#pragma once
#include <algorithm>
#include <vector>

#include "host/base/parallel.h"
#include "host/splats/raster.h"

namespace knead {

constexpr std::size_t poll_interval = 1 << 15;  // elements between two polls

// Calls one(i) for every i below n.
template <class One>
bool for_each_unless_stopped(std::size_t n, const SplatFrame& frame, One&& one)
{
    for (std::size_t from = 0; from < n; from += poll_interval) {
        if (frame.stopped()) return false;
        const std::size_t to = std::min(n, from + poll_interval);
        for (std::size_t i = from; i < to; ++i) one(i);
    }
    return true;
}

// The same, in parallel.
template <class One>
bool parallel_for_unless_stopped(std::size_t n, const SplatFrame& frame, One&& one)
{
    constexpr std::size_t block = 4096;
    const long blocks = long((n + block - 1) / block);
    parallel_for(blocks, LoopOptions{.chunk = 1}, [&](long b) {
        if (frame.stopped()) return;
        const std::size_t from = std::size_t(b) * block, to = std::min(n, from + block);
        for (std::size_t i = from; i < to; ++i) one(i);
    });
    return !frame.stopped();
}

// v.resize(n). First-touched memory costs a second per few GiB.
template <class T>
bool resize_unless_stopped(std::vector<T>& v, std::size_t n, const SplatFrame& frame)
{
    v.reserve(n);
    while (v.size() < n) {
        if (frame.stopped()) return false;
        v.resize(std::min(n, v.size() + poll_interval));
    }
    return true;
}

// Resizes the arrays of an eye's picture.
inline bool resize_unless_stopped(Picture& picture, const Eye<float>& eye, const SplatFrame& frame)
{
    picture.width = eye.width, picture.height = eye.height;
    const std::size_t pixels = std::size_t(eye.width) * std::size_t(eye.height);
    return resize_unless_stopped(picture.colour, pixels, frame) &&
           resize_unless_stopped(picture.alpha, pixels, frame) &&
           resize_unless_stopped(picture.depth, pixels, frame);
}

// std::stable_sort, as a bottom-up merge sort.
template <class T, class Less>
bool sort_unless_stopped(std::vector<T>& v, const SplatFrame& frame, Less less)
{
    const std::size_t n = v.size();
    for (std::size_t from = 0; from < n; from += poll_interval) {
        if (frame.stopped()) return false;
        const auto to = long(std::min(n, from + poll_interval));
        std::stable_sort(v.begin() + long(from), v.begin() + to, less);
    }
    std::vector<T> merged;
    for (std::size_t part = poll_interval; part < n; part *= 2) {
        merged.clear(), merged.reserve(n);
        for (std::size_t a = 0; a < n;) {
            const std::size_t a_end = std::min(n, a + part), b_end = std::min(n, a_end + part);
            for (std::size_t b = a_end; a < a_end || b < b_end;) {
                if (merged.size() % poll_interval == 0 && frame.stopped()) return false;
                const bool second = a == a_end || (b < b_end && less(v[b], v[a]));
                merged.push_back(v[second ? b++ : a++]);
            }
            a = b_end;
        }
        v.swap(merged);
    }
    return true;
}

}  // namespace knead
