// A run of memory on either side, which is looked at and not owned.
#pragma once
#include "cuda/math/hd.h"

namespace knead {

// Looks at memory on either side and owns none of it.
template <class T>
struct Span {
    T* data;
    int count;
    HD T& operator[](int i) const { return data[i]; }
    HD T* begin() const { return data; }
    HD T* end() const { return data + count; }
};

}  // namespace knead
