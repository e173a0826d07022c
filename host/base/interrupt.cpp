#include "host/base/interrupt.h"

#include <csignal>
#include <ctime>
#include <iterator>
#include <mutex>

namespace knead {
namespace {

volatile std::sig_atomic_t caught = 0;
volatile double since = 0;  // [s]

double now()  // async-signal-safe
{
    timespec t{};
    clock_gettime(CLOCK_MONOTONIC, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

extern "C" void note_signal(int number)
{
    // `timeout` and some terminals send the same signal twice: to the process and to its group.
    constexpr double same = 0.5;
    if (!caught) {
        since = now();
        caught = number;
    } else if (number != SIGHUP && now() - since > same) {
        std::signal(number, SIG_DFL);
        std::raise(number);
    }
}

// Of EndHeld. Signal dispositions are per process, and so is this state.
constexpr int signals[] = {SIGINT, SIGTERM, SIGHUP};
std::mutex holding;
int holders = 0;
void (*before[std::size(signals)])(int);
volatile std::sig_atomic_t held_back = 0;  // signal received while held

extern "C" void hold_back(int number) { held_back = number; }

}  // namespace

EndHeld::EndHeld()
{
    const std::lock_guard<std::mutex> lock(holding);
    if (holders++ > 0) return;
    held_back = 0;
    for (std::size_t i = 0; i < std::size(signals); ++i) {
        before[i] = std::signal(signals[i], hold_back);
        if (before[i] != SIG_DFL) std::signal(signals[i], before[i]);
    }
}

EndHeld::~EndHeld()
{
    const std::lock_guard<std::mutex> lock(holding);
    if (--holders > 0) return;
    for (std::size_t i = 0; i < std::size(signals); ++i)
        if (before[i] == SIG_DFL) std::signal(signals[i], SIG_DFL);
    if (held_back) std::raise(held_back);
}

bool EndHeld::pending() { return held_back != 0; }

void watch_interrupts()
{
    std::signal(SIGINT, note_signal);
    std::signal(SIGTERM, note_signal);
    // nohup sets SIGHUP to ignored; keep that.
    if (std::signal(SIGHUP, note_signal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
}

int interrupted() { return int(caught); }

}  // namespace knead
