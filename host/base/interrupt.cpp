#include "host/base/interrupt.h"

#include <csignal>
#include <ctime>

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

}  // namespace

void watch_interrupts()
{
    std::signal(SIGINT, note_signal);
    std::signal(SIGTERM, note_signal);
    // Under nohup it is ignored, and stays so.
    if (std::signal(SIGHUP, note_signal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
}

int interrupted() { return int(caught); }

}  // namespace knead
