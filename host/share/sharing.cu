#include <cuda_gl_interop.h>

#include <cstdlib>
#include <string>

#include "cuda/device/device.cuh"
#include "host/share/sharing.h"

namespace knead {
namespace {

std::string trouble(int device)
{
    if (const char* said = std::getenv("KNEAD_SHARE"); said && std::string(said) == "0")
        return "KNEAD_SHARE=0";
    try {
        device = gpu::chosen(device);
    } catch (const std::runtime_error& e) {
        return e.what();
    }
    unsigned count = 0;
    int drawing[16];
    const cudaError_t error = cudaGLGetDevices(&count, drawing, 16, cudaGLDeviceListAll);
    if (error != cudaSuccess) {
        cudaGetLastError();
        return std::string("no CUDA device draws OpenGL here (") + cudaGetErrorString(error) + ")";
    }
    for (unsigned i = 0; i < count; ++i)
        if (drawing[i] == device) return "";
    return "CUDA device " + std::to_string(device) + " is not the one that draws OpenGL";
}

}  // namespace

Sharing sharing(int device)
{
    const std::string why = trouble(device);
    if (why.empty()) return {true, "pictures stay on the device: CUDA and OpenGL share memory"};
    return {false, "pictures are copied from CUDA to OpenGL through host memory: " + why};
}

}  // namespace knead
