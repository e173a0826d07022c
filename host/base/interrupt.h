// Ctrl-C, SIGTERM, and SIGHUP of a terminal that closes ask a run to end; another one of the first
// two, half a second later or more, ends the program at once.
#pragma once

namespace knead {

void watch_interrupts();
int interrupted();  // the signal's number, 0 for none

}  // namespace knead
