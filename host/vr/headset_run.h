// `knead vr` from the opening of the headset to its results. The session has a thread of its own:
// a call into the runtime may never return, and results are not to wait for it.
#pragma once
#include <memory>

#include "host/vr/headset_loop.h"

namespace knead {

class HeadsetRun {
  public:
    HeadsetRun(std::shared_ptr<const LiveScene> scene, const HeadsetLoopOptions& options);
    // The session ends, or is abandoned where the runtime does not answer.
    ~HeadsetRun();

    // Returns when the session is over; when rule.stop() is true, at the latest half a second later
    // if the session makes a call then; when the runtime does not answer for
    // rule.headset.patience. Once. Throws what HeadsetSession::open() throws.
    HeadsetEnd wait();

  private:
    struct Shared;
    std::shared_ptr<Shared> shared;
    HeadsetLoopOptions options;
    std::unique_ptr<AbandonableThread> thread;
};

}  // namespace knead
