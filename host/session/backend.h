// --device auto | cuda | cuda:N | cpu | cpu:double; the last is the Reference, without sleeping.
#pragma once
#include <memory>
#include <string>

#include "host/solver/editable_simulator.h"

namespace knead {

enum class DeviceKind { automatic, cuda, cpu, cpu_double };
struct Device {
    DeviceKind kind = DeviceKind::automatic;
    int index = 0;  // of the CUDA device
};

Device parse_device(const std::string& text);  // throws UsageError
// Resolves "auto": the GPU if there is one, else the CPU. Both functions throw ResourceError if the
// requested GPU is not available, make_solver() also if memory is short.
Device resolved(Device device);
std::unique_ptr<Simulator> make_solver(const Setup& setup, Device device);

}  // namespace knead
