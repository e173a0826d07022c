// Edits of clay and rules between two frames; save and load. After an edit the particles are in id
// order, as in a new solver: sums depend on the order, and equal those of a scene constructed with
// the edit.
#include "cuda/mpm/edit.h"

#include <array>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "cuda/mpm/mean_pressure.h"
#include "cuda/mpm/stencil.h"
#include "host/solver/cpu/solver.h"
#include "host/solver/piece_count.h"
#include "host/solver/pieces.h"

namespace knead {
inline namespace KNEAD_CPU_LEVEL {

template <class R>
struct CpuSnapshot : Snapshot {
    std::shared_ptr<const char> solver;
    SceneState book;
    std::vector<Particle<R>> q;
    std::vector<Gaussian<R>> splats;
    std::vector<int> ids, quiet;
    std::vector<SlidingNode> sliding;
    bool was_covered = false;
    Extremes most{};
    explicit CpuSnapshot(const SceneState& rules) : book(rules) {}
    std::size_t bytes() const override
    {
        return q.size() * (sizeof q[0] + sizeof ids[0]) + quiet.size() * sizeof quiet[0] +
               splats.size() * sizeof splats[0] + sliding.size() * sizeof sliding[0];
    }
};

// Rebuilds everything derived from the configuration.
template <class R>
void CpuSolver<R>::apply_config()
{
    materials.clear();
    for (const Material<double>& m : scene.materials) materials.push_back(cast<R>(m));
    shared_pressure = std::any_of(materials.begin(), materials.end(), shares_pressure<R>);
    gravity = cast<R>(scene.gravity);
    walls = walls_on<R>(scene.lattice, scene.walls);
    bodies = bodies_of(scene), body_constants = body_fields<R>(bodies, scene);
    for (int f = 0; f < field_count(); ++f) {
        grid[f].resize(std::size_t(lattice.node_count()));
        sliding[f].resize(std::size_t(sliding_places(walls)));
    }
    split.resize(field_count() > 1 ? std::size_t(lattice.block_count()) : 0);
    edited();
    stage_times.clear();
    for (const char* name : {"pose", "bin", "p2g", "grid", "g2p", "project", "plasticity"})
        stage_times.push_back({name, 0});
    if (!splats.empty()) stage_times.push_back({"deform", 0});
}

template <class R>
void CpuSolver<R>::edited()
{
    splats_arranged = false;
    most = extremes();
    recolour();
    for (auto& field : sliding) std::fill(field.begin(), field.end(), Sliding<R>{});
    ++changes;
}

template <class R>
void CpuSolver<R>::renumber()
{
    ids.resize(q.size());
    std::iota(ids.begin(), ids.end(), 0);
    arranged = false;
}

// What an edit can change.
template <class R>
struct CpuSolver<R>::Backup {
    SceneState book;
    Walls<R> walls;
    Vec3<R> gravity;
    std::vector<Material<R>> materials;
    bool shared_pressure;
    PosedTools<R> posed;
    Stillness<R> stillness;
    std::vector<Gaussian<R>> splats;
    std::array<std::vector<Sliding<R>>, most_fields> sliding;
    Bodies bodies;
    BodyFields<R> body_constants;
    std::vector<char> split;
    std::vector<StageTime> stage_times;
    bool arranged, splats_arranged, was_covered;
    Extremes most;
    long changes;
    std::vector<Particle<R>> q{};
    std::vector<int> ids{};
};

// Calls change() with `clay` and `order` as particles and ids; if it throws, everything is as
// before.
template <class R>
template <class Change>
void CpuSolver<R>::all_or_nothing(std::vector<Particle<R>> clay, std::vector<int> order,
                                  Change&& change)
{
    Backup before{book,           walls,     gravity,     materials, shared_pressure,
                  posed,          stillness, splats,      {},        bodies,
                  body_constants, split,     stage_times, arranged,  splats_arranged,
                  was_covered,    most,      changes};
    for (std::size_t f = 0; f < std::size_t(most_fields); ++f) before.sliding[f] = sliding[f];
    before.q = std::exchange(q, std::move(clay)), before.ids = std::exchange(ids, std::move(order));
    arranged = false;
    try {
        change();
    } catch (...) {
        book = std::move(before.book), walls = before.walls, gravity = before.gravity;
        materials = std::move(before.materials), shared_pressure = before.shared_pressure;
        posed = std::move(before.posed), stillness = std::move(before.stillness);
        splats = std::move(before.splats), split = std::move(before.split);
        for (std::size_t f = 0; f < std::size_t(most_fields); ++f)
            sliding[f] = std::move(before.sliding[f]);
        bodies = std::move(before.bodies), body_constants = before.body_constants;
        stage_times = std::move(before.stage_times), most = before.most;
        arranged = before.arranged, splats_arranged = before.splats_arranged;
        was_covered = before.was_covered, changes = before.changes;
        q = std::move(before.q), ids = std::move(before.ids);
        throw;
    }
}

// The same with the particles in the order of their ids.
template <class R>
template <class Change>
void CpuSolver<R>::edit_by_id(Change&& change)
{
    std::vector<Particle<R>> sorted(q.size());
    for (std::size_t i = 0; i < q.size(); ++i) sorted[std::size_t(ids[i])] = q[i];
    std::vector<int> order(q.size());
    std::iota(order.begin(), order.end(), 0);
    all_or_nothing(std::move(sorted), std::move(order), change);
}

// Resets the frames at rest of the particle's block.
template <class R>
void CpuSolver<R>::wake(const Particle<R>& particle)
{
    if (!stillness.any()) return;
    const Int3 base = base_node(particle.x, lattice.dx);
    stillness.quiet[std::size_t(lattice.block_of(base))] = 0;
}

// Calls edit(particle) for all particles of an object, in double, as if the scene were constructed
// anew.
template <class R>
template <class Edit>
void CpuSolver<R>::edit(int object, Edit&& edit)
{
    for (Particle<R>& p : q) {
        if (p.object != object) continue;
        wake(p);
        p.hold(false);
        Particle<double> in_double = cast<double>(p);
        edit(in_double);
        p = cast<R>(in_double);
        wake(p);
    }
}

template <class R>
std::vector<int> CpuSolver<R>::add_each(const Material<double>& material, Clays clays)
{
    std::vector<int> objects;
    edit_by_id([&] {
        objects = book.add_each(material, clays);
        for (std::size_t k = 0; k < clays.size(); ++k)
            for (const Particle<double>& p : clays[k]) {
                q.push_back(cast<R>(p));
                q.back().object = objects[k];
                wake(q.back());
            }
        renumber();
        apply_config();
    });
    return objects;
}

template <class R>
void CpuSolver<R>::remove_each(std::span<const int> objects)
{
    edit_by_id([&] {
        book.remove_each(objects);
        const auto goes = [&](int object) {
            return !there(book.config().materials[std::size_t(object)]);
        };
        std::erase_if(q, [&](const Particle<R>& p) {
            if (goes(p.object)) wake(p);
            return goes(p.object);
        });
        std::erase_if(splats, [&](const Gaussian<R>& g) { return goes(g.object); });
        renumber();
        apply_config();
    });
}

template <class R>
void CpuSolver<R>::set_material(int object, const Material<double>& material)
{
    if (book.changes_category_only(object, material)) {
        book.set_material(object, material);
        materials[std::size_t(object)].category = material.category;
        ++changes;
        return;
    }
    edit_by_id([&] {
        const Plasticity law = book.set_material(object, material);
        edit(object, [&](Particle<double>& p) { change_law(p, law, material.plasticity); });
        apply_config();
    });
}

template <class R>
void CpuSolver<R>::move(int object, const RigidMotion<double>& motion)
{
    edit_by_id([&] {
        book.check_object(object);
        SceneState::check_motion(motion);
        edit(object, [&](Particle<double>& p) {
            knead::move(p, motion);
            book.check_place(p.x);
        });
        for (Gaussian<R>& g : splats) {
            if (g.object != object) continue;
            Gaussian<double> there = cast<double>(g);
            knead::move(there, motion);
            book.check_place(there.x, "a Gaussian");
            g = cast<R>(there);
        }
        edited();
    });
}

template <class R>
void CpuSolver<R>::set_gravity(Vec3<double> to)
{
    edit_by_id([&] {
        book.set_gravity(to);
        for (const Particle<R>& p : q) wake(p);
        apply_config();
    });
}

template <class R>
void CpuSolver<R>::set_walls(const WallOptions& to)
{
    edit_by_id([&] {
        book.set_walls(to);
        for (const Particle<R>& p : q) wake(p);
        apply_config();
    });
}

template <class R>
void CpuSolver<R>::set_contact(const BodyContact& to)
{
    edit_by_id([&] {
        book.set_contact(to);
        for (const Particle<R>& p : q) wake(p);
        apply_config();
    });
}

template <class R>
void CpuSolver<R>::set_tools(const Rig& rig, const std::vector<Tool<double>>& tools)
{
    edit_by_id([&] {
        book.set_tools(rig, tools);
        posed = PosedTools<R>(scene, lattice);
        apply_config();
    });
}

template <class R>
void CpuSolver<R>::attach(int object, const std::vector<Vec3<double>>& places)
{
    edit_by_id([&] {
        book.check_attach(object, places);
        const std::size_t before = splats.size();
        for (const Vec3<double>& x : places) splats.push_back(gaussian_at(cast<R>(x), object));
        if (posed.blades) {
            for (Particle<R>& p : q) p.hold(false);
            take_labels(splats, before, q, lattice);
        }
        apply_config();
    });
}

template <class R>
void CpuSolver<R>::replace_by(SceneState&& next, std::vector<Particle<R>>&& clay,
                              std::vector<Gaussian<R>>&& gaussians)
{
    std::vector<int> order(clay.size());
    std::iota(order.begin(), order.end(), 0);
    all_or_nothing(std::move(clay), std::move(order), [&] {
        book = std::move(next), splats = std::move(gaussians);
        stillness = Stillness<R>(scene.rest, lattice), was_covered = false;
        posed = PosedTools<R>(scene, lattice);
        apply_config();
    });
}

template <class R>
void CpuSolver<R>::replace(const SimulationConfig& config, const ClayRows& clay)
{
    SceneState next = book.replaced(config, clay);
    std::vector<Particle<R>> all(clay.count);
    for (std::size_t i = 0; i < clay.count; ++i) all[i] = cast<R>(particle_at(clay, i));
    std::vector<Gaussian<R>> gaussians;
    for (const Gaussian<float>& g : clay.gaussians) gaussians.push_back(cast<R>(g));
    replace_by(std::move(next), std::move(all), std::move(gaussians));
}

template <class R>
void CpuSolver<R>::replace(const SimulationConfig& config, const InitialState& contents)
{
    SceneState next = book.replaced(config, contents);
    std::vector<Particle<R>> all;
    for (const Particle<double>& p : contents.particles) all.push_back(cast<R>(p));
    std::vector<Gaussian<R>> gaussians;
    for (const Gaussian<double>& g : contents.gaussians) gaussians.push_back(cast<R>(g));
    replace_by(std::move(next), std::move(all), std::move(gaussians));
}

// Nodes whose clay slid in the last substep.
template <class R>
std::vector<SlidingNode> CpuSolver<R>::sliding_now() const
{
    std::vector<SlidingNode> all;
    for (std::size_t f = 0, n = 0; f < std::size_t(most_fields); ++f)
        for (const Sliding<R>& s : sliding[f]) {
            if (s.substep == substeps)
                all.push_back({int(n), float(s.force), float(s.time), float(s.impulse_deficit)});
            ++n;
        }
    return all;
}
template <class R>
void CpuSolver<R>::slide_on(const std::vector<SlidingNode>& nodes)
{
    const std::size_t each = sliding[0].size();
    for (const SlidingNode& s : nodes) {
        const auto n = std::size_t(s.place);
        sliding[n / each][n % each] = {R(s.force), R(s.time), substeps, R(s.impulse_deficit)};
    }
}

template <class R>
std::vector<int> CpuSolver<R>::piece_counts(std::span<const int> group, int groups) const
{
    return knead::piece_counts(q, lattice, materials, group, groups);
}

template <class R>
std::shared_ptr<const Snapshot> CpuSolver<R>::snapshot() const
{
    auto to = std::make_shared<CpuSnapshot<R>>(book);
    to->solver = identity, to->q = q, to->ids = ids, to->splats = splats;
    to->quiet = stillness.quiet, to->was_covered = was_covered, to->most = most;
    to->sliding = sliding_now();
    return to;
}

template <class R>
const CpuSnapshot<R>& CpuSolver<R>::known(const Snapshot& snapshot) const
{
    const auto* from = dynamic_cast<const CpuSnapshot<R>*>(&snapshot);
    if (!from || from->solver != identity)
        throw std::invalid_argument("the snapshot is of another solver");
    return *from;
}

template <class R>
void CpuSolver<R>::restore(const Snapshot& snapshot)
{
    const auto& from = known(snapshot);
    all_or_nothing(from.q, from.ids, [&] {  // sorts again; a stable sort keeps the order
        book = from.book, splats = from.splats;
        stillness.quiet = from.quiet, was_covered = from.was_covered;
        posed = PosedTools<R>(scene, lattice);
        apply_config();
        most = from.most;
        slide_on(from.sliding);
    });
}

template <class R>
Extremes CpuSolver<R>::extremes() const
{
    double speed_squared = 0, stiffest = 0;
    for (const Particle<R>& p : q) {
        speed_squared = std::max(speed_squared, double(dot(p.v, p.v)));
        stiffest = std::max(stiffest, double(stiffness(p, materials[std::size_t(p.object)])));
    }
    return {std::sqrt(speed_squared), stiffest};
}

template <class R>
SnapshotData CpuSolver<R>::held(const Snapshot& snapshot) const
{
    const auto& from = known(snapshot);
    return {in_double(from.q, from.ids), in_double(from.splats)};
}

template <class R>
ClayRows CpuSolver<R>::rows(const Snapshot& snapshot) const
{
    const auto& from = known(snapshot);
    ClayRows to = empty_rows(from.q.size());
    for (std::size_t i = 0; i < from.q.size(); ++i)
        set_particle(to, std::size_t(from.ids[i]), cast<float>(from.q[i]));
    to.gaussians.reserve(from.splats.size());
    for (const Gaussian<R>& g : from.splats) {
        to.gaussians.push_back(cast<float>(g));
        to.gaussians.back().hold(false);
    }
    return to;
}

template <class R>
std::vector<Particle<double>> CpuSolver<R>::particles() const
{
    return in_double(q, ids);
}

template <class R>
SavedState CpuSolver<R>::saved(const Snapshot& snapshot) const
{
    const auto& from = known(snapshot);
    SavedState state;
    state.config = from.book.config();
    state.contents = {in_double(from.q, from.ids), in_double(from.splats)};
    state.order = from.ids;
    state.speed_squared = float(from.most.speed * from.most.speed);
    state.stiffness = float(from.most.stiffness);
    state.quiet = from.quiet, state.quiet_stored = lattice.stored;
    state.covered = from.was_covered, state.sliding = from.sliding;
    return state;
}

template <class R>
void CpuSolver<R>::load(const SavedState& state)
{
    check_state(state, scene);
    std::vector<Particle<R>> clay;
    for (int id : state.order) clay.push_back(cast<R>(state.contents.particles[std::size_t(id)]));
    all_or_nothing(std::move(clay), state.order, [&] {
        book = SceneState(state);
        splats.clear();
        for (const Gaussian<double>& g : state.contents.gaussians) splats.push_back(cast<R>(g));
        stillness = Stillness<R>(scene.rest, lattice);
        if (stillness.any()) stillness.quiet = quiet_over(state, lattice);
        was_covered = state.covered;
        posed = PosedTools<R>(scene, lattice);
        apply_config();
        most = {std::sqrt(double(state.speed_squared)), state.stiffness};
        slide_on(state.sliding);
    });
}

template class CpuSolver<float>;

}  // namespace KNEAD_CPU_LEVEL
}  // namespace knead
