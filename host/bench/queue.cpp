// Frames as a session would run them: handed over one ahead, so that the device never waits for the
// host, nor the host for the device but for a frame that is over.
#include <chrono>

#include "host/bench/bench.h"
#include "host/session/session.h"
#include "host/surface/gpu_surface.h"

namespace knead {

QueuedFrames queued(const Scene& scene, Device device, const HandSource* hands, int first,
                    int frames, bool surfaces)
{
    using Wall = std::chrono::steady_clock;
    constexpr int warm_up = 4;
    const std::unique_ptr<Solver> solver = make_solver(scene.setup, device);
    std::unique_ptr<GpuSurface> surface;
    if (surfaces && solver->clay())
        surface = std::make_unique<GpuSurface>(scene.setup.particles, scene.setup.materials,
                                               scene.surface);
    const double duration = frame_duration(scene);
    const auto hand_over = [&](int k) {
        solver->submit(motion_in(scene, hands, first + k), duration);
        if (surface) surface->launch(*solver->clay());
    };
    QueuedFrames all;
    Wall::time_point start;
    long waits = 0;
    const int end = std::min(frames + warm_up, frames_wanted(scene, hands, 0) - first);
    if (end <= warm_up + 1) return all;
    for (int k = 0; k < 2; ++k) hand_over(k), solver->collect();  // settle how frames run
    hand_over(2);
    for (int k = 3; k <= end; ++k) {
        const long before = gpu_waits();
        if (k < end) hand_over(k);
        if (k > warm_up) waits += gpu_waits() - before;
        solver->collect();  // the one before
        if (k == warm_up) start = Wall::now();
    }
    all.frames = end - warm_up;
    all.frame = std::chrono::duration<double>(Wall::now() - start).count() / all.frames;
    all.waits = double(waits) / all.frames;
    return all;
}

}  // namespace knead
