#include "host/assets/skin.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>

namespace knead {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The joints by their names in the WebXR Hand Input specification; it has no palm.
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

constexpr double open_end = 0.12;  // share of the length that the wrist's open end takes

struct Source {
    std::string path;
    tinygltf::Model model;
    [[noreturn]] void fail(const std::string& what) const
    {
        throw std::runtime_error(path + ": " + what);
    }
    void need(bool holds, const std::string& what) const
    {
        if (!holds) fail(what);
    }
};

// Pictures are not looked at.
bool no_picture(tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*,
                int, void*)
{
    return true;
}

Source load(const std::string& path)
{
    Source s{path, {}};
    std::ifstream file(path, std::ios::binary);
    s.need(bool(file), "expected a readable binary glTF file, found none");
    const std::vector<unsigned char> bytes{std::istreambuf_iterator<char>(file), {}};
    s.need(bytes.size() >= 20 && bytes.size() < (1u << 28),
           "expected 20 bytes to 256 MiB, found " + std::to_string(bytes.size()));
    tinygltf::TinyGLTF reader;
    reader.SetImageLoader(no_picture, nullptr);
    std::string error, warning;
    const bool read = reader.LoadBinaryFromMemory(&s.model, &error, &warning, bytes.data(),
                                                  unsigned(bytes.size()));
    s.need(read, "expected binary glTF 2.0, found: " + (error.empty() ? "another format" : error));
    return s;
}

// The numbers of an accessor, row after row, whatever their stored type.
std::vector<double> numbers(const Source& s, int index, int type, const std::string& what)
{
    const auto& m = s.model;
    s.need(index >= 0 && index < int(m.accessors.size()),
           what + ": expected an accessor, found none");
    const auto& a = m.accessors[index];
    s.need(a.type == type && !a.sparse.isSparse, what + ": expected a plain accessor of its type");
    s.need(a.bufferView >= 0 && a.bufferView < int(m.bufferViews.size()),
           what + ": no buffer view");
    const auto& view = m.bufferViews[a.bufferView];
    s.need(view.buffer >= 0 && view.buffer < int(m.buffers.size()), what + ": no buffer");
    const auto& bytes = m.buffers[view.buffer].data;
    const int one = tinygltf::GetComponentSizeInBytes(a.componentType);
    const int columns = tinygltf::GetNumComponentsInType(type);
    s.need(one == 1 || one == 2 || one == 4, what + ": component type not known");
    const std::size_t row = std::size_t(one) * columns;
    const std::size_t stride = view.byteStride ? view.byteStride : row;
    const std::size_t first = view.byteOffset + a.byteOffset;
    s.need(a.count > 0 && a.count < (1u << 24) && stride < (1u << 16) && stride >= row &&
               first <= bytes.size() && (a.count - 1) * stride + row <= bytes.size() - first,
           what + ": expected " + std::to_string(a.count) + " rows, found fewer bytes");
    std::vector<double> out;
    out.reserve(a.count * columns);
    for (std::size_t i = 0; i < a.count * columns; ++i) {
        const unsigned char* at = bytes.data() + first + i / columns * stride + i % columns * one;
        const auto as = [&](auto number) {
            std::memcpy(&number, at, sizeof number);
            return double(number);
        };
        switch (a.componentType) {
            case TINYGLTF_COMPONENT_TYPE_FLOAT:
                out.push_back(as(float{}));
                break;
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
                out.push_back(as(std::uint8_t{}));
                break;
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
                out.push_back(as(std::uint16_t{}));
                break;
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
                out.push_back(as(std::uint32_t{}));
                break;
            default:
                s.fail(what + ": component type not known");
        }
        s.need(std::isfinite(out.back()), what + ": expected finite numbers");
    }
    return out;
}

// Which of our joints each of the skin's is; -1: none.
std::vector<int> joint_order(const Source& s, const tinygltf::Skin& skin)
{
    std::vector<int> order;
    for (const int node : skin.joints) {
        s.need(node >= 0 && node < int(s.model.nodes.size()), "skin: a joint is no node");
        const auto at =
            std::find(webxr_names + wrist, webxr_names + joint_count, s.model.nodes[node].name);
        order.push_back(at == webxr_names + joint_count ? -1 : int(at - webxr_names));
    }
    for (int j = wrist; j < joint_count; ++j)
        s.need(std::count(order.begin(), order.end(), j) == 1,
               std::string("skin: expected one joint named \"") + webxr_names[j] + "\"");
    return order;
}

struct Frame {
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
// the mean of what the mesh's skeleton gives its joints. Metacarpals keep their frames.
void straighten(std::array<Frame, joint_count>& f)
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

std::array<Joint<double>, joint_count> bind_pose(const Source& s,
                                                 const std::vector<double>& inverse,
                                                 const std::vector<int>& order, Frame& base)
{
    std::array<Frame, joint_count> f{};
    for (std::size_t k = 0; k < order.size(); ++k) {
        if (order[k] < 0) continue;
        const Eigen::Matrix4d m = Eigen::Map<const Eigen::Matrix4d>(inverse.data() + 16 * k);
        s.need(std::abs(m.determinant()) > 1e-9, "skin: expected invertible bind matrices");
        const Eigen::Matrix4d at = m.inverse();
        f[order[k]] = {facing(at.block<3, 1>(0, 0), at.block<3, 1>(0, 2)), at.block<3, 1>(0, 3)};
    }
    base = f[wrist];
    for (Frame& g : f) g = {base.axes.transpose() * g.axes, base.axes.transpose() * (g.p - base.p)};
    straighten(f);
    std::array<Joint<double>, joint_count> joints{};
    for (int j = 0; j < joint_count; ++j) {
        const Eigen::Quaterniond q(f[j].axes);
        joints[j] = {unit(Quat<double>{q.w(), q.x(), q.y(), q.z()}),
                     {f[j].p[0], f[j].p[1], f[j].p[2]}};
    }
    return joints;
}

}  // namespace

Skin read_skin(const std::string& path)
{
    const Source s = load(path);
    const auto& m = s.model;
    s.need(m.skins.size() == 1 && m.meshes.size() == 1 && m.meshes[0].primitives.size() == 1,
           "expected one skin and one mesh of one part");
    const auto& part = m.meshes[0].primitives[0];
    s.need(part.mode == TINYGLTF_MODE_TRIANGLES, "expected triangles");
    const auto attribute = [&](const char* name, int type) {
        const auto at = part.attributes.find(name);
        return numbers(s, at == part.attributes.end() ? -1 : at->second, type, name);
    };
    const auto at = attribute("POSITION", TINYGLTF_TYPE_VEC3);
    const auto joint = attribute("JOINTS_0", TINYGLTF_TYPE_VEC4);
    const auto weight = attribute("WEIGHTS_0", TINYGLTF_TYPE_VEC4);
    const auto corner = numbers(s, part.indices, TINYGLTF_TYPE_SCALAR, "indices");
    const auto order = joint_order(s, m.skins[0]);
    const auto inverse =
        numbers(s, m.skins[0].inverseBindMatrices, TINYGLTF_TYPE_MAT4, "inverseBindMatrices");
    const std::size_t n = at.size() / 3;
    s.need(joint.size() == 4 * n && weight.size() == 4 * n,
           "expected joints and weights per vertex");
    s.need(inverse.size() == 16 * order.size(), "expected one bind matrix per joint");
    s.need(corner.size() % 3 == 0, "expected three indices per triangle");

    Skin skin;
    Frame base;
    skin.joints = bind_pose(s, inverse, order, base);
    for (std::size_t i = 0; i < n; ++i) {
        const Vector3d p =
            base.axes.transpose() * (Eigen::Map<const Vector3d>(at.data() + 3 * i) - base.p);
        skin.vertices.push_back({p[0], p[1], p[2]});
        std::array<double, joint_count> w{};
        double sum = 0;
        for (std::size_t k = 4 * i; k < 4 * i + 4; ++k) {
            if (weight[k] <= 0) continue;
            s.need(joint[k] < double(order.size()) && order[std::size_t(joint[k])] >= 0,
                   "JOINTS_0: vertex " + std::to_string(i) + " hangs on a joint that is not known");
            w[order[std::size_t(joint[k])]] += weight[k];
            sum += weight[k];
        }
        s.need(sum > 0, "WEIGHTS_0: vertex " + std::to_string(i) + " hangs on nothing");
        for (double& v : w) v /= sum;
        skin.weights.push_back(w);
    }
    for (std::size_t i = 0; i < corner.size(); i += 3) {
        for (std::size_t k = i; k < i + 3; ++k)
            s.need(corner[k] < double(n), "indices: expected less than " + std::to_string(n));
        skin.triangles.push_back({int(corner[i]), int(corner[i + 1]), int(corner[i + 2])});
    }
    return skin;
}

std::vector<SkinPoint> spread(const Skin& skin, int count)
{
    double low = 1e30, high = -1e30;
    for (const auto& v : skin.vertices) low = std::min(low, v.z), high = std::max(high, v.z);
    const double cut = high - open_end * (high - low);
    std::vector<double> until;  // area of the triangles up to each
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
