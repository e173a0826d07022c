#include "host/hands/gesture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "host/base/json_reader.h"
#include "host/hands/keys.h"

namespace knead {
namespace {

using Vec = Vec3<double>;
constexpr double away = 0.1;   // distance between hand and ball at start and end [m]
constexpr double gap = 0.003;  // distance just before contact [m]

struct Stage {
    Topology topology;
    double radius, depth;  // of the ball, of the deepest penetration [m]
    Part part[side_count];
};

double outward(Side side) { return side == right ? 1 : -1; }

Fingers relaxed()
{
    Fingers f = gripped(0.12);
    for (double& spread : f.spread) spread = 0.05;
    return f;
}

// An idle hand waits beside the ball.
void wait(Stage& stage, Side side, double seconds)
{
    Part& part = stage.part[side];
    part.take(bare(stage.topology, side, 0.08), {-outward(side), 0, 0}, {0, 0, -1});
    part.reach(0, relaxed(), away);
    part.stay(seconds, relaxed());
}

// The palm presses from its side, starting at `t`, for approach + pressing + 1.2 s.
void squeeze_from(Stage& stage, Part& part, double t, double approach, double pressing)
{
    const Fingers closed = wrapped(part.side(), stage.radius);
    const Fingers half = between(relaxed(), closed, 0.6);
    part.take(bare(stage.topology, part.side(), 0.08), {-outward(part.side()), 0, 0}, {0, 0, -1});
    part.reach(t, relaxed(), away);
    t += approach;
    part.reach(t, half, gap);
    t += pressing;
    part.reach(t, closed, -stage.depth);
    part.stay(t + 0.3, closed);
    part.reach(t + 0.7, half, 4 * gap);
    part.reach(t + 1.2, relaxed(), away);
}

void squeeze(Stage& stage)
{
    for (Part& part : stage.part) squeeze_from(stage, part, 0, 0.45, 0.95);
}

// The spread fingers of one hand leave imprints, then both palms squeeze.
void imprint(Stage& stage)
{
    Part& part = stage.part[right];
    Fingers marking = wrapped(right, stage.radius);
    for (int i = 0; i < 5; ++i) {
        marking.spread[i] = 0.2;
        for (double& flex : marking.flex[i]) flex += 0.1;
    }
    marking = within_limits(marking);
    part.take(bare(stage.topology, right, 0.12), {-0.5, -0.7, -0.5}, {-0.2, 0.6, -0.8});
    part.reach(0, relaxed(), away);
    part.reach(0.4, marking, gap);
    part.reach(0.95, marking, -stage.depth);
    part.stay(1.1, marking);
    part.reach(1.5, relaxed(), away);
    squeeze_from(stage, part, 2.25, 0.4, 0.5);
    Part& other = stage.part[left];
    other.take(bare(stage.topology, left, 0.08), {1, 0, 0}, {0, 0, -1});
    other.reach(0, relaxed(), away);
    squeeze_from(stage, other, 2.25, 0.4, 0.5);
}

void pinch(Stage& stage)
{
    wait(stage, left, 2.7);
    const Fingers closed = pinched(right);
    Fingers opened = closed;
    opened.flex[1][0] -= 0.35;
    opened.flex[0][0] -= 0.3;
    opened = within_limits(opened);
    Part& part = stage.part[right];
    part.take(tips(stage.topology, right, opened), {-0.5, -0.75, -0.4}, {-0.3, 0.6, -0.7});
    part.reach(0, opened, away);
    part.reach(0.45, opened, gap);
    part.reach(0.9, opened, -stage.depth);
    part.stay(1.25, closed);
    part.stay(1.75, closed, stage.depth + 0.03);
    part.stay(2.05, opened);
    part.reach(2.7, opened, away);
}

void poke(Stage& stage)
{
    wait(stage, left, 3.5);
    const Fingers grip = gripped(0.8);
    const Grasp rod = stick(right, grip);
    Part& part = stage.part[right];
    double t = 0;
    for (const Vec press : {Vec{-0.35, -0.85, -0.4}, Vec{-0.75, -0.45, -0.5}}) {
        part.take(rod, press, {0, 1, 0});
        part.reach(t, grip, t == 0 ? away : away / 2);
        part.reach(t + 0.4, grip, gap);
        part.reach(t + 0.85, grip, -stage.depth);
        part.reach(t + 1.2, grip, away / 2);
        t += 1.85;
    }
    part.reach(3.5, grip, away);
}

void flatten(Stage& stage)
{
    wait(stage, left, 3.5);
    const Fingers grip = gripped(0.25);
    const Grasp slab = face("slab", right, grip);
    Part& part = stage.part[right];
    part.take(slab, {0, -1, 0}, {0, 0, -1});
    part.reach(0, grip, away);
    part.reach(0.4, grip, gap);
    part.reach(1.1, grip, -0.6 * stage.depth);
    part.reach(1.4, grip, 0.02);
    part.take(slab, {0, -1, 0}, {-0.6, 0, -0.8});
    part.reach(1.8, grip, 0.02);
    part.reach(2.5, grip, -stage.depth);
    part.stay(2.85, grip);
    part.reach(3.5, grip, away);
}

// Flat palms slide to and fro against each other.
void roll(Stage& stage)
{
    for (Part& part : stage.part) {
        const double way = 0.3 * stage.radius * outward(part.side());
        Fingers straight = within_limits({});
        straight.spread[0] = -0.7;  // thumbs clear of the ball: the palms roll it
        part.take(bare(stage.topology, part.side(), 0.08), {-outward(part.side()), 0, 0},
                  {0, 0, -1});
        part.reach(0, straight, away);
        part.reach(0.45, straight, gap);
        // The smallest distance at which no point of the path is deeper than requested.
        double distance = 0;
        for (const double share : {-1.0, -0.5, 0.0, 0.5, 1.0})
            distance =
                std::max(distance, part.distance(straight, -stage.depth, {0, 0, share * way}));
        part.put(0.8, straight, distance);
        double t = 0.8;
        for (const double share : {1.0, -1.0, 1.0, -1.0, 1.0, 0.0}) {
            t += share == 0 ? 0.3 : 0.4;
            part.put(t, straight, distance, {0, 0, share * way});
        }
        part.reach(3.5, straight, away);
    }
}

// Both heels push down and forward, the fingers fold over and draw back: three times.
void knead_both(Stage& stage)
{
    for (Part& part : stage.part) {
        const double beside = 0.75 * stage.radius * outward(part.side());
        const auto slide = [&](double forward) { return Vec{beside, 0, -forward * stage.radius}; };
        Fingers open = relaxed(), fold = gripped(0.45);
        open.spread[0] = fold.spread[0] = -0.5;  // thumbs beside the palms, not touching
        part.take(bare(stage.topology, part.side(), 0.05), {0, -1, 0}, {0, 0, -1});
        part.reach(0, open, away, slide(-0.2));
        for (const double t : {0.0, 1.1, 2.2}) {
            part.reach(t + 0.4, open, gap, slide(-0.2));
            part.reach(t + 0.65, open, -0.8 * stage.depth, slide(0));
            part.reach(t + 0.8, open, -stage.depth, slide(0.2));
            part.reach(t + 0.95, fold, -0.5 * stage.depth, slide(0));
            part.reach(t + 1.1, open, 0.01, slide(-0.2));
        }
        part.reach(3.8, open, away, slide(-0.2));
    }
}

// The blade saws down to the board, pushes one half aside, and comes up between the two. Its edge
// spans a ball of 5 cm radius; a larger ball is cut only where the edge passes.
void cut(Stage& stage)
{
    wait(stage, left, 3.6);
    const Fingers grip = gripped(0.85);
    const Grasp knife = edge("knife", right, grip);
    const Vec aside = cross(knife.press, knife.along);
    // The edge lies 15 mm beyond the middle of the blade, and extends 10 mm further ahead.
    const auto drawn = [&](double way) { return (way - 0.01) * knife.along; };
    const double board = -(stage.radius - 0.015);
    Part& part = stage.part[right];
    part.take(knife, {0, -1, 0}, {0, 0, -1});
    part.reach(0, grip, away);
    part.reach(0.4, grip, gap, drawn(0.015));
    part.put(0.95, grip, 0.2 * stage.radius, drawn(-0.01));
    part.put(1.5, grip, board, drawn(0.005));
    part.put(1.65, grip, board, drawn(0));
    part.put(2.3, grip, board, drawn(0) + 0.025 * aside);
    part.put(3.1, grip, stage.radius + away, drawn(0) + 0.02 * aside);
    part.put(3.6, grip, stage.radius + away, drawn(0) + 0.02 * aside);
}

struct Script {
    Gesture gesture;
    void (*write)(Stage&);
};
const std::vector<Script>& scripts()
{
    static const std::vector<Script> all = {{{"squeeze", {"", ""}, 2.6, 0.22}, squeeze},
                                            {{"imprint", {"", ""}, 4.35, 0.18}, imprint},
                                            {{"pinch", {"", ""}, 2.7, 0.35}, pinch},
                                            {{"poke", {"", "rod"}, 3.5, 0.5}, poke},
                                            {{"flatten", {"", "slab"}, 3.5, 0.9}, flatten},
                                            {{"roll", {"", ""}, 3.5, 0.4}, roll},
                                            {{"knead", {"", ""}, 3.8, 0.45}, knead_both},
                                            {{"cut", {"", "knife"}, 3.6, 1}, cut}};
    return all;
}

// Random numbers identical on every platform: the engine is the standard's, the distributions are
// implemented here.
class Chance {
  public:
    explicit Chance(unsigned seed) : source_(seed) {}
    double uniform() { return double(source_() >> 11) * 0x1p-53; }  // in [0, 1)
    double normal()  // mean 0, variance 1: the sum of twelve
    {
        double sum = -6;
        for (int i = 0; i < 12; ++i) sum += uniform();
        return sum;
    }

