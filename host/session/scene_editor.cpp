#include "host/session/scene_editor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <stdexcept>

#include "host/assets/mesh_object.h"
#include "host/base/errors.h"
#include "host/base/machine.h"
#include "host/hands/filter.h"
#include "host/scene/foresight.h"
#include "host/scene/seed.h"
#include "host/scene/soften.h"

namespace knead {
namespace {

bool same(Vec3<double> a, Vec3<double> b) { return a.x == b.x && a.y == b.y && a.z == b.z; }
bool same(Quat<double> a, Quat<double> b)
{
    return a.w == b.w && a.x == b.x && a.y == b.y && a.z == b.z;
}

bool same(const WallOptions& a, const WallOptions& b)
{
    return equal(a.min, b.min) && equal(a.max, b.max) && a.mode == b.mode &&
           a.friction == b.friction;
}

// Clay may be behind a wall that was moved after the last frame, until the next one projects it.
// Simulators take it between these walls only, and the others then as an edit.
template <class Place>
WallOptions walls_around(const SimulationConfig& config, std::size_t count, Place&& place)
{
    const WallOptions& walls = config.walls;
    for (std::size_t i = 0; i < count; ++i)
        if (!between(walls, place(i), config.lattice.dx))
            return walls_inside(config.lattice, 2, walls.mode, walls.friction);
    return walls;
}

// The motion from one pose to another.
RigidMotion<double> between_poses(const RigidMotion<double>& from, const RigidMotion<double>& to)
{
    const Quat<double> turn = unit(to.q * conjugate(from.q));
    return {turn, to.p - rotate(turn, from.p)};
}

// Number of edits of the simulator that make the one from the other, at least; without gravity.
// `numbers`: of the objects in the simulator.
int changes(const Document& from, const Document& to,
            const std::map<ObjectId, std::vector<int>>& numbers)
{
    int count = 0, gone = 0, added = 0;
    for (const auto& o : from.objects) gone += to.find(o->id) == nullptr;
    for (const auto& o : to.objects) {
        const SceneObject* before = from.find(o->id);
        // Splats are attached after their clay is added.
        if (!before) added += o->source.shape == ShapeKind::splats ? 2 : 1;
        if (!before || before == o.get()) continue;
        const int parts = int(numbers.at(o->id).size());
        if (!same(before->pose.p, o->pose.p) || !same(before->pose.q, o->pose.q)) count += parts;
        if (before->category != o->category || !equal(before->material, o->material))
            count += parts;
    }
    count += !same(from.scene->walls, to.scene->walls);
    count += from.scene->contact != to.scene->contact;
    count += !equal(*from.hands, *to.hands);
    return count + (gone > 0) + added;
}

// Whether it has no clay: of a nozzle that was not moved.
bool is_bare(const SceneObject& o) { return is_open(o) && o.source.strand->path.size() < 2; }

// The field of a command that a simulator's refusal concerns.
const char* changed_field(const Command& command)
{
    const char* field = "";
    std::visit(
        [&](const auto& c) {
            for_each_field(c, [&](const auto& f, const auto&) { field = f.key; });
        },
        command);
    return field;
}

}  // namespace

PreparedObject prepared(const Scene& scene, const WallOptions& walls, const SceneObject& object)
{
    Scene alone{};
    alone.path = scene.path;
    alone.seed = scene.seed;
    alone.setup.lattice = scene.setup.lattice, alone.setup.walls = walls;
    alone.origin = scene.origin;
    Object o = object_of(object);
    o.centre = o.centre - scene.origin;
    o.softer = softening(scene, o.material);
    o.material = softer(o.material, o.softer);
    check_substeps(scene, o.material);
    alone.objects.push_back(o);
    load_meshes(alone);
    std::vector<SplatObject> splats = load_splats(alone, available_memory());
    build(alone, available_memory());
    PreparedObject made{alone.setup.materials.at(0), std::move(alone.setup.particles), {}};
    if (!splats.empty()) made.splats = std::move(splats[0]);
    return made;
}

Box3<double> surroundings(const PreparedObject& clay)
{
    const double spacing = std::cbrt(clay.material.volume);
    Box3<double> box = empty_box<double>();
    for (const Particle<double>& p : clay.particles)
        box = {lesser(box.low, p.x), greater(box.high, p.x)};
    const Vec3<double> beside{spacing, spacing, spacing};
    return {box.low - beside, box.high + beside};
}

void leave_room(PreparedObject& clay, const std::vector<Vec3<double>>& there)
{
    clay.fitted = true;
    if (there.empty()) return;
    const NearPlaces near(there, 0.75 * std::cbrt(clay.material.volume));
    std::erase_if(clay.particles, [&](const Particle<double>& p) { return near.taken(p.x); });
    if (clay.particles.empty()) throw std::invalid_argument("other clay fills the object's place");
}

SceneEditor::SceneEditor(Parts with, DocumentPtr document, IdSource& source)
    : parts(std::move(with)), now(std::move(document)), first(now), ids(source)
{
    int number = 0;
    for (const auto& o : now->objects) {
        objects[o->id] = {number++};
        ids.use(o->id);
    }
}

Situation SceneEditor::situation(bool live) const
{
    Situation s;
    s.document = now.get();
    s.editable = parts.simulator != nullptr;
    s.live = live;
    s.no_undo = s.no_redo = s.no_steps = "no steps are kept here";
    s.no_save = "no log is kept here";
    if (shaped)
        s.work = "the shaped clay";
    else if (!equal(*now, *first))
        s.work = "what was changed since the scene was opened";
    return s;
}

CommandAnswer SceneEditor::apply(const Command& command, PreparedObject* ready)
{
    if (reads_clay(command)) return reshape(command);
    auto result = reduce(now, command, ids);
    if (Refusal* refused = std::get_if<Refusal>(&result)) return {std::move(*refused), {}};
    const DocumentPtr& to = std::get<DocumentPtr>(result);
    CommandAnswer answer{{}, with_ids(*now, command)};
    try {
        if (const Carry* c = std::get_if<Carry>(&command))
            answer.refusal = carry(*c);
        else if (to != now)
            synchronise(to, ready);
        if (AddObject* added = std::get_if<AddObject>(&answer.applied))
            added->object = *now->objects.back();
    } catch (const std::bad_alloc&) {
        answer.refusal = Refusal{"out of memory", ""};
    } catch (const std::exception& e) {
        answer.refusal = Refusal{e.what(), changed_field(command)};
    }
    return answer;
}

std::optional<Refusal> SceneEditor::move(ObjectId object, const RigidMotion<double>& motion)
{
    const SceneObject* before = now->find(object);
    if (!before) return Refusal{fmt::format("there is no object {}", object.value), "object"};
    SceneObject after = *before;
    const RigidMotion<double> pose = in_simulation(before->pose);
    after.pose = {unit(motion.q * pose.q),
                  motion.p + rotate(motion.q, pose.p) + parts.scene.origin};
    if (!parts.simulator) return Refusal{needs_edits(situation(false)), "object"};
    if (local(object))
        return Refusal{"its clay is simulated near hands only: it cannot be moved", "object"};
    const std::vector<int>& numbers = objects.at(object);
    const std::shared_ptr<const Snapshot> start =
        numbers.size() > 1 ? parts.simulator->snapshot() : nullptr;
    try {
        for (const int number : numbers) parts.simulator->move(number, motion);
    } catch (const std::exception& e) {
        if (start) parts.simulator->restore(*start);
        return Refusal{e.what(), "object"};
    }
    Document next = *now;
    for (auto& o : next.objects)
        if (o->id == object) o = std::make_shared<const SceneObject>(std::move(after));
    now = std::make_shared<const Document>(std::move(next));
    ++count, ++clay_count;
    parts.loop.clay_edited();
    return {};
}

bool SceneEditor::local(ObjectId object) const
{
    const SceneObject* o = now->find(object);
    return o && object_of(*o).local();
}

RigidMotion<double> SceneEditor::in_simulation(const RigidMotion<double>& pose) const
{
    return {pose.q, pose.p - parts.scene.origin};
}

// Clay that is carried must not fall.
Vec3<double> SceneEditor::gravity_of(const Document& document) const
{
    const bool carrying = std::ranges::any_of(
        carried, [&](const Carried& one) { return document.find(one.object) != nullptr; });
    return carrying ? Vec3<double>{0, 0, 0} : document.scene->gravity;
}

std::optional<Refusal> SceneEditor::carry(const Carry& command)
{
    std::vector<Carried> next = carried;
    for (const ObjectRef& ref : command.objects) {
        const ObjectId id = std::get<ObjectId>(resolved(*now, ref));
        if (command.begins && local(id))
            return Refusal{"its clay is simulated near hands only: it cannot be moved", "objects"};
        std::erase_if(next, [&](const Carried& one) { return one.object == id; });
        if (command.begins) next.push_back({id, command.side, {}, {}});
    }
    const bool before = carries();
    std::swap(carried, next);
    if (carries() == before) return {};
    try {
        parts.simulator->set_gravity(gravity_of(*now));
        ++count;
        return {};
    } catch (const std::exception& e) {
        std::swap(carried, next);
        return Refusal{e.what(), ""};
    }
}

std::optional<Refusal> SceneEditor::refusal_of(const Command& command) const
{
    IdSource unused = ids;
    const auto result = reduce(now, command, unused);
    const Refusal* refusal = std::get_if<Refusal>(&result);
    return refusal ? std::optional(*refusal) : std::nullopt;
}

ObjectNumbers SceneEditor::numbers() const
{
    return {objects,
            parts.simulator ? parts.simulator->config().materials : parts.scene.setup.materials};
}

// Hands and surface are not undone.
Document SceneEditor::document_of_step(const HistoryStep& step) const
{
    Document to = *step.document;
    to.hands = now->hands;
    if (to.scene->surface_nodes == now->scene->surface_nodes) return to;
    SceneSettings settings = *to.scene;
    settings.surface_nodes = now->scene->surface_nodes;
    to.scene = std::make_shared<const SceneSettings>(settings);
    return to;
}

void SceneEditor::restore_document(const HistoryStep& step)
{
    synchronise(std::make_shared<const Document>(document_of_step(step)));
}

void SceneEditor::restore(const HistoryStep& step, const ClayRows& clay)
{
    EditableSimulator& s = *parts.simulator;
    Document to = document_of_step(step);
    SimulationConfig config = s.config();
    config.materials = step.objects->materials;
    const WallOptions walls = walls_of(to);
    config.gravity = to.scene->gravity, config.walls = walls;
    config.contact = to.scene->contact;
    config.walls = walls_around(
        config, clay.count, [&](std::size_t i) { return cast<double>(particle_at(clay, i).x); });
    const std::shared_ptr<const Snapshot> before = s.snapshot();
    try {
        if (step.beginning)
            s.replace(config, *step.beginning);
        else
            s.replace(config, clay);
        if (!same(config.walls, walls)) s.set_walls(walls);
        if (step.splats || parts.splats.state().count() > 0)
            parts.splats.set_state(step.splats ? *step.splats : CarriedSplats{}, {});
    } catch (...) {
        s.restore(*before);
        throw;
    }
    now = std::make_shared<const Document>(std::move(to));
    objects = step.objects->number;
    carried.clear();
    ++count, ++clay_count;
    parts.loop.clay_edited();
}

StoredState SceneEditor::stored() const
{
    StoredState state;
    state.splats = parts.splats.state(), state.local = parts.splats.local_state();
    state.document = now, state.numbers = numbers(), state.ids_used = ids.most();
    return state;
}

void SceneEditor::load(const StoredState& from)
{
    EditableSimulator& s = *parts.simulator;
    const std::shared_ptr<const Snapshot> before = s.snapshot();
    const CarriedSplats splats_before = parts.splats.state();
    const LocalState local_before = parts.splats.local_state();
    const auto set_hands = [&](const Document& of) {
        parts.set_hands(hands_with(parts.scene.hands, *of.hands, parts.scene.origin));
    };
    const bool hands = !equal(*now->hands, *from.document->hands);
    try {
        // First, because other tools forget which clay slides along walls.
        if (hands) set_hands(*from.document);
        SavedState state = from.state;
        state.config = s.config();
        state.config.materials = from.numbers.materials;
        state.config.gravity = from.document->scene->gravity;
        state.config.contact = from.document->scene->contact;
        const WallOptions walls = walls_of(*from.document);
        state.config.walls = walls;
        const std::vector<Particle<double>>& clay = state.contents.particles;
        state.config.walls =
            walls_around(state.config, clay.size(), [&](std::size_t i) { return clay[i].x; });
        const bool moved = !same(state.config.walls, walls);
        if (moved) state.sliding.clear();  // along walls that are gone
        parts.splats.set_state(from.splats, from.local);
        s.load(state);
        if (moved) s.set_walls(walls);
        if (parts.set_surface && now->scene->surface_nodes != from.document->scene->surface_nodes)
            parts.set_surface(from.document->scene->surface_nodes);
    } catch (...) {
        parts.splats.set_state(splats_before, local_before);
        s.restore(*before);
        if (hands) set_hands(*now);
        throw;
    }
    now = from.document;
    objects = from.numbers.number;
    carried.clear();
    shaped = true;
    ++count, ++clay_count;
    parts.loop.clay_edited();
}

void SceneEditor::after_frame(const FrameResult& frame)
{
    shaped = shaped || frame.stats[Count::projected] > 0;
    for (Carried& one : carried) {
        const std::size_t palm_joint = std::size_t(int(one.side) * int(joint_count) + int(palm));
        if (palm_joint >= frame.motion.to.size()) continue;
        const Joint<double> palm_now = frame.motion.to[palm_joint];
        // A farther step is not of this hand: it was lost, or its zoom or place has changed.
        const double farthest = HandFilter::farthest_step * now->hands->zoom;
        if (one.seen && length(palm_now.p - one.seen->p) > farthest) one.palm.reset();
        one.seen = palm_now;
        // Refused beyond a wall: the clay waits there until the palm comes back.
        if (!one.palm || !move(one.object, between_poses(*one.palm, palm_now))) one.palm = palm_now;
    }
}

// Throws std::invalid_argument for what the simulator could not compute.
void SceneEditor::check(const Document& to) const
{
    const bool falls = !equal(now->scene->gravity, to.scene->gravity);
    if (!parts.simulator && (falls || changes(*now, to, objects) > 0))
        throw std::invalid_argument(needs_edits(situation(false)));
    for (const auto& o : to.objects) {
        const SceneObject* before = now->find(o->id);
        if (before && before->source.shape == ShapeKind::splats && before->category != o->category)
            throw std::invalid_argument("an object of splats keeps its category");
        if (before && object_of(*before).local() &&
            (!same(before->pose.p, o->pose.p) || !same(before->pose.q, o->pose.q)))
            throw std::invalid_argument(
                "its clay is simulated near hands only: it cannot be moved");
        if (!before && object_of(*o).local())
            throw std::invalid_argument(
                "an object with a depth is added before the first frame "
                "of a run, or by its scene");
    }
    for (const auto& o : now->objects)
        if (!to.find(o->id) && object_of(*o).local())
            throw std::invalid_argument("an object with a depth cannot be removed");
}

SceneEditor::NewClay SceneEditor::new_clay(const Document& to, PreparedObject* ready) const
{
    NewClay all;
    for (const auto& o : to.objects)
        if (!now->find(o->id) && !is_bare(*o))
            all[o->id] = ready ? std::move(*ready) : prepared(parts.scene, walls_of(to), *o);
    return all;
}

// In the simulation's frame.
WallOptions SceneEditor::walls_of(const Document& document) const
{
    if (same(document.scene->walls, now->scene->walls)) return parts.simulator->config().walls;
    WallOptions walls = document.scene->walls;
    walls.min = walls.min - parts.scene.origin, walls.max = walls.max - parts.scene.origin;
    return walls;
}

// Edits of the simulator are all or nothing each; the first that is refused leaves the others
// undone only if a snapshot from before is restored.
void SceneEditor::synchronise(const DocumentPtr& to, PreparedObject* ready)
{
    check(*to);
    NewClay added = new_clay(*to, ready);
    const bool drops = !equal(gravity_of(*now), gravity_of(*to));  // what is carried may be removed
    const bool surface = now->scene->surface_nodes != to->scene->surface_nodes;
    const std::shared_ptr<const Snapshot> before =
        parts.simulator && changes(*now, *to, objects) + drops + surface > 1
            ? parts.simulator->snapshot()
            : nullptr;
    const std::map<ObjectId, std::vector<int>> objects_before = objects;
    try {
        make(*to, added);
    } catch (...) {
        objects = objects_before;
        if (before) parts.simulator->restore(*before), parts.loop.clay_edited();
        throw;
    }
    now = to;
    ++count;
    std::erase_if(carried, [&](const Carried& one) { return !now->find(one.object); });
}

// One branch per member of a document.
void SceneEditor::make(const Document& to, NewClay& added)
{
    EditableSimulator* const s = parts.simulator;
    // What all clay permits first, what only some permits last.
    const BodyContact& contact = to.scene->contact;
    if (now->scene->contact != contact && !contact.separate) s->set_contact(contact);
    bool clay = false;
    std::vector<int> gone;
    for (const auto& o : now->objects)
        if (!to.find(o->id)) {
            const std::vector<int>& numbers = objects.at(o->id);
            gone.insert(gone.end(), numbers.begin(), numbers.end()), objects.erase(o->id);
        }
    if (!gone.empty()) parts.splats.remove_objects(gone, *s), clay = true;
    for (const auto& o : to.objects)
        if (!now->find(o->id)) objects[o->id];
    for (auto& [id, one] : added) {
        if (!one.fitted) leave_room(one, s->places(surroundings(one)));
        const int number = s->add(one.material, one.particles);
        objects[id] = {number}, clay = true;
        if (one.splats) parts.splats.add_object(number, *one.splats, *s);
    }
    for (const auto& o : to.objects) {
        const SceneObject* before = now->find(o->id);
        if (!before || before == o.get()) continue;
        const std::vector<int>& numbers = objects.at(o->id);
        if (!same(before->pose.p, o->pose.p) || !same(before->pose.q, o->pose.q)) {
            const RigidMotion<double> motion =
                between_poses(in_simulation(before->pose), in_simulation(o->pose));
            for (const int number : numbers) s->move(number, motion);
            clay = true;
        }
        const bool other = !equal(before->material, o->material);
        if (before->category == o->category && !other) continue;
        clay = true;
        for (const int number : numbers) {
            // Parts of a merged object have materials of their own, until it gets another one.
            const bool keeps = numbers.size() > 1 && !other;
            Material<double> material =
                keeps ? s->config().materials.at(std::size_t(number)) : made(o->material);
            material.category = o->category;
            if (keeps)
                s->set_material(number, material);
            else
                parts.splats.set_material(number, material, *s);
        }
    }
    if (clay) parts.loop.clay_edited(), ++clay_count;
    make_surroundings(to);
}

// Gravity, walls, hands, contact of objects, and the surface.
void SceneEditor::make_surroundings(const Document& to)
{
    EditableSimulator* const s = parts.simulator;
    const SceneSettings &was = *now->scene, &is = *to.scene;
    const Vec3<double> gravity = gravity_of(to);
    if (!equal(gravity_of(*now), gravity)) s->set_gravity(gravity);
    if (!same(was.walls, is.walls)) s->set_walls(walls_of(to));
    const bool hands = !equal(*now->hands, *to.hands);
    const auto set_hands = [&](const Document& of) {
        parts.set_hands(hands_with(parts.scene.hands, *of.hands, parts.scene.origin));
    };
    if (hands) set_hands(to);
    try {
        if (was.contact != is.contact && is.contact.separate) s->set_contact(is.contact);
        if (was.surface_nodes != is.surface_nodes && parts.set_surface)
            parts.set_surface(is.surface_nodes);
    } catch (...) {
        if (hands) set_hands(*now);
        throw;
    }
}

}  // namespace knead
