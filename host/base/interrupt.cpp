#include "host/base/interrupt.h"

#include <csignal>
#include <ctime>
#include <iterator>
#include <mutex>

namespace knead {
namespace {

volatile std::sig_atomic_t caught = 0;
volatile double since = 0;  // [s]

double now()  // may be asked where a signal is handled
{
    timespec t{};
    clock_gettime(CLOCK_MONOTONIC, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

extern "C" void note_signal(int number)
{
    // `timeout` and some terminals send the same signal twice at once: to the program, and to the
    // group that it is in.
    constexpr double same = 0.5;
    if (!caught) {
        since = now();
        caught = number;
    } else if (number != SIGHUP && now() - since > same) {
        std::signal(number, SIG_DFL);
        std::raise(number);
    }
}

// Of EndHeld. Signals are the process's, so what holds them is, too.
constexpr int signals[] = {SIGINT, SIGTERM, SIGHUP};
std::mutex holding;
int holders = 0;
void (*before[std::size(signals)])(int);
volatile std::sig_atomic_t held_back = 0;  // the signal that came meanwhile

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

bool EndHeld::asked() { return held_back != 0; }

void watch_interrupts()
{
    std::signal(SIGINT, note_signal);
    std::signal(SIGTERM, note_signal);
    // Under nohup it is ignored, and stays so.
    if (std::signal(SIGHUP, note_signal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
}

int interrupted() { return int(caught); }

}  // namespace knead
