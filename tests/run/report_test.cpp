// What runs are told with: percentiles, the line of progress, the names of devices.
#include "host/run/report.h"

#include <gtest/gtest.h>

#include "host/base/errors.h"
#include "host/cli/progress.h"
#include "host/session/backend.h"
#include "tests/reason.h"

namespace knead {
namespace {

TEST(Spread, PercentilesAreNearestRanks)
{
    std::vector<double> v;
    for (int i = 100; i >= 1; --i) v.push_back(i);
    const Spread s = spread(v);
    EXPECT_EQ(s.median, 50);
    EXPECT_EQ(s.p95, 95);
    EXPECT_EQ(s.max, 100);
    EXPECT_DOUBLE_EQ(s.mean, 50.5);
    EXPECT_EQ(spread({}).median, 0);
}

TEST(Progress, TheLineTellsRateAndTimeLeft)
{
    const std::string line = progress_line(50, 100, 5);
    EXPECT_NE(line.find("50/100"), std::string::npos);
    EXPECT_NE(line.find("10.0 frames/s"), std::string::npos);
    EXPECT_NE(line.find("5 s left"), std::string::npos);
}

TEST(Device, WordsAreReadStrictly)
{
    EXPECT_EQ(parse_device("cuda:3").index, 3);
    for (const char* word : {"", "CPU", "cuda:", "cuda:x", "cuda:1x", "cuda:-1", "gpu"})
        EXPECT_THROW(parse_device(word), UsageError) << word;
    EXPECT_NE(reason<UsageError>([] { parse_device("gpu:0"); }).find("a GPU is called cuda"),
              std::string::npos);
}

}  // namespace
}  // namespace knead
