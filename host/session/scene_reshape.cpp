// SceneEditor: commands that read the clay, applied by the functions of object_verbs.h.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <optional>
#include <set>
#include <unordered_map>

#include "cuda/mpm/walls.h"
#include "host/base/machine.h"
#include "host/scene/foresight.h"
#include "host/scene/object_json.h"
#include "host/scene/soften.h"
#include "host/session/scene_editor.h"
#include "host/solver/bodies.h"

namespace knead {
namespace {

// A field of the command is at fault.
struct VerbRefused {
    Refusal refusal;
};
[[noreturn]] void refuse_field(const char* field, const std::string& why)
{
    throw VerbRefused{{why, field}};
}

ObjectId id_of(const ObjectRef& ref) { return std::get<ObjectId>(ref.by); }

// Three digits, rounded down.
std::string text_of_factor(double factor)
{
    const double digits = std::pow(10, 2 - std::floor(std::log10(factor)));
    return fmt::format("{:.3g}", std::floor(factor * digits) / digits);
}

// Of clay that there is.
Box3<double> box_of_clay(const std::vector<PartClay>& clay)
{
    const Box3<double> box = box_of(clay);
    if (!(box.low.x <= box.high.x)) refuse_field("objects", "an object has no clay");
    return box;
}

void check_memory_of(double particles, const char* field)
{
    // As check_memory() of seed.cpp: the lists of the host and of the solver.
    constexpr double one = 2 * sizeof(Particle<double>) + 2 * sizeof(Particle<float>) + 32;
    const double bytes = particles * one, free = double(available_memory());
    if (bytes > free)
        refuse_field(field, fmt::format("{:.4g} particles need about {:.1f} MiB, and {:.1f} MiB "
                                        "are free",
                                        particles, bytes / 0x1p20, free / 0x1p20));
}

}  // namespace

// Applies a command to the clay of this frame. As applied, it has the numbers of the new objects.
CommandAnswer SceneEditor::reshape(const Command& command)
{
    const IdSource ids_before = ids;
    CommandAnswer answer;
    try {
        IdSource unused = ids;
        auto result = reduce(now, command, unused);
        if (Refusal* refused = std::get_if<Refusal>(&result)) return {std::move(*refused), {}};
        if (!parts.simulator) return {Refusal{needs_edits(situation(false)), ""}, {}};
        answer.applied = with_ids(*now, command);
        if (std::get<DocumentPtr>(result) == now) return answer;
        ClayEdit edit;
        if (CopyObjects* copies = std::get_if<CopyObjects>(&answer.applied))
            edit = edit_of(*copies);
        else if (MoveObjects* motion = std::get_if<MoveObjects>(&answer.applied))
            edit = edit_of(*motion);
        else if (ResetObjects* resets = std::get_if<ResetObjects>(&answer.applied))
            edit = edit_of(*resets);
        else if (ScaleObjects* scales = std::get_if<ScaleObjects>(&answer.applied))
            edit = edit_of(*scales);
        else if (MergeObjects* merges = std::get_if<MergeObjects>(&answer.applied))
            edit = edit_of(*merges);
        else if (SourceBegin* begins = std::get_if<SourceBegin>(&answer.applied))
            edit = edit_of(*begins);
        else if (SourceMove* moves = std::get_if<SourceMove>(&answer.applied))
            edit = edit_of(*moves, *std::get<DocumentPtr>(result));
        else if (SourceEnd* ends = std::get_if<SourceEnd>(&answer.applied))
            edit = edit_of(*ends, *std::get<DocumentPtr>(result));
        else
            edit = edit_of(std::get<SplitObject>(answer.applied));
        result = reduce(now, answer.applied, ids);
        if (Refusal* refused = std::get_if<Refusal>(&result)) return {std::move(*refused), {}};
        const DocumentPtr to = std::get<DocumentPtr>(result);
        edit.gravity = gravity_of(*to);
        const long laid = edit.laid, left_out = edit.left_out;
        make(std::move(edit));
        now = to;
        if (std::holds_alternative<SourceBegin>(answer.applied))
            sourced = {new_ids(answer.applied).at(0), 0, 0, false};
        sourced.laid += laid, sourced.left_out += left_out;
        if (laid + left_out > 0) sourced.clogged = laid == 0;
        ++count, ++clay_count;
        std::erase_if(carried, [&](const Carried& one) { return !now->find(one.object); });
        return answer;
    } catch (const VerbRefused& refused) {
        answer.refusal = refused.refusal;
    } catch (const std::bad_alloc&) {
        answer.refusal = Refusal{"out of memory", ""};
    } catch (const std::exception& e) {
        answer.refusal = Refusal{e.what(), ""};
    }
    ids = ids_before;
    return answer;
}

// All or nothing.
void SceneEditor::make(ClayEdit edit)
{
    EditableSimulator& s = *parts.simulator;
    const bool drops = !equal(gravity_of(*now), edit.gravity);
    const std::size_t edits = !edit.gone.empty() + edit.added.size() + edit.moved.size() +
                              edit.materials.size() + drops + (edit.splats ? 2 : 0);
    // A single edit has no effect if it fails. A nozzle makes one per move, or none.
    const std::shared_ptr<const Snapshot> before = edits > 1 ? s.snapshot() : nullptr;
    const CarriedSplats splats_before = edit.splats ? parts.splats.state() : CarriedSplats{};
    try {
        if (!edit.gone.empty()) s.remove_each(edit.gone);
        std::vector<int> numbers;
        for (const ClayEdit::NewPart& one : edit.added) {
            numbers.push_back(s.add(one.clay.material, one.clay.particles));
            edit.objects[one.object].push_back(numbers.back());
        }
        for (const int number : edit.moved) s.move(number, edit.motion);
        for (const auto& [number, material] : edit.materials) s.set_material(number, material);
        if (drops) s.set_gravity(edit.gravity);
        if (edit.splats) replace_splats(edit, numbers, splats_before);
    } catch (...) {
        if (!before) throw;
        s.restore(*before);
        if (splats_before.count() > 0)
            parts.splats.set_state(splats_before, parts.splats.local_state());
        parts.loop.clay_edited();
        throw;
    }
    objects = std::move(edit.objects);
    if (edits > 0) parts.loop.clay_edited();
}

// `numbers`: of edit.added, in the simulator. `before`: empty if splats are not drawn.
void SceneEditor::replace_splats(const ClayEdit& edit, const std::vector<int>& numbers,
                                 const CarriedSplats& before)
{
    std::vector<Gaussian<double>> gaussians;
    std::vector<std::uint32_t> from;
    for (const ClayEdit::NewGaussian& one : edit.gaussians) {
        gaussians.push_back(one.gaussian);
        if (one.part >= 0) gaussians.back().object = numbers.at(std::size_t(one.part));
        from.push_back(std::uint32_t(one.from));
    }
    if (before.count() == 0) return parts.simulator->set_gaussians(gaussians);
    CarriedSplats all{picked(before.cloud, from), {}};
    for (std::size_t i = 0; i < from.size(); ++i) {
        const float scale = float(edit.gaussians[i].scale);
        all.cloud.scale[i] = scale * all.cloud.scale[i];
        all.extent.push_back(scale * before.extent[from[i]]);
    }
    parts.splats.replace(gaussians, std::move(all), *parts.simulator);
}

// One for each number, in their order, with the materials of the simulator.
std::vector<PartClay> SceneEditor::clay_of(const SnapshotData& all,
                                           const std::vector<int>& numbers) const
{
    const std::vector<Material<double>>& materials = parts.simulator->config().materials;
    std::vector<PartClay> clay;
    std::unordered_map<int, std::size_t> part_of;
    for (const int number : numbers) {
        part_of[number] = clay.size();
        clay.push_back({materials.at(std::size_t(number)), {}});
    }
    for (const Particle<double>& p : all.particles) {
        const auto at = part_of.find(p.object);
        if (at == part_of.end()) continue;
        clay[at->second].particles.push_back(p);
        clay[at->second].particles.back().hold(false);
    }
    return clay;
}

SceneEditor::ClayEdit SceneEditor::unchanged(const SnapshotData& all) const
{
    ClayEdit edit;
    edit.objects = objects;
    for (std::size_t i = 0; i < all.gaussians.size(); ++i)
        edit.gaussians.push_back({all.gaussians[i], i});
    return edit;
}

void SceneEditor::check_place(const std::vector<PartClay>& clay, const char* field) const
{
    const SimulationConfig& config = parts.simulator->config();
    const Box3<double> box = box_of_clay(clay);
    if (between(config.walls, box.low, config.lattice.dx) &&
        between(config.walls, box.high, config.lattice.dx))
        return;
    const auto text = [&](Vec3<double> x) {
        x = x + parts.scene.origin;
        return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", x.x, x.y, x.z);
    };
    refuse_field(field, fmt::format("expected the clay between the walls, from {} to {} m, found "
                                    "it from {} to {} m",
                                    text(config.walls.min), text(config.walls.max), text(box.low),
                                    text(box.high)));
}

// `there`: clay that must not be nearer than three quarters of a spacing. `before`: the same clay
// at another place; what was that near there may be so again.
void SceneEditor::check_free(const std::vector<PartClay>& clay,
                             const std::vector<Particle<double>>& there, const char* field,
                             const std::vector<PartClay>* before) const
{
    Box3<double> box = box_of(clay);
    if (before) {
        const Box3<double> was = box_of(*before);
        box = {lesser(box.low, was.low), greater(box.high, was.high)};
    }
    for (std::size_t k = 0; k < clay.size(); ++k) {
        const PartClay& part = clay[k];
        const double spacing = std::cbrt(part.material.volume);
        const Vec3<double> beside{spacing, spacing, spacing};
        const Box3<double> around{box.low - beside, box.high + beside};
        std::vector<Vec3<double>> places;
        for (const Particle<double>& p : there)
            if (contains(around, p.x)) places.push_back(p.x);
        const NearPlaces near(places, 0.75 * spacing);
        for (std::size_t i = 0; i < part.particles.size(); ++i)
            if (near.taken(part.particles[i].x) &&
                !(before && near.taken((*before)[k].particles[i].x)))
                refuse_field(field, "other clay is in the way");
    }
}

SceneEditor::ClayEdit SceneEditor::edit_of(CopyObjects& command) const
{
    const SnapshotData all = parts.simulator->held(*parts.simulator->snapshot());
    const WallOptions& walls = parts.simulator->config().walls;
    ClayEdit edit = unchanged(all);
    IdSource next = ids;
    for (std::size_t i = command.ids.size(); i < command.objects.size(); ++i)
        command.ids.push_back(next.next());
    double particles = 0;
    for (std::size_t i = 0; i < command.objects.size(); ++i) {
        const std::vector<int>& numbers = objects.at(id_of(command.objects[i]));
        std::vector<PartClay> clay = clay_of(all, numbers);
        for (const PartClay& part : clay) particles += double(part.particles.size());
        check_memory_of(particles, "objects");
        displace(clay, command.by);
        check_place(clay, "by");
        check_free(clay, all.particles, "by");
        for (std::size_t k = 0; k < all.gaussians.size(); ++k) {
            const auto at = std::ranges::find(numbers, all.gaussians[k].object);
            if (at == numbers.end()) continue;
            Gaussian<double> copy = all.gaussians[k];
            copy.x = put_between(walls, copy.x + command.by), copy.hold(false);
            const int part = int(edit.added.size()) + int(at - numbers.begin());
            edit.gaussians.push_back({copy, k, part});
            edit.splats = true;
        }
        for (PartClay& part : clay) edit.added.push_back({command.ids[i], std::move(part)});
    }
    return edit;
}

SceneEditor::ClayEdit SceneEditor::edit_of(MoveObjects& command) const
{
    const SnapshotData all = parts.simulator->held(*parts.simulator->snapshot());
    ClayEdit edit;
    edit.objects = objects;
    std::vector<std::vector<PartClay>> clay;
    Vec3<double> middle{};
    for (const ObjectRef& ref : command.objects) {
        const std::vector<int>& numbers = objects.at(id_of(ref));
        edit.moved.insert(edit.moved.end(), numbers.begin(), numbers.end());
        clay.push_back(clay_of(all, numbers));
        middle = middle + (1 / double(command.objects.size())) * centre_of_mass(clay.back());
    }
    if (command.turn && !command.about) command.about = middle + parts.scene.origin;
    const Quat<double> q = command.turn ? unit_rotation(*command.turn) : Quat<double>{1, 0, 0, 0};
    const Vec3<double> about = command.about.value_or(parts.scene.origin) - parts.scene.origin;
    edit.motion = {q, about - rotate(q, about) + command.by.value_or(Vec3<double>{})};
    std::vector<Particle<double>> there;
    for (const Particle<double>& p : all.particles)
        if (!std::ranges::count(edit.moved, p.object)) there.push_back(p);
    const char* const field = command.turn ? "turn" : "by";
    for (const std::vector<PartClay>& before : clay) {
        std::vector<PartClay> after = before;
        for (PartClay& part : after)
            for (Particle<double>& p : part.particles)
                p.x = edit.motion.p + rotate(edit.motion.q, p.x);
        check_place(after, field);
        check_free(after, there, field, &before);
    }
    return edit;
}

SceneEditor::ClayEdit SceneEditor::edit_of(ResetObjects& command) const
{
    // More or less clay than so was split off or merged, not just trimmed where it was added.
    constexpr double least = 0.85, most = 1.15;
    const SnapshotData all = parts.simulator->held(*parts.simulator->snapshot());
    ClayEdit edit = unchanged(all);
    for (const ObjectRef& ref : command.objects) {
        const std::vector<int>& numbers = objects.at(id_of(ref));
        edit.gone.insert(edit.gone.end(), numbers.begin(), numbers.end());
    }
    std::vector<Particle<double>> there;
    for (const Particle<double>& p : all.particles)
        if (!std::ranges::count(edit.gone, p.object)) there.push_back(p);
    for (const ObjectRef& ref : command.objects) {
        const SceneObject& o = *now->find(id_of(ref));
        double volume = 0;
        for (const PartClay& part : clay_of(all, objects.at(o.id)))
            volume += part.material.volume * double(part.particles.size());
        PreparedObject fresh = prepared(parts.scene, parts.simulator->config().walls, o);
        const std::size_t whole = fresh.particles.size();
        const double share = volume / (fresh.material.volume * double(whole));
        const bool one = objects.at(o.id).size() == 1 || o.source.shape == ShapeKind::strand;
        if (share < least || share > most || !one)
            refuse_field("objects",
                         fmt::format("\"{}\" has {:.0f} % of the clay that it was made with: it "
                                     "was merged or split",
                                     o.name.substr(0, 60), 100 * share));
        std::vector<Vec3<double>> places;
        const Box3<double> around = surroundings(fresh);
        for (const Particle<double>& p : there)
            if (contains(around, p.x)) places.push_back(p.x);
        leave_room(fresh, places);
        if (double(fresh.particles.size()) < least * double(whole))
            refuse_field("objects", "other clay is in the way");
        std::vector<PartClay> clay{{fresh.material, std::move(fresh.particles)}};
        check_place(clay, "objects");
        edit.objects.at(o.id).clear();
        there.insert(there.end(), clay[0].particles.begin(), clay[0].particles.end());
        edit.added.push_back({o.id, std::move(clay[0])});
    }
    return edit;
}

namespace {

// How far clay is shifted along an axis so that it is not behind a wall: to half a spacing from it,
// or to the distance that it had. It is from `low` to `high`, and was from `was_low` to `was_high`.
double shift_between(double low, double high, double was_low, double was_high, double min,
                     double max, double spacing)
{
    double from = min + std::clamp(was_low - min, 0.0, spacing / 2);
    double to = max - std::clamp(max - was_high, 0.0, spacing / 2);
    if (high - low > to - from) from = min, to = max;
    return low < from ? from - low : high > to ? to - high : 0;
}

}  // namespace

SceneEditor::ClayEdit SceneEditor::edit_of(ScaleObjects& command) const
{
    const SimulationConfig& config = parts.simulator->config();
    const Vec3<double>&min = config.walls.min, &max = config.walls.max;
    const double factor = command.factor, dx = config.lattice.dx;
    const SnapshotData all = parts.simulator->held(*parts.simulator->snapshot());
    ClayEdit edit = unchanged(all);
    double particles = 0;
    for (const ObjectRef& ref : command.objects) {
        const std::vector<int>& numbers = objects.at(id_of(ref));
        edit.gone.insert(edit.gone.end(), numbers.begin(), numbers.end());
        for (const PartClay& part : clay_of(all, numbers))
            particles += std::ldexp(double(part.particles.size()),
                                    doublings(per_cell_of(part.material, factor, dx)));
    }
    check_memory_of(particles, "factor");
    // Clay of other objects, and of those that have their new size already.
    std::vector<Particle<double>> there;
    for (const Particle<double>& p : all.particles)
        if (!std::ranges::count(edit.gone, p.object)) there.push_back(p);
    for (const ObjectRef& ref : command.objects) {
        const ObjectId id = id_of(ref);
        const std::vector<int>& numbers = objects.at(id);
        std::vector<PartClay> clay = clay_of(all, numbers);
        const Box3<double> was = box_of_clay(clay);
        const Vec3<double> centre = centre_of_mass(clay);
        double spacing = 0;
        for (PartClay& part : clay) {
            part = scaled(std::move(part), centre, factor, dx);
            spacing = std::max(spacing, std::cbrt(part.material.volume));
        }
        const Box3<double> is = box_of(clay);
        const Vec3<double> size = is.high - is.low, room = max - min;
        const double largest =
            factor * std::min({room.x / size.x, room.y / size.y, room.z / size.z});
        if (largest < factor)
            refuse_field("factor", fmt::format("the object does not fit between the walls; the "
                                               "largest factor that fits is {}",
                                               text_of_factor(largest)));
        const Vec3<double> by{
            shift_between(is.low.x, is.high.x, was.low.x, was.high.x, min.x, max.x, spacing),
            shift_between(is.low.y, is.high.y, was.low.y, was.high.y, min.y, max.y, spacing),
            shift_between(is.low.z, is.high.z, was.low.z, was.high.z, min.z, max.z, spacing)};
        displace(clay, by);
        check_place(clay, "factor");
        if (factor > 1) check_free(clay, there, "factor");
        for (ClayEdit::NewGaussian& one : edit.gaussians) {
            const auto at = std::ranges::find(numbers, all.gaussians[one.from].object);
            if (at == numbers.end()) continue;
            one.part = int(edit.added.size()) + int(at - numbers.begin()), one.scale = factor;
            one.gaussian.x =
                put_between(config.walls, centre + factor * (one.gaussian.x - centre) + by);
            one.gaussian.hold(false);
            edit.splats = true;
        }
        edit.objects.at(id).clear();
        for (PartClay& part : clay) {
            there.insert(there.end(), part.particles.begin(), part.particles.end());
            edit.added.push_back({id, std::move(part)});
        }
    }
    return edit;
}

// A nozzle has laid no clay before it is moved.
SceneEditor::ClayEdit SceneEditor::edit_of(SourceBegin& command) const
{
    const double h = parts.simulator->config().lattice.dx / std::cbrt(ObjectSource{}.per_cell);
    if (command.diameter < h)
        refuse_field("diameter", fmt::format("expected at least a particle's {:.4g} m, found "
                                             "{:.4g} m",
                                             h, command.diameter));
    ClayEdit edit;
    edit.objects = objects;
    IdSource next = ids;
    if (command.ids.empty()) command.ids = {next.next()};
    edit.objects[command.ids.at(0)];
    return edit;
}

// Clay is laid at rest, where there is none and between the walls, as another simulator's object of
// the same object.
SceneEditor::ClayEdit SceneEditor::edit_of(SourceMove& command, const Document& to) const
{
    const SimulationConfig& config = parts.simulator->config();
    const ObjectId id = id_of(command.object);
    Object o = object_of(*to.find(id));
    ClayEdit edit;
    edit.objects = objects;
    const double h = config.lattice.dx / std::cbrt(o.per_cell);
    PartClay clay;
    o.softer = softening(parts.scene, o.material);
    o.material = softer(o.material, o.softer), clay.material = o.material;
    clay.material.volume = h * h * h;
    clay.material.mass = clay.material.density * clay.material.volume;
    check_substeps(parts.scene, o.material);
    check_memory_of(laid_volume(*o.strand) / clay.material.volume, "at");
    for (const Vec3<double>& p : laid(*o.strand, h, o.strand->path.size() - 1)) {
        const Vec3<double> x = o.centre + rotate(o.rotation, p) - parts.scene.origin;
        if (between(config.walls, x, config.lattice.dx))
            clay.particles.push_back({x, {}, {}, {}, 0, 0, 0});
        else
            ++edit.left_out;
    }
    if (clay.particles.empty()) return edit;
    const Vec3<double> beside{h, h, h};
    const Box3<double> box = box_of({clay});
    const NearPlaces near(parts.simulator->places({box.low - beside, box.high + beside}), 0.75 * h);
    edit.left_out += long(
        std::erase_if(clay.particles, [&](const Particle<double>& p) { return near.taken(p.x); }));
    edit.laid = long(clay.particles.size());
    if (!clay.particles.empty()) edit.added.push_back({id, std::move(clay)});
    return edit;
}

SceneEditor::ClayEdit SceneEditor::edit_of(SourceEnd& command, const Document& to) const
{
    ClayEdit edit;
    edit.objects = objects;
    if (!to.find(id_of(command.object))) edit.objects.erase(id_of(command.object));
    return edit;
}

// The clay is not read: it only takes the category of the first object.
SceneEditor::ClayEdit SceneEditor::edit_of(MergeObjects& command) const
{
    ClayEdit edit;
    edit.objects = objects;
    const ObjectId stays = id_of(command.objects[0]);
    const int category = now->find(stays)->category;
    for (std::size_t i = 1; i < command.objects.size(); ++i) {
        const ObjectId id = id_of(command.objects[i]);
        for (const int number : objects.at(id)) {
            edit.objects.at(stays).push_back(number);
            Material<double> material = parts.simulator->config().materials.at(std::size_t(number));
            if (material.category == category) continue;
            material.category = category;
            edit.materials.emplace_back(number, material);
        }
        edit.objects.erase(id);
    }
    return edit;
}

namespace {

// The part of each particle, in the order of `places`; of a plane, 0 is before it.
Pieces parts_of(const SplitObject& command, const std::vector<PartClay>& clay,
                const std::vector<Vec3<double>>& places, Vec3<double> origin,
                const Lattice<double>& lattice)
{
    if (!command.plane) {
        Pieces pieces = connected_pieces(clay, lattice);
        if (pieces.count < 2)
            refuse_field("pieces", fmt::format("there is no other piece of at least {} particles",
                                               fewest_particles_in_part));
        return pieces;
    }
    Pieces sides{2, {}};
    for (const Vec3<double>& x : places)
        sides.of_particle.push_back(
            side_of(x, command.plane->point - origin, command.plane->normal));
    const std::size_t behind = std::size_t(std::ranges::count(sides.of_particle, 1));
    const std::size_t least = std::min(behind, places.size() - behind);
    if (least == 0) refuse_field("plane", "all of the object is on one side");
    if (least < fewest_particles_in_part)
        refuse_field("plane", fmt::format("expected at least {} particles on each side, found {}",
                                          fewest_particles_in_part, least));
    return sides;
}

// Numbers of the parts: the largest, of equal ones the first, keeps `id`; the others have the given
// ones of a log, or the next ones.
std::vector<ObjectId> part_ids(const std::vector<ObjectId>& given, ObjectId id, IdSource next,
                               const Pieces& pieces)
{
    std::vector<std::size_t> size(std::size_t(pieces.count), 0);
    for (const int one : pieces.of_particle) ++size[std::size_t(one)];
    const auto largest = std::ranges::max_element(size) - size.begin();
    std::vector<ObjectId> all = given;
    std::erase(all, id);
    while (given.empty() && all.size() + 1 < size.size()) all.push_back(next.next());
    if (all.size() + 1 != size.size())
        refuse_field("ids",
                     fmt::format("expected {} numbers, found {}", size.size(), all.size() + 1));
    all.insert(all.begin() + largest, id);
    return all;
}

}  // namespace

// Pieces of bodies that do not weld are bodies, too: each but the one that keeps `id` gets an
// unused category. Where there is none left, pieces have that of the object, and weld where they
// touch.
void SceneEditor::give_categories(SplitObject& command, ObjectId id) const
{
    if (command.plane || !command.categories.empty() || !now->scene->contact.separate) return;
    std::set<int> used;
    for (const auto& o : now->objects) used.insert(o->category);
    const int own = now->find(id)->category;
    int next = 0;
    for (const ObjectId part : command.ids) {
        command.categories.push_back(own);
        if (part == id || used.size() >= std::size_t(most_bodies)) continue;
        while (used.contains(next)) ++next;
        command.categories.back() = next, used.insert(next);
    }
}

SceneEditor::ClayEdit SceneEditor::edit_of(SplitObject& command) const
{
    const SnapshotData all = parts.simulator->held(*parts.simulator->snapshot());
    const ObjectId id = id_of(command.object);
    const std::vector<int>& numbers = objects.at(id);
    const std::vector<PartClay> clay = clay_of(all, numbers);
    std::vector<Vec3<double>> places;
    for (const PartClay& part : clay)
        for (const Particle<double>& p : part.particles) places.push_back(p.x);
    const Vec3<double> origin = parts.scene.origin;
    const Pieces pieces =
        parts_of(command, clay, places, origin, parts.simulator->config().lattice);
    command.ids = part_ids(command.ids, id, ids, pieces);
    give_categories(command, id);
    ClayEdit edit = unchanged(all);
    edit.gone = numbers, edit.objects.at(id).clear();
    // Index of the new part of each old one and piece; -1: none.
    const std::size_t count_of_pieces = command.ids.size();
    std::vector<std::vector<int>> part_of(clay.size(), std::vector<int>(count_of_pieces, -1));
    std::size_t at = 0;
    for (std::size_t k = 0; k < clay.size(); ++k) {
        std::vector<PartClay> of_piece(count_of_pieces, PartClay{clay[k].material, {}});
        for (const Particle<double>& p : clay[k].particles)
            of_piece[std::size_t(pieces.of_particle[at++])].particles.push_back(p);
        for (std::size_t piece = 0; piece < count_of_pieces; ++piece) {
            if (of_piece[piece].particles.empty()) continue;
            part_of[k][piece] = int(edit.added.size());
            if (!command.categories.empty())
                of_piece[piece].material.category = command.categories.at(piece);
            edit.added.push_back({command.ids[piece], std::move(of_piece[piece])});
        }
    }
    std::optional<NearestPoint> nearest;
    for (ClayEdit::NewGaussian& one : edit.gaussians) {
        const auto number = std::ranges::find(numbers, one.gaussian.object);
        if (number == numbers.end()) continue;
        if (!command.plane && !nearest) nearest.emplace(places);
        const Vec3<double> x = one.gaussian.x;
        const std::size_t piece = std::size_t(
            command.plane ? side_of(x, command.plane->point - origin, command.plane->normal)
                          : pieces.of_particle[std::size_t((*nearest)(x).index)]);
        one.part = part_of[std::size_t(number - numbers.begin())][piece];
        // A part of a merged object may have no particles there: another one of the piece has.
        for (std::size_t k = 0; one.part < 0; ++k) one.part = part_of[k][piece];
        one.gaussian.hold(false);
        edit.splats = true;
    }
    return edit;
}

}  // namespace knead
