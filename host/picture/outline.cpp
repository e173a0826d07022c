#include "host/picture/outline.h"

#include <utility>

namespace knead {

void add_line(Mesh& mesh, Vec3<double> from, Vec3<double> to, double thick)
{
    const double size = length(to - from);
    if (!(size > 0)) return;
    const Vec3<double> along = (1 / size) * (to - from), u = orthogonal(along), v = cross(along, u);
    const int first = int(mesh.vertices.size());
    for (const Vec3<double> end : {from, to})
        for (const Vec3<double> side : {u, v, -1.0 * u, -1.0 * v}) {
            mesh.vertices.push_back(cast<float>(end + (thick / 2) * side));
            mesh.normals.push_back(cast<float>(side));
        }
    for (int i = 0; i < 4; ++i) {
        const int a = first + i, b = first + (i + 1) % 4;
        mesh.triangles.push_back({a, b, a + 4}), mesh.triangles.push_back({b, b + 4, a + 4});
    }
    for (const int end : {0, 4}) {
        const int a = first + end, back = end == 0 ? 2 : 0;
        mesh.triangles.push_back({a, a + 1 + back / 2, a + 2 - back / 2});
        mesh.triangles.push_back({a, a + 2 + back / 2, a + 3 - back / 2});
    }
}

Mesh box_corners(const Box3<double>& box, double thick)
{
    Mesh mesh;
    const Vec3<double> size = 0.2 * (box.high - box.low);
    for (int corner = 0; corner < 8; ++corner) {
        const bool x = corner & 1, y = corner & 2, z = corner & 4;
        const Vec3<double> at{x ? box.high.x : box.low.x, y ? box.high.y : box.low.y,
                              z ? box.high.z : box.low.z};
        add_line(mesh, at, at + Vec3<double>{x ? -size.x : size.x, 0, 0}, thick);
        add_line(mesh, at, at + Vec3<double>{0, y ? -size.y : size.y, 0}, thick);
        add_line(mesh, at, at + Vec3<double>{0, 0, z ? -size.z : size.z}, thick);
    }
    return mesh;
}

HandLook mark_look(Mesh mesh, Vec3<float> colour, float opacity)
{
    HandLook look;
    look.skins.push_back(std::move(mesh));
    look.opacity = opacity, look.skin = false, look.glow = colour, look.mark = true;
    return look;
}

}  // namespace knead
