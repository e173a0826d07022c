// Filters for the joints of one tracked hand, and recorded or live hands sampled at any time in the
// simulation's frame.
#pragma once
#include <array>
#include <deque>
#include <vector>

#include "host/hands/hand_size.h"
#include "host/hands/hands_options.h"

namespace knead {

// Causal filter for one tracked hand, frame by frame.
//   none      the tracker's poses
//   average   mean over the last 0.2 s, each frame weighted by its duration (the paper's)
//   adaptive  low-pass whose cutoff rises with each joint's speed: smooth at rest, fast in motion
//             (after Casiez, Roussel and Vogel, "1 Euro Filter", CHI 2012)
class HandFilter {
  public:
    explicit HandFilter(Filter filter) : filter_(filter) {}

    // Returns the filtered hand at `time` [s]. Invalid or non-finite joints move with the wrist; a
    // hand without a valid wrist counts as untracked and keeps its last poses. Frames whose time
    // does not increase are ignored.
    Hand filter(const Hand& hand, double time);

    // False while untracked and for 0.2 s after the hand appeared, or after one of its joints moved
    // farther than leap_distance() in a frame. The hand must not be in contact until this is true.
    bool steady() const;
    // Number of times a tracked hand was treated as new because its frames were too far apart: more
    // than a quarter of a second, or long enough for a joint to move farther than `farthest_step`
    // at normal speed.
    long slow_restarts() const { return slow_restarts_; }
    // Factor for the hand's radii: 0 until steady, then rising to 1 within 0.25 s, since the hand
    // may have reappeared inside clay.
    float size() const;
    // Size of the hand relative to the default hand.
    Stretch<float> stretch() const { return hand_size_.stretch(); }

    // Largest plausible motion of a joint between two frames [m] after `duration` [s]: the distance
    // that a fast hand moves, but at least the tracker's noise and at most `farthest_step`. A
    // longer step may belong to another hand.
    static constexpr float fastest = 5;                                   // [m/s]
    static constexpr float shortest_step = 0.02f, farthest_step = 0.25f;  // [m]
    static float leap_distance(double duration)
    {
        return clamp(fastest * float(duration), shortest_step, farthest_step);
    }

  private:
    struct Past {
        double time, duration;  // [s]
        Hand hand;
    };
    struct Speed {
        Vec3<float> v;  // low-passed velocity [m/s]
        float turn;     // low-passed angular speed [1/s]
    };
    Hand completed(const Hand& hand) const;
    void start(const Hand& hand, double time);
    void average(const Hand& hand, double time);
    void adapt(const Hand& hand, float duration);

    Filter filter_;
    bool present_ = false;
    long slow_restarts_ = 0;
    double time_ = -1e30, appeared_ = 0;  // of last frame, of last (re)appearance [s]
    Hand raw_, out_;                      // the last frame, unfiltered and filtered
    std::array<bool, joint_count> seen_{};
    std::deque<Past> past_;
    std::array<Speed, joint_count> speed_{};
    HandSize hand_size_;
};

// Lag and noise of a filter, measured with test signals.
struct Response {
    double ramp;    // lag behind a hand moving at 0.3 m/s [s]
    double sine;    // lag behind a sway of 5 cm at 1 Hz [s]
    double jitter;  // fraction of 1.5 mm (rms) white noise that remains at rest [1]
};
Response response(Filter filter, double rate);  // rate [frames/s]
// Response::ramp alone.
double lag(Filter filter, double rate);

// Live tracked hands: filtered once on arrival, and sampled at any time between frames.
class HandStream {
  public:
    explicit HandStream(const HandsOptions& options);

    // Appends the next frame, in the tracker's frame of reference. Ignored if its time does not
    // increase or is NaN.
    void push(const HandFrame& frame);
    // Ends the stream: after the last frame no hand is active. While open, hands keep their last
    // pose, and stay active for a quarter of a second.
    void close() { open_ = false; }
    // Discards data needed only before `time` [s]. Precondition of sample(): not earlier.
    void forget(double time);
    bool empty() const { return frames_.empty(); }
    // For both hands; see HandFilter.
    long slow_restarts() const
    {
        return filters_[left].slow_restarts() + filters_[right].slow_restarts();
    }
    double newest() const { return frames_.back().time; }  // [s]

    // Fills the joints, hand by hand, in the simulation's frame: at + zoom * p. Before the first
    // frame and after the last the hands are at rest, and at the origin if there is no frame. A
    // hand is active if it is present in the options and steady in the frames on both sides of
    // `time`. `size` is the factor for each hand's radii, 0 if inactive. Returns true if any hand
    // is active.
    bool sample(double time, Joint<double> joints[2 * joint_count], float size[side_count]) const;
    // Size of a hand at `time` relative to the default hand, in real units.
    Stretch<float> stretch(double time, Side side) const;

  private:
    struct Frame {
        double time;
        std::array<Joint<float>, 2 * joint_count> joints;
        bool steady[side_count];
        float size[side_count];
        Stretch<float> stretch[side_count];
    };
    // The two frames around a time, and the interpolation parameter between them. Precondition: not
    // empty.
    struct Between {
        const Frame &from, &to;
        double share;
    };
    Between around(double time) const;
    std::deque<Frame> frames_;
    HandFilter filters_[side_count];
    bool present_[side_count];
    double zoom_;
    Vec3<double> at_;
    bool open_ = true;
};

// A whole recording, sampled as a closed stream. Times are the recording's time stamps.
class HandSource {
  public:
    // Throws InputError if check() rejects the recording.
    HandSource(const Recording& recording, const HandsOptions& options);

    double duration() const { return stream_.newest(); }  // [s]
    bool sample(double time, Joint<double> joints[2 * joint_count], float size[side_count]) const
    {
        return stream_.sample(time, joints, size);
    }
    Stretch<float> stretch(double time, Side side) const { return stream_.stretch(time, side); }

  private:
    HandStream stream_;
};

}  // namespace knead
