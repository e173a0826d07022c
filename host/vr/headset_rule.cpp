#include "host/vr/headset_loop.h"

namespace knead {

LiveRule live_rule(const HeadsetLoopRule& rule, std::function<double()> clock,
                   std::function<void(const HandAction&)> acted)
{
    LiveRule live;
    live.make = [device = rule.device](const Setup& setup) { return make_solver(setup, device); };
    live.stepped = live.from_zero = rule.stepped;
    live.stop = rule.stop;
    live.recorded = rule.recorded, live.moving = true;
    live.paused = rule.hands_only, live.waits = !rule.stepped;
    live.clock = std::move(clock);
    live.acted = std::move(acted);
    return live;
}

}  // namespace knead
