// --device auto | cuda | cuda:N | cpu | cpu:double; the last is the Reference, in which no clay
// rests.
#pragma once
#include <memory>
#include <string>

#include "host/solver/solver.h"

namespace knead {

enum class DeviceKind { automatic, cuda, cpu, cpu_double };
struct Device {
    DeviceKind kind = DeviceKind::automatic;
    int index = 0;  // of the CUDA device
};

Device parse_device(const std::string& text);  // throws UsageError
// "auto" means the GPU where there is one, else the CPU. Throws ResourceError where a GPU is asked
// for and none can be had, or where memory is short.
Device resolved(Device device);
std::unique_ptr<Solver> make_solver(const Setup& setup, Device device);

}  // namespace knead
