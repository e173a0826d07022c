#include "host/assets/skin.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "host/base/errors.h"
#include "host/files/gltf.h"

namespace knead {
namespace {

using ::Eigen::Matrix3d;
using ::Eigen::Vector3d;

// Joint names of the WebXR Hand Input specification, which has no palm.
const char* const webxr_names[joint_count] = {"",
                                              "wrist",
                                              "thumb-metacarpal",
                                              "thumb-phalanx-proximal",
                                              "thumb-phalanx-distal",
                                              "thumb-tip",
                                              "index-finger-metacarpal",
                                              "index-finger-phalanx-proximal",
                                              "index-finger-phalanx-intermediate",
                                              "index-finger-phalanx-distal",
                                              "index-finger-tip",
                                              "middle-finger-metacarpal",
                                              "middle-finger-phalanx-proximal",
                                              "middle-finger-phalanx-intermediate",
                                              "middle-finger-phalanx-distal",
                                              "middle-finger-tip",
                                              "ring-finger-metacarpal",
                                              "ring-finger-phalanx-proximal",
                                              "ring-finger-phalanx-intermediate",
                                              "ring-finger-phalanx-distal",
                                              "ring-finger-tip",
                                              "pinky-finger-metacarpal",
                                              "pinky-finger-phalanx-proximal",
                                              "pinky-finger-phalanx-intermediate",
                                              "pinky-finger-phalanx-distal",
                                              "pinky-finger-tip"};

constexpr double open_end = 0.12;  // fraction of the length taken by the wrist's open end

struct Source {
    const std::string& path;
    void need(bool holds, const std::string& what) const
    {
        if (!holds) throw InputError(path + ": " + what);
    }
};

// Index of Knead's joint for each joint of the skin; -1: none.
std::vector<int> joint_order(const Source& s, const GltfSkin& skin)
{
    std::vector<int> order;
    for (const std::string& name : skin.joints) {
        const auto at = std::find(webxr_names + wrist, webxr_names + joint_count, name);
        order.push_back(at == webxr_names + joint_count ? -1 : int(at - webxr_names));
    }
    for (int j = wrist; j < joint_count; ++j)
        s.need(std::count(order.begin(), order.end(), j) == 1,
               fmt::format("/skins/0/joints: expected one named \"{}\", found {}", webxr_names[j],
                           std::count(order.begin(), order.end(), j)));
    return order;
}

struct JointFrame {
    Matrix3d axes;  // columns x, y, z
    Vector3d p;
};

Matrix3d facing(const Vector3d& x, const Vector3d& z)
{
    Matrix3d m;
    m.col(2) = z.normalized();
    m.col(0) = (x - x.dot(m.col(2)) * m.col(2)).normalized();
    m.col(1) = m.col(2).cross(m.col(0));
    return m;
}

// Phalanges and the thumb: -z exactly along the bone, and one flexion axis x for the whole finger,
// the mean of the axes in the mesh's skeleton. Metacarpals keep their frames.
void straighten(std::array<JointFrame, joint_count>& f)
{
    for (int finger = 0; finger < 5; ++finger) {
        const int first = finger == 0 ? thumb_metacarpal : thumb_tip + 5 * finger - 3;
        const int tip = thumb_tip + 5 * finger;
        Vector3d x = Vector3d::Zero();
        for (int j = first; j < tip; ++j) x += f[j].axes.col(0);
        for (int j = first; j < tip; ++j) f[j].axes = facing(x, f[j].p - f[j + 1].p);
        f[tip].axes = f[tip - 1].axes;
    }
    f[palm] = {f[middle_metacarpal].axes, (f[middle_metacarpal].p + f[middle_proximal].p) / 2};
}

std::array<Joint<double>, joint_count> bind_pose(const Source& s, const GltfSkin& skin,
                                                 const std::vector<int>& order, JointFrame& base)
{
    std::array<JointFrame, joint_count> f{};
    for (std::size_t k = 0; k < order.size(); ++k) {
        if (order[k] < 0) continue;
        const ::Eigen::Matrix4d m(skin.inverse_bind[k].data());
        s.need(std::abs(m.determinant()) > 1e-9,
               fmt::format("/skins/0/inverseBindMatrices: element {}: expected an invertible "
                           "matrix, found determinant {}",
                           k, m.determinant()));
        const ::Eigen::Matrix4d at = m.inverse();
        f[order[k]] = {facing(at.block<3, 1>(0, 0), at.block<3, 1>(0, 2)), at.block<3, 1>(0, 3)};
    }
    base = f[wrist];
    for (JointFrame& g : f)
        g = {base.axes.transpose() * g.axes, base.axes.transpose() * (g.p - base.p)};
    straighten(f);
    std::array<Joint<double>, joint_count> joints{};
    for (int j = 0; j < joint_count; ++j) {
        const ::Eigen::Quaterniond q(f[j].axes);
        joints[j] = {unit(Quat<double>{q.w(), q.x(), q.y(), q.z()}),
                     {f[j].p[0], f[j].p[1], f[j].p[2]}};
    }
    return joints;
}

// Weights of vertex i for each of Knead's joints.
std::array<double, joint_count> shares(const Source& s, const GltfPart& part, std::size_t i,
                                       const std::vector<int>& order)
{
    std::array<double, joint_count> w{};
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) {
        const double weight = part.weights[i][k];
        if (weight <= 0) continue;
        const auto joint = std::size_t(part.joints[i][k]);
        s.need(
            joint < order.size() && order[joint] >= 0,
            fmt::format("JOINTS_0: vertex {}: expected a joint of the hand, found {}", i, joint));
        w[std::size_t(order[joint])] += weight;
        sum += weight;
    }
    s.need(sum > 0, fmt::format("WEIGHTS_0: vertex {}: expected a weight above 0, found none", i));
    for (double& v : w) v /= sum;
    return w;
}

}  // namespace

