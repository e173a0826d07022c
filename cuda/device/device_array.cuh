// Owning array in device memory: movable, not copyable, of fixed size.
#pragma once
#include <cstring>
#include <utility>
#include <vector>

#include "cuda/device/launch.cuh"
#include "cuda/math/span.h"

namespace knead::gpu {

// Waits for the default stream. A clear, and possibly a copy from the host, returns before it is
// complete; the streams of graph.cuh do not synchronise with it and could write first.
inline void settle(const char* what) { check(cudaStreamSynchronize(nullptr), what); }

// Copies from the host; complete before any later launch.
template <class T>
void upload(T* to, const T* from, std::size_t count)
{
    if (count == 0) return;
    check(cudaMemcpy(to, from, count * sizeof(T), cudaMemcpyDefault), "upload");
    settle("upload");
}

template <class T>
class DeviceArray {
  public:
    DeviceArray() = default;
    // Zeroed. An empty array owns nothing.
    explicit DeviceArray(std::size_t n) : count(n)
    {
        if (n == 0) return;
        check(cudaMalloc(reinterpret_cast<void**>(&first), bytes()), "device memory");
        check(cudaMemset(first, 0, bytes()), "device memory");
        settle("device memory");
    }
    explicit DeviceArray(const std::vector<T>& from) : DeviceArray(from.size())
    {
        upload(first, from.data(), count);
    }
    DeviceArray(DeviceArray&& other) noexcept
        : first(std::exchange(other.first, nullptr)), count(std::exchange(other.count, 0))
    {
    }
    DeviceArray& operator=(DeviceArray&& other) noexcept
    {
        std::swap(first, other.first), std::swap(count, other.count);
        return *this;
    }
    ~DeviceArray() { cudaFree(first); }

    T* data() const { return first; }
    std::size_t size() const { return count; }
    std::size_t bytes() const { return count * sizeof(T); }
    Span<T> span() const { return {first, int(count)}; }
    std::vector<T> downloaded() const
    {
        std::vector<T> to(count);
        if (count) check(cudaMemcpy(to.data(), first, bytes(), cudaMemcpyDefault), "download");
        return to;
    }

  private:
    T* first = nullptr;
    std::size_t count = 0;
};

// One T in pinned memory, accessible to host and device, for asynchronous copies.
template <class T>
class Pinned {
  public:
    explicit Pinned(std::size_t n = 1) : count(n)
    {
        if (n == 0) return;
        check(cudaMallocHost(reinterpret_cast<void**>(&first), n * sizeof(T)), "pinned memory");
        std::memset(static_cast<void*>(first), 0, n * sizeof(T));
    }
    Pinned(const Pinned&) = delete;
    Pinned& operator=(const Pinned&) = delete;
    ~Pinned() { cudaFreeHost(first); }

    T* data() const { return first; }
    T* operator->() const { return first; }
    T& operator[](std::size_t i) const { return first[i]; }
    std::size_t size() const { return count; }
    std::size_t bytes() const { return count * sizeof(T); }

  private:
    T* first = nullptr;
    std::size_t count = 0;
};

}  // namespace knead::gpu
