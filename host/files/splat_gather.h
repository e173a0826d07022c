// What the formats of splats share. Read, splats come in one by one, and what cannot be drawn is
// counted instead of kept.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "host/files/splat_file.h"

namespace knead {

// The nearest whole number that a byte holds.
inline std::uint8_t byte(double value)
{
    return std::uint8_t(std::clamp(std::round(value), 0.0, 255.0));
}

// One splat as a file has it, past logarithms and logits.
struct RawSplat {
    Vec3<double> centre, scale;
    Quat<double> rotation;  // of any length
    double opacity;
};

class SplatGather {
  public:
    // `degree` is the file's.
    SplatGather(const std::string& format, int degree);

    // Memory for `count` splats, which the file has been found to hold.
    void reserve(std::size_t count);

    // sh(k) answers with coefficient k, in double.
    template <class Sh>
    void add(const RawSplat& raw, Sh&& sh)
    {
        if (!accepted(raw)) return;
        const std::size_t before = file.cloud.sh.size();
        bool finite = true;
        for (int k = 0; k < harmonics(file.cloud.degree); ++k) {
            const Vec3<float> c = cast<float>(sh(k));
            finite = finite && std::isfinite(c.x) && std::isfinite(c.y) && std::isfinite(c.z);
            file.cloud.sh.push_back(c);
        }
        if (finite) return keep(raw);
        file.cloud.sh.resize(before);
        ++file.repairs.not_finite;
    }

    // Throws InputError where nothing is left.
    SplatFile gathered(const std::string& path);

    SplatFile file;

  private:
    bool accepted(const RawSplat& raw);
    void keep(const RawSplat& raw);
};

}  // namespace knead
