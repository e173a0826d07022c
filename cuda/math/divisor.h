// A whole number that others are divided by more than once.
#pragma once
#include <bit>
#include <cstdint>

#include "cuda/math/hd.h"

namespace knead {

// n / d for n from 0 to 2^31 - 1 and d from 1 on, by a product and a shift where the GPU would take
// twenty instructions. With 2^bits >= d, factor d = 2^(31 + bits) + e, e < 2^bits, so that the
// product is too large by less than 1 / d.  [Granlund and Montgomery, PLDI 1994, theorem 4.2]
struct Divisor {
    unsigned factor;
    int shift;
    HD explicit Divisor(int d)
    {
        const auto by = unsigned(d > 1 ? d : 1);
        shift = 31 + int(std::bit_width(by - 1));
        factor = unsigned(((std::uint64_t(1) << shift) + by - 1) / by);
    }
    HD int quotient(int n) const { return int(std::uint64_t(unsigned(n)) * factor >> shift); }
};

}  // namespace knead
