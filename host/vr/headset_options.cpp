#include "host/vr/headset_loop.h"

namespace knead {

LiveOptions live_options(const HeadsetLoopOptions& options, std::function<double()> clock)
{
    LiveOptions live;
    live.make_solver = [device = options.device](const Setup& setup) {
        return make_solver(setup, device);
    };
    live.stepped = live.restarts_time = options.stepped;
    live.should_stop = options.should_stop;
    live.recorded = options.recorded, live.with_motion = true;
    live.paused = options.hands_only, live.manual_start = !options.stepped;
    live.clock = std::move(clock);
    live.session = options.session, live.protects = options.protects;
    return live;
}

}  // namespace knead
