// SIGINT (Ctrl-C), SIGTERM and SIGHUP request the end of a run. A second SIGINT or SIGTERM, at
// least half a second later, terminates the program.
#pragma once

namespace knead {

void watch_interrupts();
int interrupted();  // signal number; 0: none

// Defers signals that would terminate the program until the last instance is destroyed, so that
// writes to disk complete. Watched and ignored signals are unaffected.
class EndHeld {
  public:
    EndHeld();
    ~EndHeld();
    EndHeld(const EndHeld&) = delete;
    EndHeld& operator=(const EndHeld&) = delete;

    static bool pending();  // true if a signal is deferred: cancel long writes
};

}  // namespace knead
