// Whether CUDA and OpenGL share device memory.
#pragma once
#include <string>

namespace knead {

struct Sharing {
    bool shared = false;
    std::string text;  // message: which path is used, and why
};

// True if CUDA device `device` (-1: the calling thread's device) also drives the current OpenGL
// context. KNEAD_SHARE=0 in the environment disables sharing.
Sharing sharing(int device);

}  // namespace knead
