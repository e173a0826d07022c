// Other programs: what they say, and how they end.
#include "host/base/child.h"

#include <gtest/gtest.h>

#include <chrono>

namespace knead {
namespace {

TEST(Child, ItsOutputIsKeptUpToAMebibyteAndItsEndIsTold)
{
    std::string said;
    EXPECT_EQ(output_of({"sh", "-c", "echo one; exit 7"}, said), 7);
    EXPECT_EQ(said, "one\n");
    said.clear();
    EXPECT_EQ(output_of({"sh", "-c", "head -c 3000000 /dev/zero"}, said, 60), 0);
    EXPECT_GE(said.size(), std::size_t(1) << 20);
    EXPECT_LE(said.size(), (std::size_t(1) << 20) + 4096);
    EXPECT_EQ(output_of({"/no/such/program"}, said), 127);
}

TEST(Child, WhatEndsByASignalOrTooLateIsToldApart)
{
    std::string said;
    EXPECT_EQ(output_of({"sh", "-c", "echo begun; kill -SEGV $$"}, said), ended_by_signal + 11);
    EXPECT_EQ(said, "begun\n");
    const auto begun = std::chrono::steady_clock::now();
    EXPECT_EQ(output_of({"sh", "-c", "exec sleep 60"}, said, 0.2), ended_late);
    EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(30));
}

}  // namespace
}  // namespace knead
