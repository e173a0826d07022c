// Which way pictures take from CUDA to OpenGL.
#pragma once
#include <string>

namespace knead {

struct Sharing {
    bool shared = false;
    std::string text;  // for people: which way, and why
};

// Whether the OpenGL context that is current is drawn by CUDA device `device`, -1: the one of the
// calling thread, so that both reach the same memory. KNEAD_SHARE=0 in the environment forbids it.
Sharing sharing(int device);

}  // namespace knead
