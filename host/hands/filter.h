// From what the tracker said to what moves the clay: filters of one hand's joints, and recorded
// hands sampled at any time in the simulation's frame.
#pragma once
#include <array>
#include <deque>
#include <vector>

#include "host/hands/hand_size.h"
#include "host/hands/hands_options.h"

namespace knead {

// One hand, frame by frame, as it comes from the tracker. All filters are causal.
//   none      the tracker's poses
//   average   mean over the last 0.2 s, each frame weighted by its duration (the paper's)
//   adaptive  low-pass whose cutoff rises with each joint's speed: calm at rest, quick in motion
//             (after Casiez, Roussel and Vogel, "1 Euro Filter", CHI 2012)
class HandFilter {
  public:
    explicit HandFilter(Filter filter) : filter_(filter) {}

    // The filtered hand at `time` [s]. A joint that is not valid, or not finite, moves along with
    // the wrist; a hand without a valid wrist counts as untracked and keeps its last poses. Frames
    // whose time does not rise add nothing.
    Hand filter(const Hand& hand, double time);

    // False while untracked and for 0.2 s after the hand appeared, or after one of its joints
    // moved farther than leap_distance() in a frame: until then it must not touch anything.
    bool steady() const;
    // How often a hand that is tracked was taken for a new one because its frames come too seldom:
    // more than a quarter of a second apart, or so far apart that a joint may have moved farther
    // than `farthest_step` by itself.
    long slow_restarts() const { return slow_restarts_; }
    // The share of its radii that it should touch with: 0 until it is steady, then it grows to 1
    // in 0.25 s, for it may have come back inside of clay.
    float size() const;
    // How large the hand is against the default one.
    Stretch<float> stretch() const { return hand_size_.stretch(); }

    // What a joint may move from one frame to the next [m] after `duration` [s]: as far as a fast
    // hand comes, but no less than the tracker's noise, and no more than after which it may as well
    // be another hand.
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
        float turn;     // low-passed speed of turning [1/s]
    };
    Hand completed(const Hand& hand) const;
    void start(const Hand& hand, double time);
    void average(const Hand& hand, double time);
    void adapt(const Hand& hand, float duration);

    Filter filter_;
    bool present_ = false;
    long slow_restarts_ = 0;
    double time_ = -1e30, appeared_ = 0;  // of the last frame; of the last (re)appearance [s]
    Hand raw_, out_;                      // the last frame, unfiltered and filtered
    std::array<bool, joint_count> seen_{};
    std::deque<Past> past_;
    std::array<Speed, joint_count> speed_{};
    HandSize hand_size_;
};

// What a filter costs and what it is good for, measured by driving it.
struct Response {
    double ramp;    // lag behind a hand moving at 0.3 m/s [s]
    double sine;    // lag behind a sway of 5 cm at 1 Hz [s]
    double jitter;  // share of 1.5 mm (rms) white noise that is left at rest [1]
};
Response response(Filter filter, double rate);  // rate in frames per second
// Response::ramp alone.
double lag(Filter filter, double rate);

// Tracked hands as they come: filtered once, and sampled at any time between those that came.
class HandStream {
  public:
    explicit HandStream(const HandsOptions& options);

    // The next frame, in the tracker's frame of reference. One whose time does not rise, or is not
    // a number, adds nothing.
    void push(const HandFrame& frame);
    // No more will come: after the last frame no hand is active. Before that hands stay where they
    // were last seen, for a quarter of a second active.
    void close() { open_ = false; }
    // Times before `time` [s] will not be asked for any more.
    void forget(double time);
    bool empty() const { return frames_.empty(); }
    // Of both hands, see HandFilter.
    long slow_restarts() const
    {
        return filters_[left].slow_restarts() + filters_[right].slow_restarts();
    }
    double newest() const { return frames_.back().time; }  // [s]

    // Fills the joints, hand by hand, in the simulation's frame: at + zoom * p. Before the first
    // frame and after the last the hands stand still, at the origin where none came. A hand is
    // active where it is present in the rule and steady on both sides of `time`. `size` is the
    // share of its radii that each has, 0 where it is not active. Answers whether any is.
    bool sample(double time, Joint<double> joints[2 * joint_count], float size[side_count]) const;
    // How large a hand is then against the default one, at real size.
    Stretch<float> stretch(double time, Side side) const;

  private:
    struct Frame {
        double time;
        std::array<Joint<float>, 2 * joint_count> joints;
        bool steady[side_count];
        float size[side_count];
        Stretch<float> stretch[side_count];
    };
    // The frames about a time, and the share of the way from the first to the second. There are
    // some.
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

// A whole recording, sampled as a stream that is closed. Time runs as in the time stamps.
class HandSource {
  public:
    // Throws InputError for a recording that check() refuses.
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
