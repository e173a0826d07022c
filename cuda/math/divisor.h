// Division by an integer that is used as a divisor repeatedly.
#pragma once
#include <bit>
#include <cstdint>

#include "cuda/math/hd.h"

namespace knead {

// n / d for 0 <= n < 2^31 and d >= 1, by a product and a shift in place of twenty GPU instructions.
// With 2^bits >= d, factor d = 2^(31 + bits) + e, e < 2^bits, so that the product is too large by
// less than 1 / d.  [Granlund and Montgomery, PLDI 1994, theorem 4.2]
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
