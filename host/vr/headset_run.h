// `knead vr` from opening the headset to the results. The session runs on its own thread: a call
// into the runtime may never return and must not block the results.
#pragma once
#include <memory>

#include "host/vr/headset_loop.h"

namespace knead {

class HeadsetRun {
  public:
    HeadsetRun(std::shared_ptr<const LiveScene> scene, const HeadsetLoopOptions& options);
    // Ends the session, or abandons its thread if the runtime does not respond.
    ~HeadsetRun();

    // Call once. Blocks until the session is over, or at most about half a second after stop()
    // returns true, or until the runtime has not responded for HeadsetOptions::patience. Throws as
    // HeadsetSession::open().
    HeadsetEnd wait();

  private:
    struct Shared;
    std::shared_ptr<Shared> shared;
    HeadsetLoopOptions options;
    std::unique_ptr<AbandonableThread> thread;
};

}  // namespace knead