Skin read_skin(const std::string& path)
{
    const Source s{path};
    const Gltf gltf = read_gltf(path, GltfSkins::read);
    s.need(gltf.skins.size() == 1 && gltf.parts.size() == 1,
           fmt::format("expected one skin and one mesh of one part, found {} and {}",
                       gltf.skins.size(), gltf.parts.size()));
    const GltfPart& part = gltf.parts[0];
    s.need(!part.joints.empty(), "/meshes/0/primitives/0: expected JOINTS_0, found none");
    const std::vector<int> order = joint_order(s, gltf.skins[0]);
    Skin skin;
    JointFrame base;
    skin.joints = bind_pose(s, gltf.skins[0], order, base);
    for (std::size_t i = 0; i < part.vertices.size(); ++i) {
        const Vec3<double> v = part.vertices[i];
        const Vector3d p = base.axes.transpose() * (Vector3d(v.x, v.y, v.z) - base.p);
        skin.vertices.push_back({p[0], p[1], p[2]});
        skin.weights.push_back(shares(s, part, i, order));
    }
    skin.triangles = part.triangles;
    return skin;
}

std::vector<SkinPoint> spread(const Skin& skin, int count)
{
    double low = 1e30, high = -1e30;
    for (const auto& v : skin.vertices) low = std::min(low, v.z), high = std::max(high, v.z);
    const double cut = high - open_end * (high - low);
    std::vector<double> until;  // cumulative area of the triangles
    double area = 0;
    for (const Int3 t : skin.triangles) {
        const auto a = skin.vertices[t.x], b = skin.vertices[t.y], c = skin.vertices[t.z];
        area += length(cross(b - a, c - a)) / 2;
        until.push_back(area);
    }
    std::vector<SkinPoint> points;
    std::size_t at = 0;
    for (int i = 0; i < count; ++i) {
        while (at + 1 < until.size() && until[at] < area * (i + 0.5) / count) ++at;
        const Int3 t = skin.triangles[at];
        // Two-dimensional golden-ratio sequence, folded into the triangle.
        double u = std::fmod(0.5 + 0.7548776662466927 * i, 1.0);
        double v = std::fmod(0.5 + 0.5698402909980532 * i, 1.0);
        if (u + v > 1) u = 1 - u, v = 1 - v;
        const auto blend = [&](auto a, auto b, auto c) { return (1 - u - v) * a + u * b + v * c; };
        SkinPoint s{blend(skin.vertices[t.x], skin.vertices[t.y], skin.vertices[t.z]), {}};
        if (s.p.z > cut) continue;
        for (int j = 0; j < joint_count; ++j)
            s.weight[j] = blend(skin.weights[t.x][j], skin.weights[t.y][j], skin.weights[t.z][j]);
        points.push_back(s);
    }
    return points;
}

Vec3<double> follow(const Skin& skin, const SkinPoint& point,
                    const std::array<Joint<double>, joint_count>& pose)
{
    Vec3<double> p{};
    for (int j = 0; j < joint_count; ++j) {
        if (point.weight[j] == 0) continue;
        const auto local = rotate(conjugate(skin.joints[j].q), point.p - skin.joints[j].p);
        p = p + point.weight[j] * (pose[j].p + rotate(pose[j].q, local));
    }
    return p;
}

Skin mirrored(const Skin& skin)
{
    Skin other = skin;
    for (auto& v : other.vertices) v.x = -v.x;
    for (auto& t : other.triangles) std::swap(t.y, t.z);
    for (auto& j : other.joints) j = mirrored(j);
    return other;
}

}  // namespace knead
