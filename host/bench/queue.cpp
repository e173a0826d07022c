// Frames submitted one ahead, as in a session: the device never waits for the host, and the host
// waits only for completed frames.

#include "host/bench/bench.h"
#include "host/run/run.h"

namespace knead {

QueuedFrames queued(const Scene& scene, Device device, const HandSource* hands, int first,
                    int frames, bool surfaces)
{
    constexpr int warm_up = 4;
    const std::unique_ptr<Simulator> solver = make_solver(scene.setup, device);
    SessionLoopOptions options = loop_options(scene);
    options.first_frame = first;
    options.frames = std::min(frames + warm_up, frames_wanted(scene, hands, 0) - first);
    QueuedFrames all;
    if (options.frames <= warm_up + 1) return all;
    SessionLoop loop(*solver, recorded_motion(hands, scene.hands), options);
    if (surfaces) loop.launch_surfaces();
    double start = 0;
    long waits = 0, substeps = 0;
    loop.observe([&](const FrameResult& f) {
        if (f.number == 2) loop.submit_ahead();  // the execution mode of frames is fixed by now
        if (f.number == warm_up) start = wall_seconds();
        if (f.number > warm_up + 1) waits += f.waits;  // submitted after `start`
        if (f.number > warm_up) substeps += f.stats.substeps;
    });
    loop.run();
    if (loop.failure()) std::rethrow_exception(loop.failure());
    all.frames = loop.last().number - warm_up;
    if (all.frames < 1) return {};
    all.frame = (wall_seconds() - start) / all.frames;
    all.waits = double(waits) / all.frames;
    all.substeps = double(substeps) / all.frames;
    all.gaussians = solver->gaussians();
    return all;
}

}  // namespace knead
