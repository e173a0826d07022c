// The back ends that are held against the reference, and what both are given.
#pragma once
#include <gtest/gtest.h>

#include <string>

#include "host/solver/editable_simulator.h"
#include "host/solver/reference.h"

namespace knead {

struct BackEnd {
    const char* name;
    bool device, deterministic;
    std::unique_ptr<EditableSimulator> make(Setup s) const
    {
        s.deterministic = deterministic;
        return device ? gpu_solver(s, 0) : cpu_solver(s);
    }
};
constexpr BackEnd back_ends[] = {
    {"cpu", false, false}, {"cuda", true, false}, {"cuda_deterministic", true, true}};

// Its tests skip a device where there is none.
class AgainstTheReference : public ::testing::TestWithParam<BackEnd> {
  protected:
    void SetUp() override
    {
        if (GetParam().device && !gpu_present()) GTEST_SKIP() << "no CUDA device";
    }
};

// Tests of edits, on the CPU and, with the parameter true, on a GPU, where there is one.
class OnBothDevices : public ::testing::TestWithParam<bool> {
  protected:
    void SetUp() override
    {
        if (GetParam() && !gpu_present()) GTEST_SKIP() << "no CUDA device";
    }
    std::unique_ptr<EditableSimulator> make(const knead::Setup& s) const
    {
        return GetParam() ? gpu_solver(s, 0) : cpu_solver(s);
    }
};
inline std::string device_of(const testing::TestParamInfo<bool>& at)
{
    return at.param ? "cuda" : "cpu";
}

// What is handed over, as float has it, so that the reference sees the numbers that the others see.
inline Setup rounded_to_float(Setup s)
{
    for (auto& p : s.particles) p = cast<double>(cast<float>(p));
    for (auto& m : s.materials) m = cast<double>(cast<float>(m));
    for (auto& t : s.tools) t.friction = double(float(t.friction));
    s.gravity = cast<double>(cast<float>(s.gravity));
    s.walls.friction = double(float(s.walls.friction));
    return s;
}

}  // namespace knead
