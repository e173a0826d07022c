// Recordings made rather than recorded: two hands that press, poke and cut a ball as people do, for
// scenes, tests and benchmarks that need the same hands every time.
#pragma once
#include <string>
#include <vector>

#include "host/base/errors.h"
#include "host/hands/hands.h"

namespace knead {

// How a gesture is tracked, and on what it is done.
struct GestureOptions {
    double rate = 60;        // frames per second, nominal; the time stamps are a little uneven
    double jitter = 0;       // rms displacement of a joint by tracking noise [m]; 1-2 mm is typical
    double latency = 0.038;  // from a pose to its time stamp [s]
    double dropouts = 0;     // chance per hand and frame to lose the hand, for 3 to 10 frames
    double seconds = 0;      // from the first frame to the last; 0: the gesture's own
    double depth = 0;        // deepest penetration as a share of the radius; 0: the gesture's own
    unsigned seed = 1;       // of jitter, uneven times and dropouts
    Vec3<double> centre{};   // of the ball, in the tracker's frame [m]
    double radius = 0.10;    // of the ball [m]
    Topology topology = Topology::h25;  // of the hand whose reach is solved for
};

// What a gesture is made of.
struct Gesture {
    std::string name;
    std::string held[side_count];  // the tool each hand needs, "" for none
    double seconds;                // its own length
    double depth;                  // its own depth, as a share of the radius
};
// squeeze, imprint, pinch, poke, flatten, roll, knead, cut
const std::vector<Gesture>& gestures();

// The recording of a gesture. Paths between postures have minimum jerk (Flash and Hogan 1985);
// where a hand stands is solved with the medial rigs so that they go as deep as asked, and start
// 0.1 m away. Equal rules give equal recordings. Throws InputError for an unknown name, saying the
// known ones, or for a rule out of range.
Recording generate(const std::string& gesture, const GestureOptions& options = {});

}  // namespace knead
