// Ctrl-C and SIGTERM ask a run to end after its frame; another one, half a second later or more,
// ends the program at once.
#pragma once

namespace knead {

void watch_interrupts();
int interrupted();  // the signal's number, 0 for none

}  // namespace knead
