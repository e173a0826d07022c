// Ctrl-C, SIGTERM, and SIGHUP of a terminal that closes ask a run to end; another one of the first
// two, half a second later or more, ends the program at once.
#pragma once

namespace knead {

void watch_interrupts();
int interrupted();  // the signal's number, 0 for none

// While one lives, a signal that would end the program at once waits until the last is gone: what
// is begun on a disk is brought to its end. Those that are watched or ignored stay so.
class EndHeld {
  public:
    EndHeld();
    ~EndHeld();
    EndHeld(const EndHeld&) = delete;
    EndHeld& operator=(const EndHeld&) = delete;

    static bool asked();  // whether one waits: what is begun had better be given up
};

}  // namespace knead
