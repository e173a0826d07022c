#include "host/session/backend.h"

#include <charconv>
#include <new>

#include "host/base/errors.h"
#include "host/solver/reference.h"

namespace knead {

Device parse_device(const std::string& text)
{
    if (text == "auto") return {DeviceKind::automatic, 0};
    if (text == "cpu") return {DeviceKind::cpu, 0};
    if (text == "cpu:double") return {DeviceKind::cpu_double, 0};
    if (text == "cuda") return {DeviceKind::cuda, 0};
    int index = -1;
    const char* end = text.data() + text.size();
    if (text.starts_with("cuda:")) {
        const auto [at, problem] = std::from_chars(text.data() + 5, end, index);
        if (problem == std::errc() && at == end && index >= 0) return {DeviceKind::cuda, index};
    }
    throw UsageError("--device: expected auto, cuda, cuda:N, cpu or cpu:double, found \"" +
                     text.substr(0, 60) + "\"" +
                     (text.starts_with("gpu") ? "; a GPU is called cuda" : ""));
}

Device resolved(Device device)
{
    const bool gpu =
        device.kind != DeviceKind::cpu && device.kind != DeviceKind::cpu_double && gpu_present();
    if (device.kind == DeviceKind::automatic) return {gpu ? DeviceKind::cuda : DeviceKind::cpu, 0};
    if (device.kind == DeviceKind::cuda && !gpu)
        throw ResourceError("--device cuda: no CUDA device here (knead doctor says what there is)");
    return device;
}

std::unique_ptr<Simulator> make_solver(const Setup& setup, Device device)
{
    const Device chosen = resolved(device);
    try {
        if (chosen.kind == DeviceKind::cuda) return gpu_solver(setup, chosen.index);
        if (chosen.kind == DeviceKind::cpu_double) return std::make_unique<Reference>(setup);
        return cpu_solver(setup);
    } catch (const std::bad_alloc&) {
        throw ResourceError("the solver needs more memory than is available");
    } catch (const std::runtime_error& e) {
        throw ResourceError(std::string("the solver cannot start: ") + e.what());
    }
}

}  // namespace knead
