// Generated recordings: two hands that press, poke and cut a ball as people do, for scenes, tests
// and benchmarks that need identical hands every time.
#pragma once
#include <string>
#include <vector>

#include "host/base/errors.h"
#include "host/hands/hands.h"

namespace knead {

// Tracking quality and target of a gesture.
struct GestureOptions {
    double rate = 60;        // nominal [frames/s]; the time stamps are slightly uneven
    double jitter = 0;       // rms displacement of a joint by tracking noise [m]; 1-2 mm is typical
    double latency = 0.038;  // from a pose to its time stamp [s]
    double dropouts = 0;     // probability of losing a hand, per frame, for 3 to 10 frames
    double seconds = 0;      // total duration [s]; 0: the gesture's own
    double depth = 0;        // deepest penetration / radius; 0: the gesture's own
    unsigned seed = 1;       // of jitter, uneven times and dropouts
    Vec3<double> centre{};   // of the ball, in the tracker's frame [m]
    double radius = 0.10;    // of the ball [m]
    Topology topology = Topology::h25;  // of the medial hand that the paths are solved for
};

// Definition of a gesture.
struct Gesture {
    std::string name;
    std::string held[side_count];  // the tool each hand needs, "" for none
    double seconds;                // default duration [s]
    double depth;                  // default depth / radius
};
// squeeze, imprint, pinch, poke, flatten, roll, knead, cut
const std::vector<Gesture>& gestures();

// Returns the recording of a gesture. Paths between postures have minimum jerk (Flash and Hogan
// 1985); positions are solved with the medial rigs so that hands penetrate as deep as requested,
// starting 0.1 m away. Equal options give equal recordings. Throws InputError for an unknown name,
// listing the known ones, or for an option out of range.
Recording generate(const std::string& gesture, const GestureOptions& options = {});

}  // namespace knead
