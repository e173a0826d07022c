#include "host/paging/local_clay.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "cuda/contact/skinning.h"
#include "host/base/parallel.h"
#include "host/paging/local_surface.h"
#include "host/solver/edits.h"
#include "host/splats/deformed.h"

namespace knead {
namespace {

constexpr int cube_cells = 2 * block_edge;
// Interval of freezing [frames]; it is not urgent.
constexpr int frames_apart = 32;
// [cells] Margin of clay that supports the moving clay; additional distance of all hands beyond
// which clay is frozen.
constexpr double support_cells = block_edge, slack_cells = 2 * block_edge;

}  // namespace

LocalClay::LocalClay(const Scene& scene, int object, SplatCloud of, SplatUpkeep& with)
    : rig(scene.setup.rig),
      walls(scene.setup.walls),
      ground(object),
      material(scene.setup.materials.at(std::size_t(object))),
      depth(scene.objects.at(std::size_t(object)).splats.depth),
      dx(scene.setup.lattice.dx),
      spacing(std::cbrt(material.volume)),
      reach(scene.setup.rest.reach + support_cells * dx),
      per_cell(scene.objects[std::size_t(object)].per_cell),
      seed(scene.seed),
      carried(with),
      tiling{cube_cells * dx},
      frozen(tiling, dx)
{
    state_.cloud = std::move(of);
    state_.active.assign(state_.cloud.count(), 0);
    state_.normal.assign(state_.cloud.count(), {0, 0, 0});
    state_.slot_of.assign(with.cloud().count(), -1);
    state_.objects = int(scene.setup.materials.size());
    if (carried.cloud().count() == 0) carried.change().cloud.degree = state_.cloud.degree;
    if (carried.cloud().degree != state_.cloud.degree)
        throw std::invalid_argument(
            "local clay: moving and frozen splats have harmonics of different degree");
    carried.raise_capacity(state_.cloud.count());
    carried.refill_below(int(scene.setup.materials.size()));
    for (std::size_t i = 0; i < state_.cloud.count(); ++i) index_splat(std::uint32_t(i));
}

bool LocalClay::between_walls(Vec3<double> x) const { return contains({walls.min, walls.max}, x); }

// Only splats between the walls can be activated.
void LocalClay::index_splat(std::uint32_t i)
{
    const Vec3<double> x = cast<double>(state_.cloud.centre[i]);
    if (between_walls(x)) frozen.put(i, x);
}

Boxes LocalClay::boxes_of(const Motion& motion) const
{
    Boxes boxes;
    std::map<int, std::size_t> of;  // by tool
    for (const Primitive& p : rig.primitives) {
        const auto tool = std::size_t(p.tool);
        if (motion.to.empty() || (tool < motion.active.size() && !motion.active[tool])) continue;
        if (!of.count(p.tool)) {
            of[p.tool] = boxes.size();
            boxes.push_back(empty_box<double>());
        }
        Box3<double>& box = boxes[of[p.tool]];
        for (int k = 0; k < p.count; ++k) {
            const Binding<double> b = stretched(cast<double>(rig.spheres[std::size_t(p.sphere[k])]),
                                                cast<double>(motion.stretch_of(tool)));
            const auto from = centre(b, [&](int j) { return motion.from[std::size_t(j)]; });
            const auto to = centre(b, [&](int j) { return motion.to[std::size_t(j)]; });
            Box3<double> path{from, from};  // in this frame and the next
            grow(path, to), grow(path, 2.0 * to - from);
            grow(box, expanded(path, b.radius));
        }
    }
    return boxes;
}

// Cubes of the domain, in ascending order.
std::vector<LocalClay::Key> LocalClay::cubes_near(const Boxes& boxes, double beyond) const
{
    std::vector<Key> keys;
    const Int3 first = tiling.of(walls.min), last = tiling.of(walls.max);
    for (const Box3<double>& box : boxes) {
        const Box3<double> near = expanded(box, beyond);
        const Int3 a = tiling.of(near.low), b = tiling.of(near.high);
        for (int z = std::max(a.z, first.z); z <= std::min(b.z, last.z); ++z)
            for (int y = std::max(a.y, first.y); y <= std::min(b.y, last.y); ++y)
                for (int x = std::max(a.x, first.x); x <= std::min(b.x, last.x); ++x)
                    keys.push_back(Cubes::key({x, y, z}));
    }
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    return keys;
}

// Cubes whose splats define the surface in or above these, in ascending order.
std::vector<LocalClay::Key> LocalClay::around(const std::vector<Key>& cubes) const
{
    const int more = int(std::ceil((depth + 2 * dx) / tiling.edge));
    std::vector<Key> keys;
    for (const Key key : cubes)
        for (int z = -more; z <= more; ++z)
            for (int y = -more; y <= more; ++y)
                for (int x = -more; x <= more; ++x)
                    keys.push_back(Cubes::key(Cubes::at(key) + Int3{x, y, z}));
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    return keys;
}

void LocalClay::activate(const std::vector<Key>& wanted, const Boxes& boxes,
                         EditableSimulator& solver)
{
    const std::vector<Key> near = around(wanted);
    frozen.fit_patches(near, state_.cloud, state_.normal, boxes);
    const LocalSurface surface(frozen.surface(near), depth, 2 * dx);
    // Clay may have moved in from neighbouring cubes: no particle is seeded near an existing one.
    Int3 low = Cubes::at(wanted.front()), high = low;
    for (const Key key : wanted) {
        const Int3 c = Cubes::at(key);
        low = {std::min(low.x, c.x), std::min(low.y, c.y), std::min(low.z, c.z)};
        high = {std::max(high.x, c.x), std::max(high.y, c.y), std::max(high.z, c.z)};
    }
    const auto corner = [this](Int3 c) {
        return tiling.edge * Vec3<double>{double(c.x), double(c.y), double(c.z)};
    };
    const std::vector<Vec3<double>> particles =
        solver.places(expanded({corner(low), corner(high + Int3{1, 1, 1})}, spacing));
    const Cells there(particles, 2 * spacing);
    add_clay(wanted, all_seeds(wanted, surface, there), solver);
    attach_splats(solver);
}

// Attaches the frozen splats of all active cubes to their clay.
void LocalClay::attach_splats(EditableSimulator& solver)
{
    struct Part {
        const std::vector<std::uint32_t>& slots;
        int object;
        std::size_t first = 0, count = 0;  // of the frozen ones
    };
    std::vector<Part> parts;
    for (const auto& [key, object] : state_.clay)
        if (object >= 0) parts.push_back({frozen.in(key), object});
    const int count = int(parts.size());
    parallel_for(count, LoopOptions{.chunk = 1}, [&](int k) {
        for (const std::uint32_t i : parts[std::size_t(k)].slots)
            parts[std::size_t(k)].count += !state_.active[i];
    });
    std::size_t all = 0;
    for (Part& part : parts) part.first = all, all += part.count;
    if (all == 0) return;
    std::vector<std::uint32_t> slots(all);
    GaussianEdits edits;
    edits.placed.resize(all);
    parallel_for(count, LoopOptions{.chunk = 1}, [&](int k) {
        const Part& part = parts[std::size_t(k)];
        std::size_t at = part.first;
        for (const std::uint32_t i : part.slots) {
            if (state_.active[i]) continue;
            slots[at] = i, state_.active[i] = 1;
            edits.placed[at++] = {state_.cloud.centre[i], part.object};
        }
    });
    CarriedSplats& carried_splats = carried.change(all);
    state_.slot_of.resize(carried_splats.count(), -1);  // entries for splats split or added since
                                                        // the last update
    state_.slot_of.insert(state_.slot_of.end(), slots.begin(), slots.end());
    append(carried_splats, state_.cloud, slots);
    solver.edit_gaussians(edits);
}

void LocalClay::set_material(int object, const Material<double>& to, EditableSimulator& solver)
{
    if (object != ground) return;
    material = to;
    for (const auto& [key, clay] : state_.clay)
        if (clay >= 0) solver.set_material(clay, to);
}

// Cubes that all hands have left.
std::vector<LocalClay::Key> LocalClay::cubes_to_freeze(const Boxes& boxes) const
{
    std::vector<Key> left;
    const std::vector<Key> held = cubes_near(boxes, reach + slack_cells * dx);
    for (const auto& [key, object] : state_.clay)
        if (!std::binary_search(held.begin(), held.end(), key)) left.push_back(key);
    return left;
}

// Cubes to activate: those near hands that are inactive or being frozen. If there are any, the
// distance is enlarged, so that the next frames activate none.
std::vector<LocalClay::Key> LocalClay::cubes_to_activate(const Boxes& boxes) const
{
    const auto missing = [&](double beyond) {
        std::vector<Key> keys;
        for (const Key key : cubes_near(boxes, beyond))
            if (!state_.clay.count(key) || is_freezing(key)) keys.push_back(key);
        return keys;
    };
    if (missing(reach).empty()) return {};
    return missing(reach + slack_cells / 2 * dx);
}

LocalReport LocalClay::after(int frame, const Motion& motion, EditableSimulator& solver)
{
    std::size_t back = 0;
    if (frame % frames_apart == 0) {
        back = begin_freezing(cubes_to_freeze(boxes_of(motion)), solver);
        back += finish_freezing(solver, true);
    }
    LocalReport report = follow(motion, solver);
    report.frozen += back;
    return report;
}

LocalReport LocalClay::follow(const Motion& motion, EditableSimulator& solver)
{
    LocalReport report;
    report.frozen = finish_freezing(solver, false);
    const Boxes boxes = boxes_of(motion);
    const std::vector<Key> wanted = cubes_to_activate(boxes);
    if (!wanted.empty()) {
        report.frozen += finish_freezing(solver, true);
        activate(wanted, boxes, solver);
    }
    report.activated = wanted.size();
    for (const auto& [key, object] : state_.clay) report.cubes += object >= 0;
    report.splats = carried.cloud().count();
    return report;
}

Motion LocalClay::motion_at_centre() const
{
    const Vec3<double> middle = 0.5 * (walls.min + walls.max);
    Motion motion;
    double least = 1e300;
    Joint<double> there{{1, 0, 0, 0}, middle};
    for (const Vec3<float>& centre : state_.cloud.centre) {
        const Vec3<double> x = cast<double>(centre), off = x - middle;
        if (between_walls(x) && dot(off, off) < least) least = dot(off, off), there.p = x;
    }
    if (least == 1e300) return motion;
    std::size_t joints = 0;
    for (const Binding<float>& b : rig.spheres)
        for (const int joint : b.joint) joints = std::max(joints, std::size_t(joint + 1));
    motion.from.assign(joints, there), motion.to.assign(joints, there);
    return motion;
}

void LocalClay::begin_freezing(int frame, const Motion& motion, EditableSimulator& solver)
{
    if (frame % frames_apart == 0 && !freezing())
        begin_freezing(cubes_to_freeze(boxes_of(motion)), solver);
}

void LocalClay::set_state(LocalState state)
{
    check(state);
    if (freezing()) evicting.get();
    if (state.cloud.degree != state_.cloud.degree)
        throw std::invalid_argument("local clay: the state has harmonics of another degree");
    state_ = std::move(state);
    frozen.clear();
    for (std::size_t i = 0; i < state_.cloud.count(); ++i) index_splat(std::uint32_t(i));
}

void LocalClay::write_all(SplatCloud& all) const
{
    checked_state();
    const SplatCloud& move = carried.cloud();
    std::vector<std::uint32_t> frozen_slots;
    for (std::size_t i = 0; i < state_.cloud.count(); ++i)
        if (!state_.active[i]) frozen_slots.push_back(std::uint32_t(i));
    const std::size_t first = move.count();
    all.degree = state_.cloud.degree;
    all.antialiased = move.antialiased || state_.cloud.antialiased;
    if (const std::size_t wanted = first + frozen_slots.size(); all.centre.capacity() < wanted)
        reserve(all, wanted + wanted / 4);  // room for splitting
    resize(all, first + frozen_slots.size());
    const int count = int(all.count());
    parallel_for(count, [&](int k) {
        const auto i = std::size_t(k);
        if (i < first)
            set_splat(all, i, move, i);
        else
            set_splat(all, i, state_.cloud, frozen_slots[i - first]);
    });
}

}  // namespace knead
