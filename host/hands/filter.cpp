#include "host/hands/filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "host/hands/recording.h"

namespace knead {
namespace {

constexpr double window = 0.2;        // averaging window [s], Section 4.3 of the paper
constexpr double settling = 0.2;      // from appearance to steady [s]
constexpr double growing = 0.25;      // from steady to full size [s]
constexpr double longest_gap = 0.25;  // between frames of continuous tracking [s]

// Adaptive filter: of the settings tried, the smoothest at rest whose rms error over generated
// gestures with 1.5 mm of jitter (30, 60 and 72 Hz) does not exceed that jitter. Figures:
// docs/reference/recordings.md.
constexpr float rest_cutoff = 0.8f;   // at rest [Hz]
constexpr float cutoff_slope = 80;    // position cutoff per speed [Hz per m/s]
constexpr float turn_slope = 2.5f;    // orientation cutoff per angular speed [Hz per rad/s]
constexpr float speed_cutoff = 2.5f;  // cutoff of the speeds [Hz]

// Weight of the new value in a first-order low-pass, exact for any frame duration [s].
float share(float cutoff, float duration)
{
    return 1 - std::exp(-2 * std::numbers::pi_v<float> * cutoff * duration);
}

bool usable(const Hand& hand, int j)
{
    const auto& [q, p] = hand.joints[j];
    const float square = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
    return hand.valid[j] && std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z) &&
           square > 0.5f && square < 2;
}

// Pose b relative to a, and the inverse.
Joint<float> relative(const Joint<float>& a, const Joint<float>& b)
{
    const Quat<float> back = conjugate(a.q);
    return {back * b.q, rotate(back, b.p - a.p)};
}
Joint<float> placed(const Joint<float>& a, const Joint<float>& b)
{
    return {unit(a.q * b.q), a.p + rotate(a.q, b.p)};
}

}  // namespace

// The hand, with unusable joints moved rigidly with the wrist.
Hand HandFilter::completed(const Hand& hand) const
{
    Hand whole = hand;
    for (int j = 0; j < joint_count; ++j) {
        if (usable(hand, j)) {
            whole.joints[j].q = unit(hand.joints[j].q);
            continue;
        }
        whole.joints[j] = placed(whole.joints[wrist], relative(raw_.joints[wrist], raw_.joints[j]));
        whole.radius[j] = raw_.radius[j];
        whole.valid[j] = true;
    }
    return whole;
}

Hand HandFilter::filter(const Hand& hand, double time)
{
    if (!(time > time_)) return out_;
    const double duration = time - time_;
    time_ = time;
    bool known = hand.tracked && usable(hand, wrist);
    for (int j = 0; j < joint_count; ++j) known = known && (seen_[j] || usable(hand, j));
    if (!known) {
        present_ = false;
        out_.tracked = false;
        return out_;
    }
    Hand whole = hand;
    whole.joints[wrist].q = unit(hand.joints[wrist].q);
    hand_size_.see(hand, std::min(duration, longest_gap));
    whole = completed(whole);
    const bool late = present_ && duration > longest_gap;
    const float leap = leap_distance(duration);
    bool leapt = !present_ || late;
    for (int j = 0; j < joint_count; ++j)
        leapt = leapt || length(whole.joints[j].p - raw_.joints[j].p) > leap;
    const bool seldom = leap < fastest * float(duration);
    if (late || (present_ && leapt && seldom)) ++slow_restarts_;
    if (leapt)
        start(whole, time);
    else if (filter_ == Filter::average)
        average(whole, time);
    else if (filter_ == Filter::adaptive)
        adapt(whole, float(duration));
    else
        out_ = whole;
    raw_ = whole;
    seen_.fill(true);
    return out_;
}

bool HandFilter::steady() const { return present_ && time_ - appeared_ >= settling - 1e-6; }

float HandFilter::size() const
{
    return steady() ? float(clamp((time_ - appeared_ - settling) / growing, 0.0, 1.0)) : 0.0f;
}

void HandFilter::start(const Hand& hand, double time)
{
    present_ = true;
    appeared_ = time;
    out_ = hand;
    past_.assign(1, {time, 0, hand});
    speed_.fill({});
}

void HandFilter::average(const Hand& hand, double time)
{
    past_.push_back({time, time - past_.back().time, hand});
    while (past_.front().time <= time - window) past_.pop_front();
    out_ = hand;
    for (int j = 0; j < joint_count; ++j) {
        Quat<float> q{};
        Vec3<float> p{};
        float sum = 0;
        for (const Past& past : past_) {
            // A frame is weighted by the time since the previous frame, clipped to the window.
            const float weight = float(std::min(past.duration, past.time - (time - window)));
            const Quat<float> a = hand.joints[j].q, b = past.hand.joints[j].q;
            const float same = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z;
            const float s = same < 0 ? -weight : weight;
            q = {q.w + s * b.w, q.x + s * b.x, q.y + s * b.y, q.z + s * b.z};
            p = p + weight * past.hand.joints[j].p;
            sum += weight;
        }
        out_.joints[j] = {unit(q), (1 / sum) * p};
    }
}

void HandFilter::adapt(const Hand& hand, float duration)
{
    const float s = share(speed_cutoff, duration);
    const auto before = out_.joints;
    out_ = hand;
    for (int j = 0; j < joint_count; ++j) {
        const Joint<float>&now = hand.joints[j], &last = raw_.joints[j];
        Speed& speed = speed_[j];
        speed.v = speed.v + s * ((1 / duration) * (now.p - last.p) - speed.v);
        speed.turn += s * (length(spin(last.q, now.q, duration)) - speed.turn);
        const float move = share(rest_cutoff + cutoff_slope * length(speed.v), duration);
        const float turn = share(rest_cutoff + turn_slope * speed.turn, duration);
        out_.joints[j] = {between(before[j].q, now.q, turn),
                          before[j].p + move * (now.p - before[j].p)};
    }
}

