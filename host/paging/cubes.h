// Partition of space into cubes of one size, each with an integer key.
#pragma once
#include <cmath>
#include <cstdint>

#include "cuda/math/vec.h"

namespace knead {

struct Cubes {
    using Key = std::int64_t;  // rises with z, then y, then x
    double edge;               // [m]

    Int3 of(Vec3<double> x) const
    {
        const auto along = [this](double place) {
            return int(std::floor(clamp(place / edge, -double(middle), double(middle - 1))));
        };
        return {along(x.x), along(x.y), along(x.z)};
    }
    Key key_of(Vec3<double> x) const { return key(of(x)); }
    static Key key(Int3 cube)
    {
        const auto part = [](int n) { return Key(n + middle); };
        return part(cube.z) << 42 | part(cube.y) << 21 | part(cube.x);
    }
    static Int3 at(Key key)
    {
        const auto part = [key](int shift) { return int(key >> shift & 0x1fffff) - middle; };
        return {part(0), part(21), part(42)};
    }

  private:
    static constexpr int middle = 1 << 20;
};

}  // namespace knead
