#include "host/ui/new_object.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "host/base/paths.h"
#include "host/scene/letters.h"
#include "host/scene/presets.h"
#include "host/scene/shapes.h"

namespace knead {
namespace {

constexpr double part_of_room = 0.2;  // of the shortest side between the walls
constexpr double part_of_mesh = 0.4;  // of the same, along its longest extent
constexpr double widest = 0.8;        // of a text: part of the side along which it is read

Vec3<double> size_of(ShapeKind shape, double across, Vec3<double> between, const Letters* letters)
{
    switch (shape) {
        case ShapeKind::ellipsoid:
            return across * Vec3<double>{1.2, 0.8, 1};
        case ShapeKind::capsule:
            return across * Vec3<double>{0.6, 1.2, 0.6};
        case ShapeKind::torus:
            return across * Vec3<double>{1.4, 0.4, 1.4};
        case ShapeKind::text: {
            double capital = across;
            if (letters)
                capital = std::min({capital, widest * between.x / letters->width(),
                                    widest * between.y / letters->height()});
            return {0, capital, across / 2};
        }
        default:
            return {across, across, across};
    }
}

// Height of the highest clay in a column, `floor` if there is none.
class Heights {
  public:
    Heights(const LiveState& state, const std::vector<ObjectId>& recent)
        : meshes_(meshes_of(state)), document_(*state.document), recent_(recent)
    {
        if (state.scene) frame_ = state.scene->scene.origin;
    }
    double above(Vec3<double> middle, Vec3<double> half, double floor) const
    {
        double top = floor;
        const auto in_column = [&](Vec3<double> low, Vec3<double> high) {
            return high.x >= middle.x - half.x && low.x <= middle.x + half.x &&
                   high.z >= middle.z - half.z && low.z <= middle.z + half.z;
        };
        for (const Mesh& mesh : *meshes_)
            for (const Vec3<float> vertex : mesh.vertices) {
                const Vec3<double> x = cast<double>(vertex) + frame_;
                if (in_column(x, x)) top = std::max(top, x.y);
            }
        for (const auto& o : document_.objects) {
            const bool splats = o->source.shape == ShapeKind::splats;
            if (!splats && std::ranges::find(recent_, o->id) == recent_.end()) continue;
            const double reach = o->source.splats.size / 2;
            const Vec3<double> all{reach, reach, reach};
            const Box3<double> box =
                splats ? Box3<double>{o->pose.p - all, o->pose.p + all} : box_of(object_of(*o));
            if (in_column(box.low, box.high)) top = std::max(top, box.high.y);
        }
        return top;
    }

  private:
    Meshes meshes_;
    const Document& document_;
    const std::vector<ObjectId>& recent_;
    Vec3<double> frame_{};
};

// Where the centre of a box is.
Vec3<double> free_place(const LiveState& state, const std::vector<ObjectId>& recent,
                        Vec3<double> size, double gap)
{
    const WallOptions& walls = state.document->scene->walls;
    const Heights heights(state, recent);
    const Vec3<double> half = 0.5 * size, beside{gap, gap, gap};
    const Vec3<double> middle = 0.5 * (walls.min + walls.max),
                       free = 0.5 * (walls.max - walls.min) - half;
    const double most = walls.max.y - half.y - std::min(gap, 0.01 * size.y);
    std::vector<Vec3<double>> places;
    for (int i = -2; i <= 2; ++i)
        for (int k = -2; k <= 2; ++k)
            places.push_back({middle.x + i * std::max(0.0, free.x) / 2, most,
                              middle.z + k * std::max(0.0, free.z) / 2});
    std::ranges::stable_sort(places, {}, [&](Vec3<double> p) {
        return length(Vec3<double>{p.x - middle.x, 0, p.z - middle.z});
    });
    for (const Vec3<double> p : places) {
        const double y = heights.above(p, half + beside, walls.min.y) + gap + half.y;
        if (y <= most) return {p.x, y, p.z};
    }
    return places.front();
}

}  // namespace

std::string free_name(const Document& document, const std::string& base)
{
    const auto taken = [&](const std::string& name) {
        return std::ranges::any_of(document.objects,
                                   [&](const auto& o) { return o->name == name; });
    };
    std::string name = base;
    for (int n = 2; taken(name); ++n) name = fmt::format("{} {}", base, n);
    return name;
}

int free_category(const Document& document)
{
    const auto has_splats = [&](int category) {
        return std::ranges::any_of(document.objects, [&](const auto& o) {
            return o->category == category && o->source.shape == ShapeKind::splats;
        });
    };
    int category = 0;
    while (category < 255 && has_splats(category)) ++category;
    return category;
}

SceneObject new_object(const LiveState& state, const std::vector<ObjectId>& recent,
                       const NewShape& shape, const MaterialSpec& material, const std::string& text)
{
    const WallOptions& walls = state.document->scene->walls;
    const Vec3<double> between = walls.max - walls.min;
    const double across = part_of_room * std::min({between.x, between.y, between.z});
    SceneObject o;
    o.name = free_name(*state.document, shape.name);
    o.category = free_category(*state.document);
    o.material = material;
    o.source.shape = shape.shape;
    if (shape.shape == ShapeKind::text) o.source.text = text;
    if (shape.shape == ShapeKind::rounded_box) o.source.rounding = across / 4;
    const auto letters = shape.shape == ShapeKind::text ? letters_of(text).letters : nullptr;
    o.source.size = size_of(shape.shape, across, between, letters.get());
    // A surface is about a cell around its clay.
    const double cells = state.scene ? 2 * state.scene->scene.setup.lattice.dx : across;
    const double gap = std::min(cells, across / 4);
    o.pose.p = free_place(state, recent, own_extents(o), gap);
    return o;
}

SceneObject new_mesh(const LiveState& state, const std::string& file)
{
    namespace fs = std::filesystem;
    const WallOptions& walls = state.document->scene->walls;
    const Vec3<double> between = walls.max - walls.min;
    SceneObject o;
    o.name = free_name(*state.document, fs::path(file).stem().string());
    o.category = free_category(*state.document);
    o.material = material_spec("soft-clay");
    o.source.shape = ShapeKind::mesh;
    o.source.mesh.file = fs::absolute(file).lexically_normal().string();
    const std::string form = ending(file);
    o.source.mesh.up = form == ".stl" || form == ".3mf" ? UpAxis::z : UpAxis::y;
    const double all = part_of_mesh * std::min({between.x, between.y, between.z});
    o.source.mesh.size = all;
    const double cells = state.scene ? 2 * state.scene->scene.setup.lattice.dx : all;
    // Of a file that has not been read the extents are not known: of a cube around it.
    Vec3<double> size = own_extents(o);
    if (!(size.x > 0)) size = {all, all, all};
    o.pose.p = free_place(state, {}, size, std::min(cells, all / 4));
    return o;
}

}  // namespace knead
