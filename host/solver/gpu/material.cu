// Evaluates materials on the device, one thread per particle.
#include "cuda/device/device_array.cuh"
#include "host/solver/gpu/material.h"

namespace knead {

namespace {

constexpr int threads = 128;

__global__ void functions_kernel(Span<const float> x, Span<Functions<float>> to)
{
    const int i = int(blockIdx.x * blockDim.x + threadIdx.x);
    if (i < x.count) to[i] = functions_of(x[i]);
}

__global__ void answers_kernel(Span<const Particle<float>> particles,
                               Span<const Material<float>> materials, float dt,
                               Span<Answers<float>> to)
{
    const int i = int(blockIdx.x * blockDim.x + threadIdx.x);
    if (i < particles.count) to[i] = answers(particles[i], materials[particles[i].object], dt);
}

template <class T>
Span<const T> const_view(const gpu::DeviceArray<T>& array)
{
    return {array.data(), int(array.size())};
}

}  // namespace

std::vector<Functions<float>> gpu_functions(const std::vector<float>& x)
{
    const gpu::DeviceArray<float> given(x);
    const gpu::DeviceArray<Functions<float>> to(x.size());
    gpu::launch("functions", functions_kernel, gpu::blocks_for(int(x.size()), threads), threads,
                nullptr, const_view(given), to.span());
    return to.downloaded();
}

std::vector<Answers<float>> gpu_answers(const std::vector<Particle<float>>& particles,
                                        const std::vector<Material<float>>& materials, float dt)
{
    const gpu::DeviceArray<Particle<float>> given(particles);
    const gpu::DeviceArray<Material<float>> of(materials);
    const gpu::DeviceArray<Answers<float>> to(particles.size());
    gpu::launch("answers", answers_kernel, gpu::blocks_for(int(particles.size()), threads), threads,
                nullptr, const_view(given), const_view(of), dt, to.span());
    return to.downloaded();
}

}  // namespace knead
