#include "host/session/capture_thread.h"

namespace knead {

CaptureThread::CaptureThread() : thread([this] { run(); }) {}

CaptureThread::~CaptureThread()
{
    {
        const std::lock_guard lock(mutex);
        ends = true;
    }
    wake.notify_one();
    thread.join();
}

FutureCapture CaptureThread::add(std::function<Capture()> make)
{
    Task task{std::move(make), {}};
    FutureCapture made = task.made.get_future().share();
    {
        const std::lock_guard lock(mutex);
        waiting.push_back(std::move(task));
    }
    wake.notify_one();
    return made;
}

void CaptureThread::run()
{
    std::unique_lock lock(mutex);
    for (;;) {
        wake.wait(lock, [&] { return ends || !waiting.empty(); });
        if (waiting.empty()) return;
        {
            Task task = std::move(waiting.front());
            waiting.pop_front();
            lock.unlock();
            try {
                Capture made = task.make();
                task.make = {};
                task.made.set_value(std::move(made));
            } catch (...) {
                task.made.set_exception(std::current_exception());
            }
        }
        lock.lock();
    }
}

}  // namespace knead
