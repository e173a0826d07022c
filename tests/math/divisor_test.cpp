// Division by a product and a shift, against division.
#include "cuda/math/divisor.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace knead {
namespace {

TEST(Divisor, DividesWhatItMayAsDivisionDoes)
{
    constexpr int most = 2147483647;
    std::mt19937 draw(1);
    std::vector<int> divisors{most, most - 1, 1 << 30, (1 << 30) + 1, (1 << 30) - 1};
    for (int d = 1; d < 3000; ++d) divisors.push_back(d);
    for (int k = 0; k < 3000; ++k) divisors.push_back(int(draw() >> (1 + draw() % 30)) + 1);
    for (const int d : divisors) {
        const Divisor by(d);
        const auto expect_exact = [&](long long n) {
            if (n >= 0 && n <= most) {
                ASSERT_EQ(by.quotient(int(n)), int(n) / d) << n << " / " << d;
            }
        };
        for (const long long n : {0LL, 1LL, 1LL * most, most - 1LL}) expect_exact(n);
        for (int k = 0; k < 100; ++k) {  // where the quotient changes
            const long long n = 1LL * d * (draw() % (unsigned(most) / unsigned(d) + 1));
            for (const int by_one : {-1, 0, 1}) expect_exact(n + by_one);
        }
    }
}

}  // namespace
}  // namespace knead
