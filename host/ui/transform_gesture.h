// Moving, turning and scaling objects with mouse and keys, as in Blender: a pure model of one
// gesture, from the key that begins it to the one that ends it. The clay is unchanged until then:
// the gesture gives what is to be shown, and at its end one command.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "cuda/math/box.h"
#include "host/document/command.h"

namespace knead {

enum class TransformKind { move, turn, scale };

// A picture's camera and the ray through the pointer, in the simulation's frame.
struct TransformView {
    Vec3<double> eye{};              // [m]
    Vec3<double> forward{0, 0, -1};  // unit
    Vec3<double> ray{0, 0, -1};      // of any length but 0
};

// A point for the object to be put on: of the clay or the floor below the pointer.
struct TransformSurface {
    Vec3<double> point{}, normal{0, 1, 0};  // [m]; unit, outward
};

// Of moves, turns and factors that snap, by mouse and by hand.
struct Snapping {
    static constexpr double grid = 0.01;                         // [m]
    static constexpr double angle_step = 3.14159265358979 / 12;  // [rad]
    static constexpr double factor_step = 0.1;

    static Vec3<double> move(Vec3<double> by);
    static double angle(double angle);
    // About the axis of the frame that is nearest to that of the turn.
    static Quat<double> turn(const Quat<double>& q);
    static double factor(double factor);
};

class TransformGesture {
  public:
    static constexpr double least_factor = 0.1, largest_factor = 10;  // of scale_objects

    // `centre`: the middle of the objects' centres of mass [m].
    TransformGesture(TransformKind kind, std::vector<ObjectId> objects, Vec3<double> centre,
                     const TransformView& view);

    TransformKind kind() const { return kind_; }
    const std::vector<ObjectId>& objects() const { return objects_; }
    Vec3<double> centre() const { return centre_; }

    // The pointer's new place. `snaps`: to the grid. `surface`: while the object is put on it.
    void point(const TransformView& view, bool snaps,
               const std::optional<TransformSurface>& surface = {});
    // Some particles of the objects, and their spacing, for moves onto a surface: the lowest along
    // the surface's normal is placed one spacing above it.
    void set_clay(std::vector<Vec3<float>> some, double spacing);

    // An axis, 0 to 2; with `plane`, the plane across it. The same again: none. Turns ignore
    // `plane`; scaling ignores the call.
    void choose_axis(int axis, bool plane);
    // -1: none.
    int axis() const { return axis_; }
    bool plane() const { return plane_; }
    // A character of a number: a digit, '.' or ',', or '-', which changes its sign. Returns false
    // for any other. While there is one, the pointer has no effect.
    bool type(int character);
    void erase();  // the last character
    bool typed() const { return negative_ || !text_.empty(); }

    // The motion so far, and the factor about `centre`.
    Vec3<double> by() const;    // [m]
    Quat<double> turn() const;  // about centre()
    double factor() const;
    double angle() const;  // [rad]
    // Where a point of an object is now; `own`: the object's centre of mass, about which it scales.
    Vec3<double> at(Vec3<double> x, Vec3<double> own) const;
    // The axis or the axes of the plane, unit vectors; none for a free motion.
    std::vector<Vec3<double>> axes() const;
    // "Move along x: 5.00 cm", with the keys that can follow.
    std::string text() const;
    // What the gesture does; nothing if it changes nothing. `origin`: of the simulation's frame in
    // that of the scene's file.
    std::optional<Command> command(Vec3<double> origin) const;

  private:
    std::optional<double> number() const;
    Vec3<double> unit_axis(int axis) const;
    Vec3<double> on_view_plane(const TransformView& view) const;
    Vec3<double> moved(const TransformView& view) const;
    double turned() const;

    const TransformKind kind_;
    const std::vector<ObjectId> objects_;
    const Vec3<double> centre_;
    TransformView begin_, now_;
    Vec3<double> from_{}, along_{};  // where the gesture began on the view plane; the view's axis
    std::vector<Vec3<float>> clay_;
    double spacing_ = 0;
    std::optional<TransformSurface> surface_;
    int axis_ = -1;
    bool plane_ = false, snaps_ = false, negative_ = false;
    std::string text_;
    double angle_ = 0;            // of a turn so far [rad]
    std::optional<double> last_;  // of the pointer; none: it was at the centre
};

}  // namespace knead