  private:
    std::mt19937_64 source_;
};

// Tracking noise of one hand: position and orientation of the wrist and finger angles vary, each
// correlated over 20 ms; bone lengths are constant, since trackers fit a hand model.
class Tremble {
  public:
    explicit Tremble(double jitter) : jitter_(jitter) {}
    void advance(double duration, Chance& chance)
    {
        const double kept = std::exp(-duration / 0.02), fresh = std::sqrt(1 - kept * kept);
        for (double& x : state_) x = kept * x + fresh * chance.normal();
    }
    void shake(Joint<double>& wrist_at, Fingers& fingers) const
    {
        // Factors chosen so that the rms displacement over all joints equals the jitter; covered by
        // a test.
        const double shift = 0.45 * jitter_, turn = 3.2 * jitter_, bend = 5 * jitter_;
        const auto* x = state_;
        wrist_at.p = wrist_at.p + shift * Vec{x[0], x[1], x[2]};
        const Vec axis = turn * Vec{x[3], x[4], x[5]};
        wrist_at.q = knead::unit(Quat<double>{1, axis.x / 2, axis.y / 2, axis.z / 2} * wrist_at.q);
        for (int i = 0; i < 5; ++i)
            for (int k = 0; k < 3; ++k) fingers.flex[i][k] += bend * x[6 + i];
    }

