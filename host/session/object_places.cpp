#include "host/session/object_places.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "host/session/scene_editor.h"

namespace knead {
namespace {

// Squared distance from a point to a box; 0 inside.
double outside(const Box3<double>& box, Vec3<double> x)
{
    const auto beyond = [](double low, double high, double at) {
        return std::max({low - at, at - high, 0.0});
    };
    const Vec3<double> d{beyond(box.low.x, box.high.x, x.x), beyond(box.low.y, box.high.y, x.y),
                         beyond(box.low.z, box.high.z, x.z)};
    return dot(d, d);
}

}  // namespace

const ObjectPlace* ObjectPlaces::find(ObjectId object) const
{
    const auto at = std::ranges::find(all, object, &ObjectPlace::object);
    return at == all.end() ? nullptr : &*at;
}

ObjectId ObjectPlaces::nearest(const Document& document, int category, Vec3<double> x) const
{
    std::vector<const ObjectPlace*> of;
    for (const ObjectPlace& one : all) {
        const SceneObject* const object = document.find(one.object);
        if (object && object->category == category) of.push_back(&one);
    }
    if (of.empty()) return {};
    if (of.size() == 1) return of.front()->object;
    double best = std::numeric_limits<double>::infinity();
    ObjectId found;
    for (const ObjectPlace* one : of) {
        if (outside(one->box, x) >= best) continue;
        for (const Vec3<float>& p : one->some) {
            const Vec3<double> d = cast<double>(p) - x;
            if (dot(d, d) < best) best = dot(d, d), found = one->object;
        }
    }
    return found;
}

CommonPlace common_place(const ObjectPlaces& places, const std::vector<ObjectId>& objects)
{
    CommonPlace all{empty_box<double>(), {}, 0};
    int count = 0;
    for (const ObjectId id : objects) {
        const ObjectPlace* const one = places.find(id);
        if (!one) continue;
        all.box = {lesser(all.box.low, one->box.low), greater(all.box.high, one->box.high)};
        all.centre = all.centre + one->centre, ++count;
        all.spacing = std::max(all.spacing, one->spacing);
    }
    if (count > 0) all.centre = (1.0 / count) * all.centre;
    return all;
}

std::vector<ObjectId> objects_of(const Mesh& mesh, const Document& document,
                                 const ObjectPlaces& places)
{
    std::vector<const ObjectPlace*> of;
    for (const ObjectPlace& one : places.all) {
        const SceneObject* const object = document.find(one.object);
        if (object && object->category == mesh.category) of.push_back(&one);
    }
    std::vector<ObjectId> found(mesh.vertices.size());
    if (of.empty()) return found;
    if (of.size() == 1) {
        std::ranges::fill(found, of.front()->object);
        return found;
    }
    std::vector<Vec3<double>> points;
    std::vector<ObjectId> owners;
    for (const ObjectPlace* one : of)
        for (const Vec3<float>& p : one->some)
            points.push_back(cast<double>(p)), owners.push_back(one->object);
    const NearestPoint nearest(std::move(points));
    for (std::size_t i = 0; i < found.size(); ++i) {
        const Vec3<double> x = cast<double>(mesh.vertices[i]);
        // Most vertices are near the box of one object only.
        int near = 0;
        for (const ObjectPlace* one : of) {
            const double reach = 2 * one->spacing;
            if (outside(one->box, x) < reach * reach) ++near, found[i] = one->object;
        }
        if (near != 1) found[i] = owners[std::size_t(nearest(x).index)];
    }
    return found;
}

PartedMeshes parted(const std::vector<Mesh>& meshes, const Document& document,
                    const ObjectPlaces& places, const std::vector<ObjectId>& some)
{
    PartedMeshes made;
    for (const Mesh& mesh : meshes) {
        const std::vector<ObjectId> object = objects_of(mesh, document, places);
        Mesh parts[2];
        std::vector<int> number[2];
        for (int k = 0; k < 2; ++k)
            parts[k].category = mesh.category, number[k].resize(mesh.vertices.size(), -1);
        const auto vertex = [&](int k, int i) {
            int& to = number[k][std::size_t(i)];
            if (to < 0) {
                to = int(parts[k].vertices.size());
                parts[k].vertices.push_back(mesh.vertices[std::size_t(i)]);
                parts[k].normals.push_back(mesh.normals[std::size_t(i)]);
            }
            return to;
        };
        const auto chosen = [&](int i) {
            return std::ranges::count(some, object[std::size_t(i)]) > 0;
        };
        for (const Int3& t : mesh.triangles) {
            const int k = chosen(t.x) + chosen(t.y) + chosen(t.z) >= 2 ? 0 : 1;
            parts[k].triangles.push_back({vertex(k, t.x), vertex(k, t.y), vertex(k, t.z)});
        }
        if (!parts[0].triangles.empty()) made.some.push_back(std::move(parts[0]));
        if (!parts[1].triangles.empty()) made.others.push_back(std::move(parts[1]));
    }
    return made;
}

ObjectPlaces SceneEditor::places() const
{
    ObjectPlaces found;
    found.edits = clay_count;
    if (!parts.simulator) return found;
    const ClayRows rows = parts.simulator->rows(*parts.simulator->snapshot());
    const std::vector<Material<double>>& materials = parts.simulator->config().materials;
    struct Part {
        std::size_t count = 0;
        Vec3<double> sum{};
        Box3<double> box = empty_box<double>();
    };
    std::vector<Part> of_number(materials.size());
    const auto at = [&](std::size_t i) {
        return Vec3<double>{rows.planes[i], rows.planes[rows.count + i],
                            rows.planes[2 * rows.count + i]};
    };
    for (std::size_t i = 0; i < rows.count; ++i) {
        Part& part = of_number.at(std::size_t(rows.object[i]));
        const Vec3<double> x = at(i);
        ++part.count, part.sum = part.sum + x;
        part.box = {lesser(part.box.low, x), greater(part.box.high, x)};
    }
    std::vector<int> place_of(materials.size(), -1);  // in `all`, of each number
    std::vector<std::size_t> counts;
    for (const auto& o : now->objects) {
        ObjectPlace place{o->id, empty_box<double>(), {}, 0, {}, 0};
        double mass = 0;
        std::size_t particles = 0;
        for (const int number : objects.at(o->id)) {
            const Part& part = of_number.at(std::size_t(number));
            if (part.count == 0) continue;
            const Material<double>& m = materials[std::size_t(number)];
            place.box = {lesser(place.box.low, part.box.low),
                         greater(place.box.high, part.box.high)};
            place.centre = place.centre + m.mass * part.sum;
            mass += m.mass * double(part.count), particles += part.count;
            place.spacing = std::max(place.spacing, std::cbrt(m.volume));
            place_of[std::size_t(number)] = int(found.all.size());
        }
        if (particles == 0) continue;
        place.centre = (1 / mass) * place.centre;
        found.all.push_back(std::move(place)), counts.push_back(particles);
    }
    std::vector<std::size_t> steps, seen(counts.size(), 0);
    for (std::size_t k = 0; k < counts.size(); ++k) {
        steps.push_back((counts[k] + ObjectPlace::most_samples - 1) / ObjectPlace::most_samples);
        found.all[k].apart = std::cbrt(double(steps.back())) * found.all[k].spacing;
    }
    for (std::size_t i = 0; i < rows.count; ++i) {
        const int of = place_of[std::size_t(rows.object[i])];
        if (of < 0) continue;
        if (seen[std::size_t(of)]++ % steps[std::size_t(of)] == 0)
            found.all[std::size_t(of)].some.push_back(cast<float>(at(i)));
    }
    return found;
}

}  // namespace knead
