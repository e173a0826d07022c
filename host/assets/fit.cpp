#include "host/assets/fit.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ostream>
#include <utility>

#include "host/base/machine.h"

namespace knead {
namespace {

constexpr int fit_points = 12000, check_points = 40000;
constexpr int turns = 4;             // alternations of fitting spheres and binding them to joints
constexpr double min_weight = 0.06;  // joint weights below this are dropped

// A trade-off between fitting the open hand and fitting a fist; the sweep is in
// docs/method/hands.md. H25 has too few spheres to fit its outliers without degrading the fist.
FitOptions options_of(Topology topology)
{
    if (topology == Topology::h25) return {3e-2, 0};
    return {1e-2, 2e-3};
}

double to_skin(const std::vector<SkinPoint>& points, Vec3<double> p)
{
    double min = 1e30;
    for (const SkinPoint& s : points) {
        const Vec3<double> d = s.p - p;
        min = std::min(min, dot(d, d));
    }
    return std::sqrt(min);
}

Spheres seeds(const Layout& l, const Skin& skin, const std::vector<SkinPoint>& points)
{
    Spheres out;
    for (const Seed& s : l.spheres) {
        const Vec3<double> c = between(skin.joints[s.a], skin.joints[s.b], s.s).p;
        out.push_back({c, {}, {}, std::max(smallest_radius, to_skin(points, c)), 0});
    }
    return out;
}

// Binds the sphere to at most four joints, those with the largest weights, in hundredths.
FittedSphere heaviest(std::array<double, joint_count> w, const Sphere<double>& s)
{
    FittedSphere f{cast<float>(s.c), float(s.r), {}, {}};
    double sum = 0, total = 0;
    for (const double v : w) total += v;
    std::array<int, 4> chosen{};
    std::array<double, 4> share{};
    for (int k = 0; k < 4; ++k) {
        const auto max = std::max_element(w.begin(), w.end());
        const bool kept = k == 0 || *max >= min_weight * total;
        chosen[k] = kept ? int(max - w.begin()) : chosen[0];
        share[k] = kept ? *max : 0;
        sum += share[k];
        *max = 0;
    }
    double others = 0;
    for (int k = 3; k >= 0; --k) {
        const double hundredths = k == 0 ? 1 - others : std::round(100 * share[k] / sum) / 100;
        others += hundredths;
        f.joint[k] = chosen[k];
        f.weight[k] = float(hundredths);
    }
    return f;
}

// Binds each sphere with the joint weights of the skin that it carries, so that it moves like that
// skin.
std::vector<FittedSphere> hung(const Spheres& s, const std::vector<Primitive>& primitives,
                               const Layout& l, const std::vector<SkinPoint>& points)
{
    std::vector<std::array<double, joint_count>> w(s.size(), std::array<double, joint_count>{});
    const auto all = shapes(s, primitives);
    for (const SkinPoint& point : points) {
        const Hold h = nearest(all, point.p);
        for_each_share(primitives[h.primitive], h.closest_point, [&](int i, double share) {
            for (int j = 0; j < joint_count; ++j) w[i][j] += share * share * point.weight[j];
        });
    }
    std::vector<FittedSphere> out;
    for (std::size_t i = 0; i < s.size(); ++i) {
        // Trackers differ in the position of tip joints: their weight goes to the last bone.
        for (const int tip : {thumb_tip, index_tip, middle_tip, ring_tip, little_tip})
            w[i][tip - 1] += std::exchange(w[i][tip], 0);
        w[i][l.spheres[i].a] += 1e-12;  // a sphere without skin follows its seed
        out.push_back(heaviest(w[i], s[i]));
    }
    return out;
}

Hand open_of(const Skin& skin, const std::vector<SkinPoint>& points, Side side)
{
    Hand hand;
    hand.tracked = true;
    for (int j = 0; j < joint_count; ++j) {
        const Joint<double> joint = side == right ? skin.joints[j] : mirrored(skin.joints[j]);
        hand.joints[j] = {cast<float>(joint.q), cast<float>(joint.p)};
        hand.radius[j] = float(to_skin(points, skin.joints[j].p));
        hand.valid[j] = true;
    }
    return hand;
}

// Points on the outer surface of the medial hand, at most `count` per primitive.
std::vector<Vec3<double>> outside(const Spheres& s, const std::vector<Primitive>& primitives,
                                  int count)
{
    const auto all = shapes(s, primitives);
    std::vector<Vec3<double>> out;
    for (std::size_t i = 0; i < primitives.size(); ++i)
        for (int k = 0; k < count; ++k) {
            // A ray from a point of the medial sheet in some direction, both from the 4D
            // golden-ratio sequence, projected onto the surface.
            const auto step = [&](double g) { return std::fmod(0.5 + g * k, 1.0); };
            double u = step(0.8566748838545029), v = step(0.733891856627126);
            if (u + v > 1) u = 1 - u, v = 1 - v;
            const double z = 2 * step(0.6287067210378087) - 1;
            const double turn = 2 * M_PI * step(0.5385972572236101);
            const double flat = std::sqrt(1 - z * z);
            const Vec3<double> n{flat * std::cos(turn), flat * std::sin(turn), z};
            const auto &a = s[primitives[i].sphere[0]], &b = s[primitives[i].sphere[1]],
                       &c = s[primitives[i].sphere[2]];
            const double far = 1e-3 + (1 - u - v) * a.r + u * b.r + v * c.r;
            const Vec3<double> p = (1 - u - v) * a.c + u * b.c + v * c.c + far * n;
            const ClosestPoint<double> f = closest_point(all[i], p);
            const Vec3<double> q = p - f.phi * f.n;
            if (nearest(all, q).closest_point.phi > -1e-9) out.push_back(q);
        }
    return out;
}

Spheres placed(const Rig& rig, Side side, const Hand& pose)
{
    Spheres s;
    for (const Binding<float>& b : rig.spheres) {
        const auto c = centre(b, [&](int j) { return pose.joints[j - int(side) * joint_count]; });
        s.push_back({cast<double>(c), {}, {}, b.radius, 0});
    }
    return s;
}

}  // namespace

Deviation deviation(const Rig& rig, Side side, const Skin& skin,
                    const std::vector<SkinPoint>& points, const Hand& pose, bool bulge)
{
    std::array<Joint<double>, joint_count> joints;
    for (int j = 0; j < joint_count; ++j)
        joints[j] = {unit(cast<double>(pose.joints[j].q)), cast<double>(pose.joints[j].p)};
    const Spheres s = placed(rig, side, pose);
    const auto all = shapes(s, rig.primitives);
    std::vector<SkinPoint> skinned = points;
    std::vector<double> error;
    Deviation d{};
    double end = -1e30;  // the open end is beyond this
    for (SkinPoint& point : skinned) {
        point.p = follow(skin, point, joints);
        end = std::max(end, point.p.z);
        error.push_back(std::abs(nearest(all, point.p).closest_point.phi));
        d.mean += error.back() / double(points.size());
    }
    std::sort(error.begin(), error.end());
    d.p95 = error[error.size() * 95 / 100];
    d.worst = error.back();
    if (bulge)
        for (const Vec3<double> p : outside(s, rig.primitives, 400))
            if (p.z < end) d.bulge = std::max(d.bulge, to_skin(skinned, p));
    return d;
}

namespace {

// Transforms of bound spheres from the open hand to another pose of its joints.
std::vector<SphereMotion> carries(const std::vector<FittedSphere>& spheres,
                                  const std::array<Joint<double>, joint_count>& open,
                                  const std::array<Joint<double>, joint_count>& pose)
{
    std::vector<SphereMotion> out;
    for (const FittedSphere& s : spheres) {
        SphereMotion to{diagonal(0.0), {}};
        for (int k = 0; k < 4; ++k) {
            const Joint<double>&a = open[s.joint[k]], &b = pose[s.joint[k]];
            const Quat<double> turn = b.q * conjugate(a.q);
            const double w = s.weight[k];
            to.turn = to.turn + w * Mat3<double>{rotate(turn, Vec3<double>{1, 0, 0}),
                                                 rotate(turn, Vec3<double>{0, 1, 0}),
                                                 rotate(turn, Vec3<double>{0, 0, 1})};
            to.shift = to.shift + w * (b.p - rotate(turn, a.p));
        }
        out.push_back(to);
    }
    return out;
}

// Reads the skin as a right hand, mirroring a left one.
Skin right_skin(const HandMesh& mesh)
{
    const Skin read = read_skin(mesh.path);
    return mesh.side == right ? read : mirrored(read);
}

}  // namespace

FitReport fit_hand(const std::vector<HandMesh>& meshes, Topology topology)
{
    const double begun = wall_seconds();
    const Side side = meshes.at(0).side;
    const Layout l = layout(topology);
    FitReport report{};
    report.topology = topology;
    report.side = side;
    std::vector<Skin> skins;
    std::vector<FitView> views;
    for (const HandMesh& mesh : meshes) {
        skins.push_back(right_skin(mesh));
        views.push_back({spread(skins.back(), fit_points), {}});
    }
    report.open = open_of(skins[0], spread(skins[0], check_points), side);
    const Spheres start = seeds(l, skins[0], views[0].points);
    Spheres s = start;
    report.spheres = hung(s, l.primitives, l, views[0].points);
    for (int turn = 0; turn < turns; ++turn) {
        for (std::size_t i = 1; i < views.size(); ++i)
            views[i].carries = carries(report.spheres, skins[0].joints, skins[i].joints);
        // The outlier term is enabled after the first fit: before, every point is an outlier.
        FitOptions options = options_of(topology);
        if (turn == 0) options.outlier = 0;
        refine(s, start, l.primitives, views, options);
        report.spheres = hung(s, l.primitives, l, views[0].points);
    }
    report.rig = hang(report.spheres, l.primitives, report.open, side);
    for (const Primitive& q : l.primitives) ++(q.count == 2 ? report.cones : report.slabs);
    const Skin read = read_skin(meshes[0].path);
    report.deviation =
        deviation(report.rig, side, read, spread(read, check_points), report.open, true);
    for (std::size_t i = 0; i < s.size(); ++i) {
        const double moved = length(s[i].c - start[i].c);
        report.shift += moved / double(s.size());
        report.farthest = std::max(report.farthest, moved);
    }
    report.seconds = wall_seconds() - begun;
    return report;
}

namespace {

void write_spheres(std::ostream& out, const char* name, const std::vector<FittedSphere>& spheres)
{
    char line[160];
    out << "inline constexpr FittedSphere " << name << "[] = {\n";
    for (const FittedSphere& s : spheres) {
        std::snprintf(line, sizeof line,
                      "    {{%.5ff, %.5ff, %.5ff}, %.5ff, {%d, %d, %d, %d}, {%.2ff, %.2ff, %.2ff, "
                      "%.2ff}},\n",
                      s.c.x, s.c.y, s.c.z, s.r, s.joint[0], s.joint[1], s.joint[2], s.joint[3],
                      s.weight[0], s.weight[1], s.weight[2], s.weight[3]);
        out << line;
    }
    out << "};\n";
}

}  // namespace

void write_rig_table(std::ostream& out, const FitReport& h25, const FitReport& h47)
{
    out << "// Generated by write_rig_table() in host/assets/fit.cpp; sources in "
           "docs/method/hands.md. The right\n"
           "// hand, in the frame of open_hand: wrist at the origin, fingers along -z, palm down "
           "[m].\n"
           "#pragma once\n#include \"host/hands/rig.h\"\n\nnamespace knead {\n\n"
           "struct OpenJoint {\n"
           "    Quat<float> q;  // unit to 1e-5\n"
           "    Vec3<float> p;  // [m]\n"
           "    float radius;   // to the nearest skin [m]\n};\n"
           "inline constexpr OpenJoint open_joints[joint_count] = {\n";
    char line[160];
    for (int j = 0; j < joint_count; ++j) {
        const auto& q = h25.open.joints[j].q;
        const auto& p = h25.open.joints[j].p;
        std::snprintf(line, sizeof line,
                      "    {{%.5ff, %.5ff, %.5ff, %.5ff}, {%.5ff, %.5ff, %.5ff}, %.4ff},\n", q.w,
                      q.x, q.y, q.z, p.x, p.y, p.z, h25.open.radius[j]);
        out << line;
    }
    out << "};\n\n";
    write_spheres(out, "h25_spheres", h25.spheres);
    out << "\n";
    write_spheres(out, "h47_spheres", h47.spheres);
    out << "\n}  // namespace knead\n";
}

}  // namespace knead