Response response(Filter filter, double rate)
{
    const double speed = 0.3, sway = 0.05, noise = 1.5e-3, omega = 2 * std::numbers::pi;
    const int settled = int(std::ceil(2 * rate)), count = int(std::ceil(12 * rate));
    const auto drive = [&](auto path, auto use) {
        HandFilter driven(filter);
        Hand hand;
        hand.tracked = true;
        hand.valid.fill(true);
        for (int i = 0; i < count; ++i) {
            const Vec3<float> p = cast<float>(path(i / rate));
            for (auto& joint : hand.joints) joint = {{1, 0, 0, 0}, p};
            const Vec3<float> q = driven.filter(hand, i / rate).joints[palm].p;
            if (i >= settled) use(i / rate, cast<double>(q));
        }
    };
    Response r{};
    drive(
        [&](double t) {
            return Vec3<double>{speed * t, 0, 0};
        },
        [&](double t, Vec3<double> p) { r.ramp += t - p.x / speed; });
    double in_phase = 0, quarter = 0;  // in-phase and quadrature sums over ten periods
    drive(
        [&](double t) {
            return Vec3<double>{sway * std::sin(omega * t), 0, 0};
        },
        [&](double t, Vec3<double> p) {
            in_phase += p.x * std::sin(omega * t);
            quarter -= p.x * std::cos(omega * t);
        });
    // Twelve uniform numbers minus their mean have variance 1.
    std::mt19937_64 source(1);
    const auto normal = [&] {
        double sum = -6;
        for (int k = 0; k < 12; ++k) sum += double(source() >> 11) * 0x1p-53;
        return sum * noise / std::sqrt(3.0);
    };
    drive(
        [&](double) {
            const double x = normal(), y = normal(), z = normal();
            return Vec3<double>{x, y, z};
        },
        [&](double, Vec3<double> p) { r.jitter += dot(p, p); });
    r.ramp /= count - settled;
    r.sine = std::atan2(quarter, in_phase) / omega;
    r.jitter = std::sqrt(r.jitter / (count - settled)) / noise;
    return r;
}

double lag(Filter filter, double rate) { return response(filter, rate).ramp; }

HandStream::HandStream(const HandsOptions& options)
    : filters_{HandFilter(options.filter), HandFilter(options.filter)},
      present_{options.present[left], options.present[right]},
      zoom_(options.zoom),
      at_(options.at)
{
}

void HandStream::push(const HandFrame& given)
{
    if (!(empty() ? std::isfinite(given.time) : given.time > newest())) return;
    Frame frame{};
    frame.time = given.time;
    for (int s = 0; s < side_count; ++s) {
        const Hand hand = filters_[s].filter(given.hand[s], given.time);
        for (int j = 0; j < joint_count; ++j) {
            const Joint<float>& joint = hand.joints[j];
            frame.joints[s * joint_count + j] = {unit(joint.q), joint.p};
        }
        frame.steady[s] = present_[s] && filters_[s].steady();
        frame.size[s] = filters_[s].size();
        frame.stretch[s] = filters_[s].stretch();
    }
    frames_.push_back(frame);
}

void HandStream::forget(double time)
{
    while (frames_.size() > 2 && frames_[1].time <= time) frames_.pop_front();
}

HandStream::Between HandStream::around(double time) const
{
    const auto after =
        std::upper_bound(frames_.begin(), frames_.end(), time,
                         [](double t, const Frame& frame) { return t < frame.time; });
    const Frame& from = after == frames_.begin() ? *after : *(after - 1);
    const Frame& to = after == frames_.end() ? frames_.back() : *after;
    const double span = to.time - from.time;
    return {from, to, span > 0 ? clamp((time - from.time) / span, 0.0, 1.0) : 0};
}

Stretch<float> HandStream::stretch(double time, Side side) const
{
    return empty() ? Stretch<float>{} : around(time).from.stretch[side];
}

bool HandStream::sample(double time, Joint<double> joints[2 * joint_count],
                        float size[side_count]) const
{
    if (empty()) {
        std::fill(joints, joints + 2 * joint_count, Joint<double>{{1, 0, 0, 0}, {0, 0, 0}});
        std::fill(size, size + int(side_count), 0.0f);
        return false;
    }
    const auto& [from, to, s] = around(time);
    for (int j = 0; j < 2 * joint_count; ++j) {
        const auto wide = [&](const Joint<float>& joint) {
            return Joint<double>{unit(cast<double>(joint.q)), cast<double>(joint.p)};
        };
        const Joint<double> joint = between(wide(from.joints[j]), wide(to.joints[j]), s);
        joints[j] = {joint.q, at_ + zoom_ * joint.p};
    }
    const double last = open_ ? newest() + longest_gap : newest();
    for (int side = 0; side < side_count; ++side) {
        // At the time of a frame only that frame counts: a live caller has no next frame yet.
        const bool steady = from.steady[side] && (s == 0 || to.steady[side]);
        const bool active = steady && time <= last;
        size[side] = active ? from.size[side] + float(s) * (to.size[side] - from.size[side]) : 0;
    }
    return size[left] > 0 || size[right] > 0;
}

HandSource::HandSource(const Recording& recording, const HandsOptions& options) : stream_(options)
{
    check(recording);
    for (const HandFrame& frame : recording.frames) stream_.push(frame);
    stream_.close();
}

}  // namespace knead
