#include "host/verify/oracle.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <numbers>

namespace knead::oracle {
namespace {
using Matrix = ::Eigen::Matrix3d;
using Vector = ::Eigen::Vector3d;

Matrix dense(const Sym3<double>& A)
{
    Matrix M;
    M << A.xx, A.xy, A.xz, A.xy, A.yy, A.yz, A.xz, A.yz, A.zz;
    return M;
}

Sym3<double> packed(const Matrix& M)
{
    return {M(0, 0), M(1, 1), M(2, 2), M(0, 1), M(0, 2), M(1, 2)};
}

}  // namespace

StressState solid(const Material<double>& m, const Sym3<double>& e, double factor)
{
    const double mu = factor * m.mu, lambda = factor * m.lambda;
    const Matrix F = (Matrix::Identity() + dense(e)).llt().matrixL();
    const ::Eigen::JacobiSVD<Matrix> svd(F, ::Eigen::ComputeFullU | ::Eigen::ComputeFullV);
    const Vector& s = svd.singularValues();
    const Vector log = s.array().log();
    const Matrix R = svd.matrixU() * svd.matrixV().transpose();
    const double log_J = log.sum(), J = s.prod();
    Matrix P = Matrix::Zero();  // first Piola-Kirchhoff stress
    double energy = 0;
    const Matrix inverse_T = F.inverse().transpose();
    switch (m.elasticity) {
        case Elasticity::neo_hookean:
            P = mu * (F - inverse_T) + lambda * log_J * inverse_T;
            energy = mu / 2 * (F.squaredNorm() - 3) - mu * log_J + lambda / 2 * log_J * log_J;
            break;
        case Elasticity::fixed_corotated:
            P = 2 * mu * (F - R) + lambda * (J - 1) * J * inverse_T;
            energy = mu * (F - R).squaredNorm() + lambda / 2 * (J - 1) * (J - 1);
            break;
        case Elasticity::hencky: {
            const Vector share = (2 * mu * log.array() + lambda * log_J) / s.array();
            P = svd.matrixU() * share.asDiagonal() * svd.matrixV().transpose();
            energy = mu * log.squaredNorm() + lambda / 2 * log_J * log_J;
        }
    }
    return {packed(P * F.transpose()), energy, log_J};
}

double shear(const Sym3<double>& tau)
{
    const Matrix M = dense(tau);
    return (M - M.trace() / 3 * Matrix::Identity()).norm();
}

double pressure(const Sym3<double>& tau) { return -dense(tau).trace() / 3; }

// The largest r for which stresses 1 + r N keep I1 I2 <= k I3.
double cone(const Sym3<double>& tau, double friction)
{
    const Matrix M = dense(tau), S = M.trace() / 3 * Matrix::Identity() - M;
    if (!(S.norm() > 0)) return friction;
    const Matrix N = S / S.norm();
    const double sine = 3 * friction / (2 * std::sqrt(6.0) + friction);
    const double k = (9 - sine * sine) / (1 - sine * sine);
    double low = 0, high = -1 / ::Eigen::SelfAdjointEigenSolver<Matrix>(N).eigenvalues().minCoeff();
    for (int i = 0; i < 60; ++i) {
        const double r = (low + high) / 2;
        const double product = 1 - r * r / 2 + r * r * r * N.determinant();
        (3 * (3 - r * r / 2) > k * product ? high : low) = r;
    }
    return low;
}

Mat3<double> Draw::rotation()
{
    for (;;) {  // random quaternion by rejection from the unit ball
        const Quat<double> q{in(-1, 1), in(-1, 1), in(-1, 1), in(-1, 1)};
        const double n = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
        if (n > 1 || n < 0.01) continue;
        const Quat<double> u = unit(q);
        return {rotate(u, Vec3<double>{1, 0, 0}), rotate(u, Vec3<double>{0, 1, 0}),
                rotate(u, Vec3<double>{0, 0, 1})};
    }
}

Sym3<double> Draw::strain(double low, double high)
{
    const Mat3<double> Q = rotation();
    const auto part = [&](Vec3<double> u) {
        const double s = in(low, high);
        return (s * s - 1) * outer(u, u);
    };
    const Mat3<double> a = part(Q.a), b = part(Q.b);
    return symmetric(a + b + part(Q.c));
}

}  // namespace knead::oracle
