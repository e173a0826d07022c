// Freezing of clay that all hands have left. A thread computes the positions and deformations of
// its splats from a snapshot. The result stays valid while frames continue, because clay far from
// hands does not move.
#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "host/base/parallel.h"
#include "host/paging/local_clay.h"
#include "host/splats/deformed.h"

namespace knead {
namespace {

constexpr std::uint32_t no_slot = ~std::uint32_t(0);

// True if position and deformation are bitwise equal to those at attachment.
bool untouched(const Gaussian<double>& g, Vec3<float> centre)
{
    const Vec3<float> x = cast<float>(g.x);
    const Mat3<double>& F = g.F;
    return x.x == centre.x && x.y == centre.y && x.z == centre.z && F.a.x == 1 && F.b.y == 1 &&
           F.c.z == 1 && F.a.y == 0 && F.a.z == 0 && F.b.x == 0 && F.b.z == 0 && F.c.x == 0 &&
           F.c.y == 0;
}

// The normal n after the deformation F.
Vec3<float> turned_normal(const Mat3<double>& F, Vec3<float> n)
{
    // The cofactors of F: F^-T times the determinant of F.
    const Mat3<double> C{cross(F.b, F.c), cross(F.c, F.a), cross(F.a, F.b)};
    const Vec3<double> m = C * cast<double>(n);
    const double size = length(m);
    return size > 0 ? cast<float>((1 / size) * m) : n;
}

template <class T>
std::vector<T> picked(const std::vector<T>& all, const std::vector<std::uint32_t>& indices)
{
    std::vector<T> some;
    some.reserve(indices.size());
    for (const std::uint32_t i : indices) some.push_back(all[i]);
    return some;
}

}  // namespace

// Guards the data that the thread writes and may reallocate.
const LocalState& LocalClay::checked_state() const
{
    if (freezing()) throw std::logic_error("cubes of clay are being frozen");
    return state_;
}

bool LocalClay::is_freezing(Key cube) const
{
    return freezing() && std::binary_search(freezing_cubes.begin(), freezing_cubes.end(), cube);
}

// Returns the number of cubes that were empty and are frozen at once.
std::size_t LocalClay::begin_freezing(std::vector<Key> cubes, EditableSimulator& solver)
{
    std::vector<int> objects;
    for (const Key key : cubes)
        if (const int object = state_.clay[key]; object >= 0) objects.push_back(object);
    if (objects.empty()) {
        for (const Key key : cubes) state_.clay.erase(key);
        return cubes.size();
    }
    freezing_cubes = std::move(cubes);
    state_.slot_of.resize(carried.cloud().count(), -1);  // entries for splats split or added since
                                                         // the last update
    evicting = std::async(std::launch::async,
                          [this, of = &solver, then = solver.snapshot(), all = carried.shared(),
                           objects = std::move(objects)]() mutable {
                              SomeGaussians some = of->gaussians_of(*then, objects);
                              return compute_frozen(*all, std::move(some), std::move(objects));
                          });
    return 0;
}

// Returns the number of cubes frozen: 0 if the thread is still running and `now` is false.
std::size_t LocalClay::finish_freezing(EditableSimulator& solver, bool now)
{
    using namespace std::chrono_literals;
    if (!freezing()) return 0;
    const bool ready = evicting.wait_for(0s) == std::future_status::ready;
    if (!now && !(take ? take(ready) : ready)) return 0;
    EvictResult made = evicting.get();
    solver.remove_each(made.objects);
    carried.set_state(std::move(made.stay));
    state_.slot_of = std::move(made.slot_of);
    for (const std::uint32_t slot : made.slots) state_.active[slot] = 0;
    for (const Key key : freezing_cubes) state_.clay.erase(key);
    return freezing_cubes.size();
}

// Freezes the splats of `carried_splats` whose Gaussians are in `back`, as deformed by them.
LocalClay::EvictResult LocalClay::compute_frozen(const CarriedSplats& carried_splats,
                                                 SomeGaussians back, std::vector<int> objects)
{
    EvictResult made;
    made.objects = std::move(objects);
    std::vector<char> goes(carried_splats.count(), 0);
    std::vector<std::uint32_t> changed, slots, kept;
    changed.reserve(back.indices.size()), slots.reserve(back.indices.size());
    made.slots.reserve(back.indices.size());
    for (std::size_t k = 0; k < back.indices.size(); ++k) {
        const auto i = std::size_t(back.indices[k]);
        const int slot = state_.slot_of[i];
        const Gaussian<double> g = back.gaussians[k];
        goes[i] = 1;
        if (slot >= 0) made.slots.push_back(std::uint32_t(slot));
        if (slot >= 0 && untouched(g, state_.cloud.centre[std::size_t(slot)])) continue;
        back.gaussians[changed.size()] = g;
        changed.push_back(std::uint32_t(i)), slots.push_back(std::uint32_t(slot));
    }
    back.gaussians.resize(changed.size());
    const std::size_t before = state_.cloud.count();
    store_frozen(deformed(picked(carried_splats.cloud, changed), back.gaussians), std::move(slots),
                 back.gaussians);
    for (std::size_t i = before; i < state_.cloud.count(); ++i)
        made.slots.push_back(std::uint32_t(i));
    kept.reserve(goes.size());
    for (std::size_t i = 0; i < goes.size(); ++i)
        if (!goes[i]) kept.push_back(std::uint32_t(i));
    made.stay = {picked(carried_splats.cloud, kept), picked(carried_splats.extent, kept)};
    made.slot_of = picked(state_.slot_of, kept);
    return made;
}

// Stores the splats in these slots. Splats that were split off or added get new slots, which are
// active until finish_freezing().
void LocalClay::store_frozen(const SplatCloud& now, std::vector<std::uint32_t> slots,
                             const std::vector<Gaussian<double>>& as)
{
    SplatCloud& cloud = state_.cloud;
    const std::size_t before = cloud.count();
    std::size_t all = before;
    for (std::uint32_t& slot : slots)
        if (slot == no_slot) slot = std::uint32_t(all++);
    resize(cloud, all), state_.active.resize(all, 1), state_.normal.resize(all, {0, 0, 0});
    // Few splats change their cube.
    std::vector<std::uint32_t> going, coming;
    Key touched = -1;
    for (std::size_t k = 0; k < slots.size(); ++k) {
        const std::uint32_t i = slots[k];
        const Vec3<double> to = cast<double>(now.centre[k]), from = cast<double>(cloud.centre[i]);
        const Key key = tiling.key_of(from);
        const bool known = i < before;
        if (known && between_walls(from) == between_walls(to) && tiling.key_of(to) == key) {
            if (touched != key) frozen.touch(key);
            touched = key;
            continue;
        }
        coming.push_back(i);
        if (known) going.push_back(i);
    }
    frozen.remove(going, cloud);
    const int count = int(slots.size());
    parallel_for(count, [&](int k) {
        const auto from = std::size_t(k), i = std::size_t(slots[from]);
        set_splat(cloud, i, now, from);
        if (i < before) state_.normal[i] = turned_normal(as[from].F, state_.normal[i]);
    });
    for (const std::uint32_t i : coming) index_splat(i);
}

}  // namespace knead
