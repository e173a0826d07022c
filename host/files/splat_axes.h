// Conversion of splats between coordinate systems: axes in another order and of other signs, and
// transforms of scene graphs.
#pragma once
#include <array>

#include "cuda/splats/gaussian.h"

namespace knead {

// Rotates the coefficients of a colour by an orthogonal matrix, which may be a reflection.
class HarmonicTurn {
  public:
    HarmonicTurn() = default;
    explicit HarmonicTurn(const Mat3<double>& Q);

    // Coefficient k of the rotated colour; at(k) returns those of the given one.
    template <class At>
    Vec3<double> coefficient(int k, At&& at) const
    {
        const int l = k == 0 ? 0 : k < 4 ? 1 : k < 9 ? 2 : 3;
        Vec3<double> sum{0, 0, 0};
        for (int j = l * l; j < (l + 1) * (l + 1); ++j)
            sum = sum + turned[std::size_t(k)][std::size_t(j)] * at(j);
        return sum;
    }

  private:
    std::array<std::array<double, 16>, 16> turned{};
};

// From axes named by three letters, where +x, +y and +z point (Left or Right, Up or Down, Front or
// Back), to those of clouds: right, down, front. Left-handed systems are mirrored.
class SplatAxes {
  public:
    explicit SplatAxes(const char* letters);

    Vec3<double> place(Vec3<double> x) const;
    // The rotation and the half axes of the same ellipsoid.
    Quat<double> turn(Quat<double> q) const;
    Vec3<double> half_axes(Vec3<double> s) const;
    // As of HarmonicTurn; exact where no axes are swapped.
    template <class At>
    Vec3<double> coefficient(int k, At&& at) const
    {
        return swapped ? harmonics_turn.coefficient(k, at) : sign[std::size_t(k)] * at(k);
    }

  private:
    std::array<int, 3> axis{};          // of the cloud, for each of the file
    std::array<double, 3> direction{};  // 1 or -1
    double handedness = 1;              // -1: mirrored
    bool swapped = false;               // y and z
    std::array<double, 16> sign{};      // of the harmonics, unless swapped
    HarmonicTurn harmonics_turn;
};

// Letters of system 1 to 16 of SPZ's coordinate record.
const char* spz_axes(unsigned system);

// x -> M x + shift. Precondition: M is finite and has an inverse.
class SplatTransform {
  public:
    SplatTransform(const Mat3<double>& M, Vec3<double> shift);

    Vec3<double> place(Vec3<double> x) const { return matrix * x + move; }
    // M Sigma M^T; half axes keep their order if M is a rotation and a scale. Precondition: finite,
    // q not of length 0.
    Ellipsoid<double> apply(const Ellipsoid<double>& e) const;
    template <class At>
    Vec3<double> coefficient(int k, At&& at) const
    {
        return turn.coefficient(k, at);
    }

  private:
    Mat3<double> matrix;
    Vec3<double> move;
    bool similar = false;  // a rotation and a scale
    double scale = 1;
    Quat<double> rotation_of_m{1, 0, 0, 0};
    HarmonicTurn turn;
};

}  // namespace knead
