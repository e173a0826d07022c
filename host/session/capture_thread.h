// The thread on which snapshots become captures, one after the other.
#pragma once
#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <mutex>
#include <thread>

#include "host/session/history.h"

namespace knead {

class CaptureThread {
  public:
    CaptureThread();
    ~CaptureThread();  // waits for all captures
    CaptureThread(const CaptureThread&) = delete;

    // Cheap: creates no thread. `make` may throw; the future has what it threw.
    FutureCapture add(std::function<Capture()> make);

  private:
    void run();

    std::mutex mutex;
    std::condition_variable wake;
    struct Task {
        std::function<Capture()> make;  // holds a snapshot: ends with the task, not with the future
        std::promise<Capture> made;
    };
    std::deque<Task> waiting;
    bool ends = false;
    std::thread thread;
};

}  // namespace knead
