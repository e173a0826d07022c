#include "host/assets/splat_object.h"

#include <fmt/format.h>

#include <cmath>

#include "cuda/math/box.h"
#include "host/assets/upright.h"
#include "host/base/errors.h"
#include "host/splats/deformed.h"

namespace knead {
namespace {

// Keeps the splats between the walls: others, floaters missed by the cleaning, cannot be placed.
void keep_between(const WallOptions& walls, const FilledObject& filled, SplatObject& object)
{
    std::vector<std::uint32_t> between;
    for (std::uint32_t i = 0; i < filled.splats.count(); ++i) {
        const Vec3<double> x = cast<double>(filled.splats.centre[i]);
        if (!contains({walls.min, walls.max}, x)) continue;
        object.surface += i < filled.surface;
        between.push_back(i);
    }
    object.beyond = filled.splats.count() - between.size();
    object.cloud = picked(filled.splats, between);
}

// No splats of the file are left after cleaning, or they have no extent.
[[noreturn]] void refuse_empty(const std::string& path, std::size_t count, const CleanCloud& left,
                               const CleanOptions& options)
{
    const std::string found =
        !left.kept.empty() ? "all at one point"
        : left.report.faint == count
            ? fmt::format("{} splats, all fainter than an opacity of {}", count,
                          options.min_opacity)
            : fmt::format(
                  "{} splats, none of which is left: {} fainter than an opacity of {}, {} "
                  "far from the others, {} too large",
                  count, left.report.faint, options.min_opacity, left.report.far, left.report.huge);
    throw InputError(path + ": expected splats of an object, found " + found);
}

SplatObject loaded(Scene& scene, std::size_t index, std::size_t memory)
{
    Object& o = scene.objects[index];
    const SplatFile read = read_splats(o.splats.file);
    const SplatCloud& file = read.cloud;
    FillOptions options;
    options.cell = scene.setup.lattice.dx, options.per_cell = o.per_cell, options.seed = scene.seed;
    options.max_bytes = memory;
    const CleanCloud cleaned = clean(file, options.clean);
    // In the object's frame and in the scene's.
    const Quat<double> own = upright(o.splats.up, o.splats.turn), turn = o.rotation * own;
    Box3<double> box = empty_box<double>(), turned = box;
    for (const std::uint32_t i : cleaned.kept) {
        const Vec3<double> x = cast<double>(file.centre[i]);
        grow(box, rotate(own, x)), grow(turned, rotate(turn, x));
    }
    const double longest = longest_edge(box);
    if (!(longest > 0)) refuse_empty(o.splats.file, file.count(), cleaned, options.clean);
    const double scale = o.splats.size / longest;
    const Vec3<double> shift = o.centre - scale * rotate(o.rotation, centre(box));
    if (o.local()) {
        o.size = scale * edges(turned);
        ObjectParticles none;
        none.middle = shift + scale * centre(turned);
        none.volume = std::pow(options.cell, 3) / options.per_cell;
        o.given = std::make_shared<const ObjectParticles>(std::move(none));
        SplatObject still{int(index), placed(file, turn, scale, shift), file.count(), {}, 0, true};
        still.dropped = read.repairs.dropped(), still.remarks = remarks(read);
        return still;
    }
    FilledObject filled = fill(placed(file, turn, scale, shift), cleaned, options);

    SplatObject object{int(index), {}, 0, filled.report, 0};
    object.dropped = read.repairs.dropped(), object.remarks = remarks(read);
    keep_between(scene.setup.walls, filled, object);
    ObjectParticles given;
    given.particles = std::move(filled.particles), given.volume = filled.particle_volume;
    Box3<double> all = empty_box<double>();
    for (const Vec3<double>& x : given.particles) grow(all, x);
    for (const Vec3<float>& x : object.cloud.centre) given.splats.push_back(cast<double>(x));
    given.middle = centre(all), o.size = edges(all);
    o.given = std::make_shared<const ObjectParticles>(std::move(given));
    return object;
}

}  // namespace

std::vector<SplatObject> load_splats(Scene& scene, std::size_t memory)
{
    std::vector<SplatObject> objects;
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        if (scene.objects[i].shape != ShapeKind::splats) continue;
        const auto where = [&] { return fmt::format("{}: /objects/{}: ", scene.path, i); };
        try {
            objects.push_back(loaded(scene, i, memory));
        } catch (const MemoryError& e) {
            throw MemoryError(where() + e.what());
        } catch (const InputError& e) {
            throw InputError(where() + e.what());
        }
    }
    return objects;
}

SplatCloud joined(const std::vector<SplatObject>& objects, bool local)
{
    SplatCloud all;
    for (const SplatObject& o : objects) all.degree = max(all.degree, o.cloud.degree);
    const auto append = [](auto& to, const auto& from) {
        to.insert(to.end(), from.begin(), from.end());
    };
    for (const SplatObject& o : objects) {
        const SplatCloud& c = o.cloud;
        if (o.local != local) continue;
        all.antialiased = all.antialiased || c.antialiased;
        append(all.centre, c.centre), append(all.rotation, c.rotation);
        append(all.scale, c.scale), append(all.opacity, c.opacity);
        const int own = harmonics(c.degree), wanted = harmonics(all.degree);
        for (std::size_t i = 0; i < c.count(); ++i)
            for (int k = 0; k < wanted; ++k)
                all.sh.push_back(k < own ? c.sh[i * std::size_t(own) + std::size_t(k)]
                                         : Vec3<float>{0, 0, 0});
    }
    return all;
}

}  // namespace knead
