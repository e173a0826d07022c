// Shared by the splat formats. Readers add splats one by one; those that cannot be drawn are
// counted instead of stored.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "host/files/splat_file.h"

namespace knead {

// Rounds to the nearest integer in a byte.
inline std::uint8_t byte(double value)
{
    return std::uint8_t(std::clamp(std::round(value), 0.0, 255.0));
}

// One splat of a file, after undoing logarithms and logits.
struct RawSplat {
    Vec3<double> centre, scale;
    Quat<double> rotation;  // not normalised
    double opacity;
};

// Throws InputError if there is no splat, saying what was dropped.
void check_any(const SplatFile& file, const std::string& path);
// Drops and counts the splats with a number that is not finite, for readers that fill whole arrays.
// Throws InputError if no splat is left.
void drop_not_finite(SplatFile& file, const std::string& path);

// Indices of the splats along a Morton curve of 1024 steps an axis, for writers: neighbours in
// space become neighbours in the file.  [Morton 1966]
std::vector<std::uint32_t> order_by_place(const SplatCloud& cloud);

class SplatGather {
  public:
    // `degree`: that of the file.
    SplatGather(const std::string& format, int degree);

    // Reserves memory for `count` splats. Precondition: checked against the file's size.
    void reserve(std::size_t count);

    // sh(k) returns coefficient k, in double.
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

    // Throws InputError if no splat is left.
    SplatFile gathered(const std::string& path);

    SplatFile file;

  private:
    bool accepted(const RawSplat& raw);
    void keep(const RawSplat& raw);
};

}  // namespace knead
