#include "host/base/abandonable.h"

#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <thread>
#include <utility>

#include "host/base/machine.h"

namespace knead {
namespace {

std::atomic<bool> any_abandoned = false;

std::chrono::duration<double> time_of(double seconds)
{
    return std::chrono::duration<double>(seconds);
}

}  // namespace

CallGate::Unlocked::Unlocked(CallGate& of, bool watched) : gate(of)
{
    if (watched) gate.since = wall_seconds();
    gate.lock.unlock();
}

CallGate::Unlocked::~Unlocked()
{
    gate.since = 0;
    gate.lock.lock();
}

double CallGate::blocked() const
{
    const double began = since;
    return began > 0 ? wall_seconds() - began : 0;
}

bool CallGate::enter(double seconds) { return lock.try_lock_for(time_of(seconds)); }

struct AbandonableThread::State {
    std::mutex lock;
    std::condition_variable ended;
    bool done = false;
    std::thread thread;
};

AbandonableThread::AbandonableThread(std::function<void()> work) : state(std::make_shared<State>())
{
    state->thread = std::thread([shared = state, work = std::move(work)]() mutable {
        work();
        work = nullptr;
        const std::lock_guard held(shared->lock);
        shared->done = true;
        shared->ended.notify_all();
    });
}

bool AbandonableThread::finished_within(double seconds)
{
    std::unique_lock held(state->lock);
    return state->ended.wait_for(held, time_of(seconds), [&] { return state->done; });
}

AbandonableThread::~AbandonableThread()
{
    if (finished_within(0)) {
        state->thread.join();
    } else {
        any_abandoned = true;
        state->thread.detach();
    }
}

int end_of_process(int code)
{
    if (!any_abandoned) return code;
    std::_Exit(code);
}

}  // namespace knead
