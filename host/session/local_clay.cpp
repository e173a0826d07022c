#include "host/session/local_clay.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "cuda/contact/skinning.h"
#include "host/session/local_surface.h"
#include "host/splats/deformed.h"

namespace knead {
namespace {

constexpr int cube_cells = 2 * block_edge;
// Beyond what moves, in cells: clay that holds it, and how much farther a hand must be from clay
// before that is given back.
constexpr double support_cells = block_edge, slack_cells = 2 * block_edge;

template <class T>
void keep_only(std::vector<T>& all, const std::vector<std::uint32_t>& kept)
{
    for (std::size_t i = 0; i < kept.size(); ++i) all[i] = all[kept[i]];
    all.resize(kept.size());
}

void append_cloud(SplatCloud& to, const SplatCloud& from, std::size_t i)
{
    const auto count = std::size_t(harmonics(from.degree));
    to.centre.push_back(from.centre[i]), to.rotation.push_back(from.rotation[i]);
    to.scale.push_back(from.scale[i]), to.opacity.push_back(from.opacity[i]);
    to.sh.insert(to.sh.end(), from.sh.begin() + std::ptrdiff_t(i * count),
                 from.sh.begin() + std::ptrdiff_t((i + 1) * count));
}

void set_splat(SplatCloud& to, std::size_t at, const SplatCloud& from, std::size_t i)
{
    const auto count = std::size_t(harmonics(from.degree));
    to.centre[at] = from.centre[i], to.rotation[at] = from.rotation[i];
    to.scale[at] = from.scale[i], to.opacity[at] = from.opacity[i];
    for (std::size_t k = 0; k < count; ++k) to.sh[at * count + k] = from.sh[i * count + k];
}

// Whether it is, to the bit, where and as it was when it was attached.
bool untouched(const Gaussian<double>& g, Vec3<float> centre)
{
    const Vec3<float> x = cast<float>(g.x);
    const Mat3<double>& F = g.F;
    return x.x == centre.x && x.y == centre.y && x.z == centre.z && F.a.x == 1 && F.b.y == 1 &&
           F.c.z == 1 && F.a.y == 0 && F.a.z == 0 && F.b.x == 0 && F.b.z == 0 && F.c.x == 0 &&
           F.c.y == 0;
}

// A normal of what was deformed by F.
Vec3<float> turned_normal(const Mat3<double>& F, Vec3<float> n)
{
    // The cofactors of F, F^-T times its determinant.
    const Mat3<double> C{cross(F.b, F.c), cross(F.c, F.a), cross(F.a, F.b)};
    const Vec3<double> m = C * cast<double>(n);
    const double size = length(m);
    return size > 0 ? cast<float>((1 / size) * m) : n;
}

}  // namespace

LocalClay::LocalClay(const Scene& scene, int object, SplatCloud of, SplatUpkeep& with)
    : rig(scene.setup.rig),
      walls(scene.setup.walls),
      ground(object),
      material(scene.setup.materials.at(std::size_t(object))),
      depth(scene.objects.at(std::size_t(object)).splats.depth),
      dx(scene.setup.lattice.dx),
      spacing(std::cbrt(material.volume)),
      edge(cube_cells * dx),
      reach(scene.setup.rest.reach + support_cells * dx),
      per_cell(scene.objects[std::size_t(object)].per_cell),
      seed(scene.seed),
      moving(with)
{
    state_.cloud = std::move(of);
    state_.away.assign(state_.cloud.count(), 0),
        state_.normal.assign(state_.cloud.count(), {0, 0, 0});
    state_.home.assign(with.cloud().count(), -1);
    state_.objects = int(scene.setup.materials.size());
    if (moving.cloud().count() == 0) moving.change().cloud.degree = state_.cloud.degree;
    if (moving.cloud().degree != state_.cloud.degree)
        throw std::invalid_argument("splats that move and splats that stand, of other harmonics");
    moving.expect(state_.cloud.count());
    moving.refill_below(int(scene.setup.materials.size()));
    for (std::size_t i = 0; i < state_.cloud.count(); ++i) put(std::uint32_t(i));
}

Int3 LocalClay::cube_of(Vec3<double> x) const
{
    const auto along = [this](double place) {
        return int(std::floor(clamp(place / edge, -1048576.0, 1048575.0)));
    };
    return {along(x.x), along(x.y), along(x.z)};
}

LocalClay::Key LocalClay::key_of(Int3 c)
{
    const auto part = [](int n) { return Key(n + 1048576); };
    return part(c.z) << 42 | part(c.y) << 21 | part(c.x);
}

Int3 LocalClay::cube_at(Key key)
{
    const auto part = [key](int shift) { return int(key >> shift & 0x1fffff) - 1048576; };
    return {part(0), part(21), part(42)};
}

bool LocalClay::between_walls(Vec3<double> x) const
{
    const auto in = [](double a, double low, double high) { return a >= low && a <= high; };
    return in(x.x, walls.min.x, walls.max.x) && in(x.y, walls.min.y, walls.max.y) &&
           in(x.z, walls.min.z, walls.max.z);
}

// What lies between the walls may become clay.
void LocalClay::put(std::uint32_t i)
{
    const Vec3<double> x = cast<double>(state_.cloud.centre[i]);
    if (between_walls(x)) at[key_of(cube_of(x))].push_back(i);
}

LocalClay::Boxes LocalClay::boxes_of(const Motion& motion) const
{
    Boxes boxes;
    std::map<int, std::size_t> of;  // by tool
    for (const Primitive& p : rig.primitives) {
        const auto tool = std::size_t(p.tool);
        if (motion.to.empty() || (tool < motion.active.size() && !motion.active[tool])) continue;
        if (!of.count(p.tool)) {
            of[p.tool] = boxes.size();
            boxes.push_back({{1e30, 1e30, 1e30}, {-1e30, -1e30, -1e30}});
        }
        auto& [low, high] = boxes[of[p.tool]];
        for (int k = 0; k < p.count; ++k) {
            const Binding<double> b = cast<double>(rig.spheres[std::size_t(p.sphere[k])]);
            const auto from = centre(b, [&](int j) { return motion.from[std::size_t(j)]; });
            const auto to = centre(b, [&](int j) { return motion.to[std::size_t(j)]; });
            const auto add = [&](double a, double c, double next, double& l, double& h) {
                l = min(l, min(a, min(c, next)) - b.radius);
                h = max(h, max(a, max(c, next)) + b.radius);
            };
            add(from.x, to.x, 2 * to.x - from.x, low.x, high.x);
            add(from.y, to.y, 2 * to.y - from.y, low.y, high.y);
            add(from.z, to.z, 2 * to.z - from.z, low.z, high.z);
        }
    }
    return boxes;
}

// Of the domain, in rising order.
std::vector<LocalClay::Key> LocalClay::cubes_near(const Boxes& boxes, double beyond) const
{
    std::vector<Key> keys;
    const Vec3<double> more{beyond, beyond, beyond};
    const Int3 first = cube_of(walls.min), last = cube_of(walls.max);
    for (const auto& [low, high] : boxes) {
        const Int3 a = cube_of(low - more), b = cube_of(high + more);
        for (int z = std::max(a.z, first.z); z <= std::min(b.z, last.z); ++z)
            for (int y = std::max(a.y, first.y); y <= std::min(b.y, last.y); ++y)
                for (int x = std::max(a.x, first.x); x <= std::min(b.x, last.x); ++x)
                    keys.push_back(key_of({x, y, z}));
    }
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    return keys;
}

// What tells of the surface in or over these cubes, in rising order.
LocalClay::Standing LocalClay::standing_near(const std::vector<Key>& cubes)
{
    const int more = int(std::ceil((depth + 2 * dx) / edge));
    std::vector<Key> keys;
    for (const Key key : cubes)
        for (int z = -more; z <= more; ++z)
            for (int y = -more; y <= more; ++y)
                for (int x = -more; x <= more; ++x)
                    keys.push_back(key_of(cube_at(key) + Int3{x, y, z}));
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    Standing near;
    for (const Key key : keys) {
        const auto found = at.find(key);
        if (found == at.end()) continue;
        std::vector<std::uint32_t>& of_cube = found->second;
        if (!std::is_sorted(of_cube.begin(), of_cube.end()))  // some were given back
            std::sort(of_cube.begin(), of_cube.end());
        near.cubes.push_back(near.slots.size());
        near.slots.insert(near.slots.end(), of_cube.begin(), of_cube.end());
    }
    return near;
}

void LocalClay::take(const std::vector<Key>& cubes, const Boxes& boxes, Solver& solver)
{
    std::vector<Gaussian<double>> gaussians = solver.gaussians();
    CarriedSplats& carried = moving.change();
    state_.home.resize(carried.count(), -1);  // some were split
    Standing near = standing_near(cubes);
    find_normals(boxes, near);
    std::vector<Vec3<double>> x, n, particles;
    for (const std::uint32_t i : near.slots)
        x.push_back(cast<double>(state_.cloud.centre[i])),
            n.push_back(cast<double>(state_.normal[i]));
    near.cubes.push_back(x.size());
    for (std::size_t i = 0; i < gaussians.size(); ++i) {
        if (state_.home[i] < 0) continue;
        x.push_back(gaussians[i].x);
        n.push_back(cast<double>(
            turned_normal(gaussians[i].F, state_.normal[std::size_t(state_.home[i])])));
    }
    for (const Particle<double>& p : solver.particles()) particles.push_back(p.x);
    const LocalSurface surface(x, n, depth, 2 * dx, near.cubes);
    const Cells there(particles, 2 * spacing);
    add_clay(cubes, all_seeds(cubes, surface, there), solver);
    // All that stands in clay goes with it from here on.
    for (const auto& [key, object] : state_.clay) {
        const auto standing = at.find(key);
        if (object < 0 || standing == at.end()) continue;
        std::sort(standing->second.begin(), standing->second.end());
        for (const std::uint32_t i : standing->second) {
            const Vec3<float> s = state_.cloud.scale[i];
            append(carried, state_.cloud.centre[i], {state_.cloud.rotation[i], s},
                   state_.cloud.opacity[i],
                   state_.cloud.sh.data() + i * std::size_t(harmonics(state_.cloud.degree)),
                   max(s.x, max(s.y, s.z)));
            gaussians.push_back(gaussian_at(cast<double>(state_.cloud.centre[i]), object));
            state_.home.push_back(int(i)), state_.away[i] = 1;
        }
        at.erase(standing);
    }
    solver.set_gaussians(gaussians);
}

void LocalClay::give_back(const std::vector<Key>& cubes, Solver& solver)
{
    std::vector<char> gone(solver.rules().materials.size(), 0);
    for (const Key key : cubes)
        if (state_.clay[key] >= 0) gone[std::size_t(state_.clay[key])] = 1;
    const std::vector<Gaussian<double>> gaussians = solver.gaussians();
    CarriedSplats& carried = moving.change();
    state_.home.resize(carried.count(), -1);
    std::vector<std::uint32_t> back, kept;
    std::vector<Gaussian<double>> as;
    for (std::size_t i = 0; i < gaussians.size(); ++i) {
        const bool leaves = gone[std::size_t(gaussians[i].object)];
        (leaves ? back : kept).push_back(std::uint32_t(i));
        if (leaves) as.push_back(gaussians[i]);
    }
    const SplatCloud now = deformed(picked(carried.cloud, back), as);
    for (std::size_t k = 0; k < back.size(); ++k) {
        const int slot = state_.home[back[k]];
        auto i = std::size_t(slot);
        if (slot < 0) {  // split off, or added
            i = state_.cloud.count();
            append_cloud(state_.cloud, now, k);
            state_.away.push_back(0), state_.normal.push_back({0, 0, 0});
        } else {
            state_.away[i] = 0;
            if (!untouched(as[k], state_.cloud.centre[i])) {
                set_splat(state_.cloud, i, now, k);
                state_.normal[i] = turned_normal(as[k].F, state_.normal[i]);
            }
        }
        put(std::uint32_t(i));
    }
    carried.cloud = picked(carried.cloud, kept);
    keep_only(carried.extent, kept), keep_only(state_.home, kept);
    std::vector<int> objects;
    for (const Key key : cubes) {
        if (state_.clay[key] >= 0) objects.push_back(state_.clay[key]);
        state_.clay.erase(key);
    }
    if (!objects.empty()) solver.remove_each(objects);
}

void LocalClay::set_material(int object, const Material<double>& to, Solver& solver)
{
    if (object != ground) return;
    material = to;
    for (const auto& [key, clay] : state_.clay)
        if (clay >= 0) solver.set_material(clay, to);
}

LocalReport LocalClay::after(const Motion& motion, Solver& solver)
{
    LocalReport report;
    const Boxes boxes = boxes_of(motion);
    const std::vector<Key> held = cubes_near(boxes, reach + slack_cells * dx);
    std::vector<Key> left, wanted;
    for (const auto& [key, object] : state_.clay)
        if (!std::binary_search(held.begin(), held.end(), key)) left.push_back(key);
    if (!left.empty()) give_back(left, solver);
    for (const Key key : cubes_near(boxes, reach))
        if (!state_.clay.count(key)) wanted.push_back(key);
    if (!wanted.empty()) take(wanted, boxes, solver);
    report.taken = wanted.size(), report.given_back = left.size();
    for (const auto& [key, object] : state_.clay) report.cubes += object >= 0;
    report.splats = moving.cloud().count();
    return report;
}

void LocalClay::set_state(LocalState state)
{
    check(state);
    if (state.cloud.degree != state_.cloud.degree)
        throw std::invalid_argument("splats that stand, of other harmonics");
    state_ = std::move(state);
    at.clear();
    for (std::size_t i = 0; i < state_.cloud.count(); ++i)
        if (!state_.away[i]) put(std::uint32_t(i));
}

SplatCloud LocalClay::shown() const
{
    SplatCloud all = moving.cloud();
    all.antialiased = all.antialiased || state_.cloud.antialiased;
    std::vector<std::uint32_t> standing;
    for (std::size_t i = 0; i < state_.cloud.count(); ++i)
        if (!state_.away[i]) standing.push_back(std::uint32_t(i));
    const std::size_t first = all.count(), count = first + standing.size();
    all.centre.resize(count), all.rotation.resize(count), all.scale.resize(count);
    all.opacity.resize(count), all.sh.resize(count * std::size_t(harmonics(all.degree)));
    const int more = int(standing.size());
#pragma omp parallel for schedule(static)
    for (int k = 0; k < more; ++k)
        set_splat(all, first + std::size_t(k), state_.cloud, standing[std::size_t(k)]);
    return all;
}

}  // namespace knead
