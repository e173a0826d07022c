#include "host/ui/transform_gesture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "cuda/math/rotation.h"

namespace knead {
namespace {

constexpr const char* axis_names[] = {"x", "y", "z"};
constexpr double per_degree = std::numbers::pi / 180;
constexpr double per_cm = 0.01;  // [m]

double component(Vec3<double> v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

double rounded(double value, double step) { return step * std::round(value / step); }

// Where a ray from the eye meets a plane; nothing if that is behind it or very far.
std::optional<Vec3<double>> meets(const TransformView& view, Vec3<double> on, Vec3<double> normal)
{
    constexpr double flattest = 0.02;  // sine of the angle between ray and plane
    const double along = dot(view.ray, normal) / length(view.ray);
    if (std::abs(along) < flattest) return {};
    const double far = dot(on - view.eye, normal) / along;
    if (!(far > 0)) return {};
    return view.eye + (far / length(view.ray)) * view.ray;
}

}  // namespace

Vec3<double> Snapping::move(Vec3<double> by)
{
    return {rounded(by.x, grid), rounded(by.y, grid), rounded(by.z, grid)};
}

double Snapping::angle(double angle) { return rounded(angle, angle_step); }

Quat<double> Snapping::turn(const Quat<double>& q)
{
    const double part[3] = {q.x, q.y, q.z};
    const auto larger = [](double a, double b) { return std::abs(a) < std::abs(b); };
    const int axis = int(std::max_element(part, part + 3, larger) - part);
    // The part of the turn about that axis.
    const double half = angle(2 * std::atan2(part[axis], q.w)) / 2;
    return {std::cos(half), axis == 0 ? std::sin(half) : 0, axis == 1 ? std::sin(half) : 0,
            axis == 2 ? std::sin(half) : 0};
}

double Snapping::factor(double factor) { return rounded(factor, factor_step); }

TransformGesture::TransformGesture(TransformKind kind, std::vector<ObjectId> objects,
                                   Vec3<double> centre, const TransformView& view)
    : kind_(kind),
      objects_(std::move(objects)),
      centre_(centre),
      begin_(view),
      now_(view),
      along_(view.forward)
{
    from_ = on_view_plane(view);
    point(view, false);
}

Vec3<double> TransformGesture::on_view_plane(const TransformView& view) const
{
    return meets(view, centre_, along_).value_or(centre_);
}

Vec3<double> TransformGesture::unit_axis(int axis) const
{
    return {axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, axis == 2 ? 1.0 : 0.0};
}

std::vector<Vec3<double>> TransformGesture::axes() const
{
    std::vector<Vec3<double>> all;
    for (int i = 0; axis_ >= 0 && i < 3; ++i)
        if (plane_ != (i == axis_)) all.push_back(unit_axis(i));
    return all;
}

void TransformGesture::point(const TransformView& view, bool snaps,
                             const std::optional<TransformSurface>& surface)
{
    now_ = view, snaps_ = snaps, surface_ = surface;
    if (kind_ != TransformKind::turn) return;
    // Anticlockwise, as it is seen.
    const Vec3<double> towards = -1.0 * along_, u = orthogonal(towards), v = cross(towards, u);
    const Vec3<double> d = on_view_plane(view) - centre_;
    if (length(d) < 1e-3 * length(centre_ - view.eye)) return;
    const double angle = std::atan2(dot(d, v), dot(d, u));
    if (last_) angle_ += std::remainder(angle - *last_, 2 * std::numbers::pi);
    last_ = angle;
}

void TransformGesture::set_clay(std::vector<Vec3<float>> some, double spacing)
{
    clay_ = std::move(some), spacing_ = spacing;
}

void TransformGesture::choose_axis(int axis, bool plane)
{
    if (kind_ == TransformKind::scale || axis < 0 || axis > 2) return;
    plane = plane && kind_ == TransformKind::move;
    const bool again = axis == axis_ && plane == plane_;
    axis_ = again ? -1 : axis, plane_ = !again && plane;
}

bool TransformGesture::type(int character)
{
    constexpr std::size_t longest = 12;
    if (character == '-') {
        negative_ = !negative_;
        return true;
    }
    const bool dot = character == '.' || character == ',';
    if (!dot && (character < '0' || character > '9')) return false;
    if (text_.size() < longest && !(dot && text_.find('.') != std::string::npos))
        text_ += dot ? '.' : char(character);
    return true;
}

void TransformGesture::erase()
{
    if (text_.empty())
        negative_ = false;
    else
        text_.pop_back();
}

// Of what was typed: in centimetres, degrees or as a factor.
std::optional<double> TransformGesture::number() const
{
    if (!typed()) return {};
    if (text_.empty() || text_ == ".") return kind_ == TransformKind::scale ? 1 : 0;
    const double value = std::stod(text_);
    return negative_ ? -value : value;
}

// By the pointer.
Vec3<double> TransformGesture::moved(const TransformView& view) const
{
    const Vec3<double> free = on_view_plane(view) - from_;
    if (axis_ < 0) return free;
    const Vec3<double> axis = unit_axis(axis_);
    if (plane_) {
        const auto to = meets(view, centre_, axis), from = meets(begin_, centre_, axis);
        return to && from ? *to - *from : free - dot(free, axis) * axis;
    }
    // In the plane of the axis that is seen best.
    const Vec3<double> across = cross(axis, along_);
    const double seen = length(across);
    if (seen < 0.05) return dot(free, axis) * axis;
    const Vec3<double> normal = (1 / seen) * cross(across, axis);
    const auto to = meets(view, centre_, normal), from = meets(begin_, centre_, normal);
    return dot(to && from ? *to - *from : free, axis) * axis;
}

Vec3<double> TransformGesture::by() const
{
    if (kind_ != TransformKind::move) return {};
    if (const auto value = number()) {
        const auto all = axes();
        return (per_cm * *value) * (all.empty() ? Vec3<double>{1, 0, 0} : all.front());
    }
    Vec3<double> way{};
    if (surface_ && !clay_.empty()) {
        // The surface is about half a spacing around the particles, and as much again is left.
        const Vec3<double> n = surface_->normal;
        double lowest = dot(centre_, n);
        for (const Vec3<float>& p : clay_) lowest = std::min(lowest, dot(cast<double>(p), n));
        way = surface_->point + (dot(centre_, n) - lowest + spacing_) * n - centre_;
        if (axis_ < 0) return way;
        Vec3<double> within{};
        for (const Vec3<double>& axis : axes()) within = within + dot(way, axis) * axis;
        return within;
    }
    way = moved(now_);
    if (!snaps_) return way;
    return Snapping::move(way);
}

double TransformGesture::turned() const
{
    if (const auto value = number()) return per_degree * *value;
    const double sign = axis_ >= 0 && dot(unit_axis(axis_), along_) > 0 ? -1 : 1;
    return sign * (snaps_ ? Snapping::angle(angle_) : angle_);
}

double TransformGesture::angle() const { return kind_ == TransformKind::turn ? turned() : 0; }

Quat<double> TransformGesture::turn() const
{
    const double half = angle() / 2;
    const Vec3<double> axis = axis_ >= 0 ? unit_axis(axis_) : -1.0 * along_;
    return {std::cos(half), std::sin(half) * axis.x, std::sin(half) * axis.y,
            std::sin(half) * axis.z};
}

double TransformGesture::factor() const
{
    if (kind_ != TransformKind::scale) return 1;
    if (const auto value = number()) return *value;
    const double least = 0.02 * length(centre_ - begin_.eye);
    const double to =
        length(on_view_plane(now_) - centre_) / std::max(least, length(from_ - centre_));
    return std::clamp(snaps_ ? Snapping::factor(to) : to, least_factor, largest_factor);
}

Vec3<double> TransformGesture::at(Vec3<double> x, Vec3<double> own) const
{
    if (kind_ == TransformKind::scale) return own + factor() * (x - own);
    return centre_ + by() + rotate(turn(), x - centre_);
}

std::string TransformGesture::text() const
{
    const char* const names[] = {"Move", "Turn", "Scale"};
    std::string text = names[int(kind_)];
    const auto in_plane = [&](int i) { return plane_ && i != axis_; };
    if (axis_ >= 0 && !plane_)
        text += fmt::format(" {} {}", kind_ == TransformKind::turn ? "about" : "along",
                            axis_names[axis_]);
    std::string number = typed() ? (negative_ ? "-" : "") + text_ : std::string();
    if (kind_ == TransformKind::scale)
        text += ": " + (typed() ? number : fmt::format("{:.3f}", factor()));
    else if (kind_ == TransformKind::turn)
        text += fmt::format(": {} degrees",
                            typed() ? number : fmt::format("{:.1f}", angle() / per_degree));
    else if (axis_ >= 0 && !plane_)
        text += fmt::format(
            ": {} cm", typed() ? number : fmt::format("{:.2f}", component(by(), axis_) / per_cm));
    else if (typed())
        text += fmt::format(" along {}: {} cm", plane_ && axis_ == 0 ? "y" : "x", number);
    else {
        text += ":";
        for (int i = 0; i < 3; ++i)
            if (axis_ < 0 || in_plane(i))
                text += fmt::format(" {} {:.2f}", axis_names[i], component(by(), i) / per_cm);
        text += " cm";
    }
    if (surface_ && kind_ == TransformKind::move && !typed()) text += ", on the surface";
    return text;
}

std::optional<Command> TransformGesture::command(Vec3<double> origin) const
{
    constexpr double nothing = 1e-9;
    const std::vector<ObjectRef> refs(objects_.begin(), objects_.end());
    switch (kind_) {
        case TransformKind::move:
            if (length(by()) < nothing) return {};
            return MoveObjects{refs, by(), {}, {}};
        case TransformKind::turn:
            if (std::abs(std::remainder(angle(), 2 * std::numbers::pi)) < nothing) return {};
            return MoveObjects{refs, {}, unit(turn()), centre_ + origin};
        default:
            if (std::abs(factor() - 1) < nothing) return {};
            return ScaleObjects{refs, factor()};
    }
}

}  // namespace knead
