#include "host/vr/headset_loop.h"

namespace knead {

LiveOptions live_options(const HeadsetLoopOptions& options, std::function<double()> clock,
                         std::function<void(const HandAction&)> acted)
{
    LiveOptions live;
    live.make = [device = options.device](const Setup& setup) {
        return make_solver(setup, device);
    };
    live.stepped = live.from_zero = options.stepped;
    live.stop = options.stop;
    live.recorded = options.recorded, live.moving = true;
    live.paused = options.hands_only, live.waits = !options.stepped;
    live.clock = std::move(clock);
    live.acted = std::move(acted);
    return live;
}

}  // namespace knead