  private:
    double jitter_, state_[11] = {};
};

// Pose of a part at `time`: between two keys along a minimum-jerk path.
Pose at(const Part& part, double time, const Vec& centre, const Tremble& tremble)
{
    const std::vector<Key>& keys = part.keys();
    std::size_t i = 1;
    while (i + 1 < keys.size() && keys[i].time < time) ++i;
    const Key &from = keys[i - 1], &to = keys[i];
    const double t = clamp((time - from.time) / (to.time - from.time), 0.0, 1.0);
    const double s = t * t * t * (10 - 15 * t + 6 * t * t);
    const Quat<double> q = between(from.q, to.q, s);
    Joint<double> wrist_at{q, centre + rotate(q, from.place + s * (to.place - from.place))};
    Fingers fingers = between(from.fingers, to.fingers, s);
    tremble.shake(wrist_at, fingers);
    return posed(part.side(), wrist_at, within_limits(fingers));
}

void check(const GestureOptions& options)
{
    const auto within = [](const char* what, double value, double low, double high) {
        if (!(value >= low && value <= high))
            throw InputError(
                fmt::format("gesture: expected {} of {} to {}, found {}", what, low, high, value));
    };
    within("a rate [Hz]", options.rate, 5, 1000);
    within("a jitter [m]", options.jitter, 0, 0.02);
    within("a latency [s]", options.latency, 0, 1);
    within("a chance of dropouts", options.dropouts, 0, 1);
    within("seconds", options.seconds, 0, 600);
    within("a depth", options.depth, 0, 0.9);
    within("a radius [m]", options.radius, 0.02, 1);
    for (const double x : {options.centre.x, options.centre.y, options.centre.z})
        within("a centre [m]", x, -50, 50);
}

const Script& script(const std::string& name)
{
    std::vector<std::string> known;
    for (const Script& s : scripts()) {
        if (s.gesture.name == name) return s;
        known.push_back(s.gesture.name);
    }
    throw InputError(fmt::format("gesture: expected one of {}, found \"{}\"; the nearest is \"{}\"",
                                 fmt::join(known, ", "), name.substr(0, 60),
                                 nearest_name(name, known)));
}

}  // namespace

const std::vector<Gesture>& gestures()
{
    static const std::vector<Gesture> all = [] {
        std::vector<Gesture> list;
        for (const Script& s : scripts()) list.push_back(s.gesture);
        return list;
    }();
    return all;
}

Recording generate(const std::string& name, const GestureOptions& options)
{
    const auto& [gesture, write] = script(name);
    check(options);
    const double depth = options.radius * (options.depth > 0 ? options.depth : gesture.depth);
    Stage stage{
        options.topology, options.radius, depth, {{left, options.radius}, {right, options.radius}}};
    write(stage);

    const double seconds = options.seconds > 0 ? options.seconds : gesture.seconds;
    Recording r{name, options.rate, options.latency, {}};
    Chance chance(options.seed);
    Tremble tremble[side_count] = {Tremble(options.jitter), Tremble(options.jitter)};
    int lost[side_count] = {};  // remaining frames without the hand
    const int count = int(seconds * options.rate + 1e-9) + 1;
    for (int i = 0; i < count; ++i) {
        const double uneven = i > 0 ? 0.16 * (chance.uniform() - 0.5) : 0;  // fraction of a frame
        const double time = (i + uneven) / options.rate;
        HandFrame frame;
        frame.time = time + options.latency;
        for (int s = 0; s < side_count; ++s) {
            tremble[s].advance(1 / options.rate, chance);
            const double fate = chance.uniform(), spell = chance.uniform();
            if (lost[s] > 0)
                --lost[s];
            else if (i > 0 && fate < options.dropouts)
                lost[s] = 3 + int(8 * spell);
            Hand& hand = frame.hand[s];
            if (lost[s] > 0) {
                hand = r.frames.back().hand[s];
                hand.tracked = false;
                hand.valid.fill(false);
                continue;
            }
            hand = open_hand(Side(s));
            const Pose pose =
                at(stage.part[s], time * gesture.seconds / seconds, options.centre, tremble[s]);
            for (int j = 0; j < joint_count; ++j)
                hand.joints[j] = {cast<float>(pose[j].q), cast<float>(pose[j].p)};
        }
        r.frames.push_back(frame);
    }
    return r;
}

}  // namespace knead
