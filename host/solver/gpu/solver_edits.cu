// Edits of the GPU solver. The host holds the rules, the store edits the device arrays, and the
// graphs are captured again on the next submit().
#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "host/solver/gpu/solver.cuh"
#include "host/solver/pieces.h"

namespace knead::gpu {
namespace {

constexpr RigidMotion<double> at_rest{{1, 0, 0, 0}, {0, 0, 0}};
constexpr double unsorted = 1e30;

std::vector<char> marked(std::span<const int> objects, std::size_t of)
{
    std::vector<char> marks(of, 0);
    for (const int object : objects)
        if (object >= 0 && std::size_t(object) < of) marks[std::size_t(object)] = 1;
    return marks;
}

}  // namespace

void GpuSolver::check_idle() const
{
    if (submitted != collected) throw std::logic_error("a frame is in flight");
    check(cudaSetDevice(device), "device");
}

void GpuSolver::adopt(const SceneState& rules)
{
    store.set_rules(rules);
    book = std::make_shared<const SceneState>(rules);
}

void GpuSolver::wake(int object)
{
    if (!store.features().rests) return;
    const Views views = store.views();
    gpu::wake(views.particles[side], object, views.lattice, views.rest.quiet, main);
}

// Sets the clock for the next frame: current particle buffer, largest speed and stiffness, and the
// bound of the displacement since the last sort.
void GpuSolver::set_clock(Peak most, double apart)
{
    Clock clock = store.clock(main);
    peak = most, drift = apart;
    clock.side = side, clock.drift = apart;
    clock.active[clock.done % 3] = 0;  // these blocks may be far from the clay now
    clock.set_peak(clock.done + 1, most);
    store.set_clock(clock);
}

void GpuSolver::edited()
{
    const Extent around = store.extent(every_object, at_rest, side, main);
    if (store.features().fixed_point && !around.empty())
        store.arrange_as_new(around, side, main), side = 0;
    store.forget_sliding(main);
    store.recolour(config(), side, main);
    set_clock(around.peak, unsorted);
    show();
    ++changes, stale = true, posed = false;
}

std::vector<int> GpuSolver::add_each(const Material<double>& material, Clays clays)
{
    check_idle();
    SceneState next = *book;
    const std::vector<int> objects = next.add_each(material, clays);
    if (next.count() > book->count()) {
        store.append(clays, objects, side, main);
        side = 0;
    }
    adopt(next);
    for (const int object : objects) wake(object);
    edited();
    return objects;
}

void GpuSolver::remove_each(std::span<const int> objects)
{
    check_idle();
    SceneState next = *book;
    next.remove_each(objects);
    for (const int object : objects) wake(object);
    const std::vector<char> gone = marked(objects, next.config().materials.size());
    if (next.count() < book->count()) {
        store.erase(gone, next.count(), side, main);
        side = 0;
    }
    splats.erase(gone, main);
    adopt(next);
    edited();
}

void GpuSolver::set_material(int object, const Material<double>& material)
{
    check_idle();
    SceneState next = *book;
    const bool category_only = next.changes_category_only(object, material);
    const Plasticity law = next.set_material(object, material);
    if (category_only) {
        auto made = std::make_shared<const SceneState>(std::move(next));
        store.set_category(object, material.category);
        book = std::move(made);
        ++changes;
        return;
    }
    wake(object);
    change_law(store.views().particles[side], object, law, material.plasticity, main);
    wait(main, "set material");
    adopt(next);
    edited();
}

void GpuSolver::move(int object, const RigidMotion<double>& motion)
{
    check_idle();
    book->check_object(object);
    SceneState::check_motion(motion);
    const Extent of_splats = splats.extent(object, motion, main);
    if (!of_splats.empty()) {
        book->check_place(cast<double>(of_splats.lowest()), "a Gaussian");
        book->check_place(cast<double>(of_splats.highest()), "a Gaussian");
    }
    const Extent to = store.extent(object, motion, side, main);
    if (!to.empty()) {
        book->check_place(cast<double>(to.lowest()));
        book->check_place(cast<double>(to.highest()));
        store.hold({to.lowest(), to.highest()});
    }
    wake(object);
    gpu::move(store.views().particles[side], object, motion, main);
    gpu::move(splats.view(), object, motion, main);
    wake(object);
    edited();
}

void GpuSolver::attach(int object, const std::vector<Vec3<double>>& places)
{
    check_idle();
    book->check_attach(object, places);
    std::vector<Gaussian<double>> all = gaussians();
    const std::size_t before = all.size();
    for (const Vec3<double>& x : places)
        all.push_back(gaussian_at(cast<double>(cast<float>(x)), object));
    if (store.features().blades) take_labels(all, before, particles(), config().lattice);
    splats.set(all, store.views().lattice);
    edited();
}

void GpuSolver::set_gaussians(const std::vector<Gaussian<double>>& all)
{
    check_idle();
    book->check_gaussians(all);
    wait(main, "Gaussians");  // their memory may be reallocated
    splats.set(all, store.views().lattice);
    splats.show(main);
    ++changes, stale = true;
}

// The graphs stay valid unless the Gaussians are reallocated.
void GpuSolver::edit_gaussians(const GaussianEdits& edits)
{
    check_idle();
    check_edits(edits, std::size_t(splats.count()), std::size_t(store.count()));
    book->check_placed(edits.placed);
    if (splats.count() == 0) stale = true;
    if (splats.edit(edits, store.views().particles[side], book->config().walls, main)) stale = true;
    splats.show(main);
    ++changes;
}

std::vector<Vec3<double>> GpuSolver::places(const Box3<double>& box) const
{
    check_idle();
    wait(main, "particles");
    return store.places_in(box);
}

void GpuSolver::set_gravity(Vec3<double> gravity)
{
    check_idle();
    SceneState next = *book;
    next.set_gravity(gravity);
    adopt(next);
    wake(every_object);
    edited();
}

void GpuSolver::set_walls(const WallOptions& walls)
{
    check_idle();
    SceneState next = *book;
    next.set_walls(walls);
    adopt(next);
    wake(every_object);
    edited();
}

void GpuSolver::set_contact(const BodyContact& contact)
{
    check_idle();
    SceneState next = *book;
    next.set_contact(contact);
    adopt(next);
    wake(every_object);
    edited();
}

void GpuSolver::set_tools(const Rig& rig, const std::vector<Tool<double>>& tools)
{
    check_idle();
    SceneState next = *book;
    next.set_tools(rig, tools);
    store.set_tools(next);
    adopt(next);
    edited();
}

void GpuSolver::restore(const Snapshot& snapshot)
{
    check_idle();
    const auto* from = &known(snapshot);
    const DeviceState& state = *from->state;
    if (!same_box(store.views().lattice, state.lattice)) store.set_box(state.lattice), stale = true;
    if (store.count() != state.count) store.resize(state.count), side = 0, stale = true;
    if (book != from->rules) {
        store.set_tools(*from->rules), store.set_rules(*from->rules);
        book = from->rules, stale = true;
    }
    store.put_back(state, side, main);
    if (store.recolour(config(), side, main)) stale = true;
    const GaussianView before = splats.view();
    splats.put_back(*from->splats, main);
    if (!same_view(splats.view(), before)) stale = true;
    was_covered = from->was_covered, posed = false;
    set_clock(from->peak, from->drift);
    show();
    ++changes;
}

// `put` writes the particles to side 0 after all earlier work on the stream. If memory ends, the
// state is restored from a copy on the device.
template <class R>
void GpuSolver::replace_by(SceneState&& next, const std::vector<Gaussian<R>>& gaussians,
                           const std::function<void()>& put)
{
    const std::shared_ptr<const Snapshot> before = snapshot();
    try {
        const bool same_rules = book->same_rules(next);
        if (next.count() != store.count()) store.resize(int(next.count())), stale = true;
        side = 0;
        book = std::make_shared<const SceneState>(std::move(next));  // see restore()
        if (!same_rules) store.set_rules(*book), stale = true;
        put();
        const Extent all = store.extent(every_object, at_rest, side, main);
        const Lattice<float> box = store.views().lattice;
        if (!all.empty()) store.enclose({all.lowest(), all.highest()});
        if (!same_box(box, store.views().lattice)) stale = true;
        if (store.recolour(config(), side, main)) stale = true;
        const GaussianView earlier = splats.view();
        splats.set(gaussians, store.views().lattice);
        if (!same_view(splats.view(), earlier)) stale = true;
        store.forget_quiet(main), store.forget_sliding(main);
        was_covered = posed = false;
        set_clock(all.peak, unsorted);
        show();
        ++changes;
    } catch (...) {
        cudaGetLastError();  // or the next launch would report it
        restore(*before);
        throw;
    }
}

// Keeps the graphs where neither the scene nor the size of anything has changed.
void GpuSolver::replace(const SimulationConfig& config, const ClayRows& clay)
{
    check_idle();
    replace_by(book->replaced(config, clay), clay.gaussians, [&] { store.put(clay, main); });
}

void GpuSolver::replace(const SimulationConfig& config, const InitialState& contents)
{
    check_idle();
    std::vector<int> order(contents.particles.size());
    std::iota(order.begin(), order.end(), 0);
    replace_by(book->replaced(config, contents), contents.gaussians, [&] {
        wait(main, "replace");  // the copy of the state
        store.upload(contents.particles, order);
    });
}

void GpuSolver::load(const SavedState& from)
{
    check_idle();
    check_state(from, config());
    const SceneState next(from);
    const Lattice<float> now = store.views().lattice;
    const Lattice<float> box =
        boxed({now.size, now.dx}, from.quiet_low, from.quiet_low + from.quiet_stored);
    const Box3<float> held = stored_region(box);
    for (const Particle<double>& p : from.contents.particles)
        if (!contains(held, cast<float>(p.x)))
            throw std::invalid_argument("the state has clay beyond the nodes that it stores");
    if (!same_box(box, now)) store.set_box(box);
    store.resize(int(from.order.size()));
    store.set_tools(next);
    side = 0;
    store.upload(from.contents.particles, from.order);
    splats.set(from.contents.gaussians, store.views().lattice);
    adopt(next);
    store.recolour(config(), side, main);
    store.set_quiet(quiet_over(from, store.views().lattice));
    store.slide_on(from.sliding, store.clock(main).done);
    was_covered = from.covered;
    set_clock(
        {std::bit_cast<unsigned>(from.speed_squared), std::bit_cast<unsigned>(from.stiffness)},
        from.drift);
    show();
    ++changes, stale = true, posed = false;
}

}  // namespace knead::gpu
