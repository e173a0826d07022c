#include "interrupt.h"

#include <csignal>

namespace knead {
namespace {

volatile std::sig_atomic_t caught = 0;

extern "C" void note_signal(int number)
{
    caught = number;
    std::signal(number, SIG_DFL);
}

}  // namespace

void watch_interrupts()
{
    std::signal(SIGINT, note_signal);
    std::signal(SIGTERM, note_signal);
}

int interrupted() { return int(caught); }

}  // namespace knead
