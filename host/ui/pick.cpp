#include "host/ui/pick.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

namespace knead {
namespace {

constexpr double nowhere = std::numeric_limits<double>::infinity();

// A ray along the third axis of its own frame, whose origin is the ray's.
struct Ray {
    Vec3<double> origin, u, v, along;  // the axes are unit vectors

    Vec3<double> seen(Vec3<float> x) const
    {
        const Vec3<double> d = cast<double>(x) - origin;
        return {dot(u, d), dot(v, d), dot(along, d)};
    }
    Vec3<double> at(double distance) const { return origin + distance * along; }
};

struct Hit {
    double distance = nowhere;
    Vec3<double> normal{};
};

// The nearest triangle, from either side. An edge belongs to both its triangles: the
// sign of each side comes from the same two numbers for both, so no ray passes between them.
Hit hit(const Ray& ray, const Mesh& mesh)
{
    std::vector<Vec3<double>> seen(mesh.vertices.size());
    std::transform(mesh.vertices.begin(), mesh.vertices.end(), seen.begin(),
                   [&](Vec3<float> x) { return ray.seen(x); });
    const auto side = [](const Vec3<double>& a, const Vec3<double>& b) {
        return a.x * b.y - a.y * b.x;
    };
    Hit nearest;
    const Int3* best = nullptr;
    for (const Int3& t : mesh.triangles) {
        const Vec3<double>& a = seen[std::size_t(t.x)];
        const Vec3<double>& b = seen[std::size_t(t.y)];
        const Vec3<double>& c = seen[std::size_t(t.z)];
        const double of_c = side(a, b), of_a = side(b, c), of_b = side(c, a);
        const double low = std::min({of_a, of_b, of_c}), high = std::max({of_a, of_b, of_c});
        if ((low < 0 && high > 0) || low == high) continue;
        const double far = (of_a * a.z + of_b * b.z + of_c * c.z) / (of_a + of_b + of_c);
        if (far > 0 && far < nearest.distance) nearest.distance = far, best = &t;
    }
    if (!best) return nearest;
    const auto corner = [&](int i) { return cast<double>(mesh.vertices[std::size_t(i)]); };
    const Vec3<double> n =
        cross(corner(best->y) - corner(best->x), corner(best->z) - corner(best->x));
    const double size = length(n);
    nearest.normal = size > 0 ? (1 / size) * n : -1.0 * ray.along;
    return nearest;
}

// Along the ray, to the point of it where a splat is densest; nowhere if that is beyond two
// standard deviations. `axes`: its half axes.
double passed(const Ray& ray, Vec3<double> centre, const Mat3<double>& axes)
{
    constexpr double deviations = 2;
    const Vec3<double> to = centre - ray.origin;
    const double ahead = dot(to, ray.along);
    const Vec3<double> off = to - ahead * ray.along;
    const double size = dot(axes.a, axes.a) + dot(axes.b, axes.b) + dot(axes.c, axes.c);
    if (dot(off, off) > deviations * deviations * size) return nowhere;
    // In units of the half axes: solutions of axes * y = x by Cramer's rule.
    const Vec3<double> bc = cross(axes.b, axes.c), ca = cross(axes.c, axes.a),
                       ab = cross(axes.a, axes.b);
    const double det = dot(axes.a, bc);
    if (det == 0 || !std::isfinite(det)) return nowhere;
    const auto within = [&](Vec3<double> x) {
        return (1 / det) * Vec3<double>{dot(bc, x), dot(ca, x), dot(ab, x)};
    };
    const Vec3<double> o = within(to), d = within(ray.along);
    const double far = dot(o, d) / dot(d, d);
    const Vec3<double> least = o - far * d;
    return far > 0 && dot(least, least) <= deviations * deviations ? far : nowhere;
}

// The half axes of splat i, not thinner than a thousandth of the thickest.
Mat3<double> half_axes(const SplatCloud& cloud, std::size_t i)
{
    const Quat<double> q = cast<double>(cloud.rotation[i]);
    Vec3<double> s = cast<double>(cloud.scale[i]);
    const double least = 1e-3 * std::max({s.x, s.y, s.z, 1e-9});
    s = {std::max(s.x, least), std::max(s.y, least), std::max(s.z, least)};
    return {rotate(q, Vec3<double>{s.x, 0, 0}), rotate(q, Vec3<double>{0, s.y, 0}),
            rotate(q, Vec3<double>{0, 0, s.z})};
}

Hit hit(const Ray& ray, const LiveState& state)
{
    constexpr float opaque = 0.5f;
    const SplatCloud& cloud = *state.splats;
    SplatFrame fetched;
    if (state.gaussians_on_device) state.gaussians_on_device->fetch(fetched);
    const std::size_t moved =
        state.gaussians ? state.gaussians->size() : fetched.moved_centre.size();
    double nearest = nowhere;
    for (std::size_t i = 0; i < cloud.count(); ++i) {
        if (cloud.opacity[i] < opaque) continue;
        Vec3<double> x = cast<double>(cloud.centre[i]);
        Mat3<double> axes = half_axes(cloud, i);
        if (i < moved && state.gaussians) {
            const Gaussian<double>& g = (*state.gaussians)[i];
            x = g.x, axes = g.F * axes;
        } else if (i < moved) {
            const Mat3<float>& F = fetched.moved_F[i];
            x = cast<double>(fetched.moved_centre[i]);
            axes = Mat3<double>{cast<double>(F.a), cast<double>(F.b), cast<double>(F.c)} * axes;
        }
        nearest = std::min(nearest, passed(ray, x, axes));
    }
    return {nearest, -1.0 * ray.along};
}

bool made_of_splats(const SceneObject& o) { return o.source.shape == ShapeKind::splats; }

// How far the point is from the object as the document has it, and from its centre [m].
std::pair<double, double> away(const SceneObject& o, Vec3<double> point)
{
    const Vec3<double> d = rotate(conjugate(o.pose.q), point - o.pose.p);
    if (made_of_splats(o)) return {std::max(0.0, length(d) - o.source.splats.size / 2), length(d)};
    const auto beyond = [](double x, double size) { return std::max(0.0, std::abs(x) - size / 2); };
    Vec3<double> size = own_extents(o);
    if (o.source.shape == ShapeKind::mesh && !(size.x > 0))  // its file has not been read
        size = o.source.mesh.size * Vec3<double>{1, 1, 1};
    return {length(Vec3<double>{beyond(d.x, size.x), beyond(d.y, size.y), beyond(d.z, size.z)}),
            length(d)};
}

template <class Belongs>
ObjectId nearest_to(const Document& document, Vec3<double> point, Belongs&& belongs)
{
    std::tuple<double, double, ObjectId> best{nowhere, nowhere, ObjectId{}};
    for (const auto& o : document.objects) {
        if (o->hidden || !belongs(*o)) continue;
        const auto [outside, centre] = away(*o, point);
        best = std::min(best, {outside, centre, o->id});
    }
    return std::get<ObjectId>(best);
}

}  // namespace

std::optional<Picked> pick(const LiveState& state, Vec3<double> origin, Vec3<double> direction,
                           const ObjectPlaces* places)
{
    const double norm = length(direction);
    if (!state.document || !(norm > 0)) return {};
    const Document& document = *state.document;
    const Vec3<double> along = (1 / norm) * direction, u = orthogonal(along);
    const Ray ray{origin, u, cross(along, u), along};
    const Vec3<double> frame = state.scene ? state.scene->scene.origin : Vec3<double>{};

    Picked best{{}, {}, {}, nowhere};
    const auto offer = [&](const Hit& found, const auto& belongs) {
        if (!(found.distance < best.distance)) return;
        const Vec3<double> point = ray.at(found.distance);
        const ObjectId object = nearest_to(document, point + frame, belongs);
        if (object.value != 0) best = {object, point, found.normal, found.distance};
    };
    const std::vector<int> hidden = document.hidden_categories();
    const Meshes meshes = meshes_of(state);
    for (const Mesh& mesh : *meshes)
        if (std::find(hidden.begin(), hidden.end(), mesh.category) == hidden.end()) {
            const Hit found = hit(ray, mesh);
            ObjectId known;
            if (places && found.distance < best.distance)
                known = places->nearest(document, mesh.category, ray.at(found.distance));
            if (known.value && document.find(known)->hidden) known = {};
            offer(found, [&](const SceneObject& o) {
                return known.value ? o.id == known : o.category == mesh.category;
            });
        }
    const bool splats = std::any_of(document.objects.begin(), document.objects.end(),
                                    [](const auto& o) { return made_of_splats(*o) && !o->hidden; });
    if (state.splats && splats) offer(hit(ray, state), made_of_splats);
    if (best.distance == nowhere) return {};
    return best;
}

std::optional<SurfaceHit> pick_surface(const std::vector<Mesh>& meshes, Vec3<double> origin,
                                       Vec3<double> direction)
{
    const double norm = length(direction);
    if (!(norm > 0)) return {};
    const Vec3<double> along = (1 / norm) * direction, u = orthogonal(along);
    const Ray ray{origin, u, cross(along, u), along};
    Hit best;
    for (const Mesh& mesh : meshes)
        if (const Hit found = hit(ray, mesh); found.distance < best.distance) best = found;
    if (best.distance == nowhere) return {};
    return SurfaceHit{ray.at(best.distance), best.normal, best.distance};
}

}  // namespace knead
