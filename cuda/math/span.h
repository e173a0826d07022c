// Non-owning view of contiguous memory on host or device.
#pragma once
#include "cuda/math/hd.h"

namespace knead {

// Non-owning view of contiguous memory on host or device.
template <class T>
struct Span {
    T* data;
    int count;
    HD T& operator[](int i) const { return data[i]; }
    HD T* begin() const { return data; }
    HD T* end() const { return data + count; }
};

}  // namespace knead
