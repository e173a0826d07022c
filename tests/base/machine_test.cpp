// What the driver says of a card, by a library that stands in its place.
#include "host/base/machine.h"

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include "host/solver/editable_simulator.h"

namespace knead {
namespace {

class FakeDriver : public testing::Test {
  protected:
    void SetUp() override
    {
        if (gpu_present()) GTEST_SKIP() << "the real one is here";
        // Found from now on by the name that it has, which is the driver's.
        library = dlopen(KNEAD_FAKE_DRIVER, RTLD_NOW | RTLD_LOCAL);
        ASSERT_NE(library, nullptr) << dlerror();
    }
    void TearDown() override
    {
        unsetenv("KNEAD_FAKE_REFUSES");
        if (library) dlclose(library);
    }
    void* library = nullptr;
    const std::string bus = "0000:41:00.0";
};

TEST_F(FakeDriver, TellsACardsNameClocksAndPower)
{
    const std::optional<GpuState> state = gpu_state(bus);
    ASSERT_TRUE(state);
    EXPECT_EQ(state->name, "a card");
    EXPECT_EQ(state->driver, "570.1");
    EXPECT_EQ(state->clock, 1755u);
    EXPECT_EQ(state->max_clock, 1980u);
    EXPECT_EQ(state->memory_clock, 2619u);
    EXPECT_DOUBLE_EQ(state->power_limit, 699.5);
    EXPECT_FALSE(gpu_state("0000:42:00.0")) << "another card";
    EXPECT_FALSE(gpu_state(""));
}

TEST_F(FakeDriver, WhatItDoesNotSayIsLeftOut)
{
    const auto refusing = [&](const char* call) {
        setenv("KNEAD_FAKE_REFUSES", call, 1);
        return gpu_state(bus);
    };
    EXPECT_FALSE(refusing("init"));
    EXPECT_FALSE(refusing("handle"));
    EXPECT_EQ(refusing("name")->name, "");
    EXPECT_EQ(refusing("driver")->driver, "");
    const std::optional<GpuState> no_power = refusing("power");
    ASSERT_TRUE(no_power);
    EXPECT_EQ(no_power->power_limit, 0);
    EXPECT_EQ(no_power->clock, 1755u);
}

}  // namespace
}  // namespace knead
