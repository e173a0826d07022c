// OpenGL objects registered with CUDA. Precondition: their context is current.
#pragma once
#include <cuda_gl_interop.h>

#include <utility>

#include "cuda/device/launch.cuh"

namespace knead::gpu {

class Registered {
  public:
    Registered() = default;
    static Registered buffer(unsigned name)
    {
        Registered r;
        check(
            cudaGraphicsGLRegisterBuffer(&r.resource, name, cudaGraphicsRegisterFlagsWriteDiscard),
            "a buffer of OpenGL's");
        return r;
    }
    static Registered texture(unsigned name)
    {
        Registered r;
        check(cudaGraphicsGLRegisterImage(&r.resource, name, GL_TEXTURE_2D,
                                          cudaGraphicsRegisterFlagsWriteDiscard),
              "a texture of OpenGL's");
        return r;
    }
    Registered(Registered&& other) noexcept : resource(std::exchange(other.resource, nullptr)) {}
    Registered& operator=(Registered&& other) noexcept
    {
        std::swap(resource, other.resource);
        return *this;
    }
    ~Registered()
    {
        // After the loss of the context CUDA may report an unknown resource: it is already freed.
        if (resource && cudaGraphicsUnregisterResource(resource) != cudaSuccess) cudaGetLastError();
    }
    operator cudaGraphicsResource_t() const { return resource; }

  private:
    cudaGraphicsResource_t resource = nullptr;
};

// Maps resources for work on the stream: that work runs after all earlier GL commands and before
// all later ones.
class Mapped {
  public:
    Mapped(cudaGraphicsResource_t* all, int count, cudaStream_t on)
        : resources(all), n(count), stream(on)
    {
        check(cudaGraphicsMapResources(n, resources, stream), "sharing with OpenGL");
    }
    Mapped(const Mapped&) = delete;
    ~Mapped()
    {
        if (resources && cudaGraphicsUnmapResources(n, resources, stream) != cudaSuccess)
            cudaGetLastError();
    }
    // Unmaps as the destructor does, but throws on failure.
    void end()
    {
        check(cudaGraphicsUnmapResources(n, std::exchange(resources, nullptr), stream),
              "sharing with OpenGL");
    }

  private:
    cudaGraphicsResource_t* resources;
    int n;
    cudaStream_t stream;
};

}  // namespace knead::gpu
