// The back ends whose Gaussians follow the clay.
#pragma once
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "host/solver/editable_simulator.h"
#include "host/solver/reference.h"

namespace knead {

struct Follower {
    const char* name;
    std::unique_ptr<Simulator> (*make)(const Setup&);
    bool device = false;
};
const Follower follower_float{
    "float", [](const Setup&s) -> std::unique_ptr<Simulator> { return cpu_solver(s); }},
    follower_reference{
        "reference",
        [](const Setup&s) -> std::unique_ptr<Simulator> { return std::make_unique<Reference>(s); }},
    follower_cuda{
        "cuda", [](const Setup&s) -> std::unique_ptr<Simulator> { return gpu_solver(s, 0); }, true};
inline std::string name_of(const testing::TestParamInfo<Follower>& at) { return at.param.name; }

// Its tests skip a device where there is none.
class Following : public testing::TestWithParam<Follower> {
  protected:
    void SetUp() override
    {
        if (GetParam().device && !gpu_present()) GTEST_SKIP() << "no CUDA device";
    }
    std::unique_ptr<Simulator> make(const knead::Setup& s) { return GetParam().make(s); }
};

}  // namespace knead
