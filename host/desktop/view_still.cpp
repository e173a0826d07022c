#include "host/desktop/view_still.h"

#include <algorithm>

namespace knead {
namespace {

bool same(const EyeView& a, const EyeView& b)
{
    const Vec3<float> way = a.position - b.position;
    return dot(way, way) == 0 && a.rotation.w == b.rotation.w && a.rotation.x == b.rotation.x &&
           a.rotation.y == b.rotation.y && a.rotation.z == b.rotation.z && a.left == b.left &&
           a.right == b.right && a.down == b.down && a.up == b.up && a.width == b.width &&
           a.height == b.height;
}

bool same(const Meshes& a, const Meshes& b, float within)
{
    if (a == b) return true;
    if (!a || !b || a->size() != b->size()) return false;
    const auto near = [&](const Vec3<float>& p, const Vec3<float>& q) {
        const Vec3<float> d = p - q;
        return dot(d, d) <= within * within;
    };
    for (std::size_t i = 0; i < a->size(); ++i) {
        const Mesh &p = (*a)[i], &q = (*b)[i];
        if (p.triangles.size() != q.triangles.size() ||
            !std::equal(p.vertices.begin(), p.vertices.end(), q.vertices.begin(), q.vertices.end(),
                        near))
            return false;
    }
    return true;
}

using Gaussians = std::shared_ptr<const std::vector<Gaussian<double>>>;
bool same(const Gaussians& a, const Gaussians& b, double within)
{
    if (a == b) return true;
    return a && b &&
           std::equal(a->begin(), a->end(), b->begin(), b->end(),
                      [&](const Gaussian<double>& p, const Gaussian<double>& q) {
                          const Vec3<double> d = p.x - q.x;
                          return dot(d, d) <= within * within;
                      });
}

}  // namespace

bool alike(const PictureContent& a, const PictureContent& b)
{
    return a.history == b.history && a.highlight == b.highlight &&
           a.splat_version == b.splat_version && same(a.view, b.view) && a.hands == b.hands &&
           a.hidden == b.hidden && a.on_device == b.on_device &&
           a.gaussians_on_device == b.gaussians_on_device && same(a.meshes, b.meshes, b.within) &&
           same(a.gaussians, b.gaussians, double(b.within));
}

}  // namespace knead
