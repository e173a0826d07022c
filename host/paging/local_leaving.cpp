// Clay that all hands have left: its splats stand again, where they are. What a thread of its own
// finds out from a snapshot holds for as long as hands stay away, for clay that is far from hands
// is held still.
#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "host/base/parallel.h"
#include "host/paging/local_clay.h"
#include "host/splats/deformed.h"

namespace knead {
namespace {

constexpr std::uint32_t no_slot = ~std::uint32_t(0);

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

template <class T>
std::vector<T> picked(const std::vector<T>& all, const std::vector<std::uint32_t>& indices)
{
    std::vector<T> some;
    some.reserve(indices.size());
    for (const std::uint32_t i : indices) some.push_back(all[i]);
    return some;
}

}  // namespace

// What the thread writes and may move in memory.
const LocalState& LocalClay::settled() const
{
    if (leaving()) throw std::logic_error("clay is on its way back");
    return state_;
}

bool LocalClay::leaves(Key cube) const
{
    return leaving() && std::binary_search(on_way_back.begin(), on_way_back.end(), cube);
}

// Cubes that are back at once.
std::size_t LocalClay::begin_leaving(std::vector<Key> cubes, Solver& solver)
{
    std::vector<int> objects;
    for (const Key key : cubes)
        if (const int object = state_.clay[key]; object >= 0) objects.push_back(object);
    if (objects.empty()) {
        for (const Key key : cubes) state_.clay.erase(key);
        return cubes.size();
    }
    on_way_back = std::move(cubes);
    state_.slot_of.resize(moving.cloud().count(), -1);  // some were split
    evicting = std::async(std::launch::async,
                          [this, of = &solver, then = solver.snapshot(), all = moving.shared(),
                           objects = std::move(objects)]() mutable {
                              SomeGaussians some = of->gaussians_of(*then, objects);
                              return settle(*all, std::move(some), std::move(objects));
                          });
    return 0;
}

// Nothing, where it is under way and need not be done now. Cubes.
std::size_t LocalClay::end_leaving(Solver& solver, bool now)
{
    using namespace std::chrono_literals;
    if (!leaving() || (!now && evicting.wait_for(0s) != std::future_status::ready)) return 0;
    EvictResult made = evicting.get();
    solver.remove_each(made.objects);
    moving.set_state(std::move(made.stay));
    state_.slot_of = std::move(made.slot_of);
    for (const std::uint32_t slot : made.slots) state_.active[slot] = 0;
    for (const Key key : on_way_back) state_.clay.erase(key);
    return on_way_back.size();
}

// Of these splats that moved, those that these Gaussians carry stand from now on, as they are.
LocalClay::EvictResult LocalClay::settle(const CarriedSplats& carried, SomeGaussians back,
                                         std::vector<int> objects)
{
    EvictResult made;
    made.objects = std::move(objects);
    std::vector<char> goes(carried.count(), 0);
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
    put_at(deformed(picked(carried.cloud, changed), back.gaussians), std::move(slots),
           back.gaussians);
    for (std::size_t i = before; i < state_.cloud.count(); ++i)
        made.slots.push_back(std::uint32_t(i));
    kept.reserve(goes.size());
    for (std::size_t i = 0; i < goes.size(); ++i)
        if (!goes[i]) kept.push_back(std::uint32_t(i));
    made.stay = {picked(carried.cloud, kept), picked(carried.extent, kept)};
    made.slot_of = picked(state_.slot_of, kept);
    return made;
}

// Splats are where they are now, in these slots; one that was split off or added, in a new one. New
// ones are away like all others, until clay is.
void LocalClay::put_at(const SplatCloud& now, std::vector<std::uint32_t> slots,
                       const std::vector<Gaussian<double>>& as)
{
    SplatCloud& cloud = state_.cloud;
    const std::size_t before = cloud.count();
    std::size_t all = before;
    for (std::uint32_t& slot : slots)
        if (slot == no_slot) slot = std::uint32_t(all++);
    resize(cloud, all), state_.active.resize(all, 1), state_.normal.resize(all, {0, 0, 0});
    // Few come to another cube.
    std::vector<std::uint32_t> going, coming;
    Key touched = -1;
    for (std::size_t k = 0; k < slots.size(); ++k) {
        const std::uint32_t i = slots[k];
        const Vec3<double> to = cast<double>(now.centre[k]), from = cast<double>(cloud.centre[i]);
        const Key key = tiling.key_of(from);
        const bool known = i < before;
        if (known && between_walls(from) == between_walls(to) && tiling.key_of(to) == key) {
            if (touched != key) standing.touch(key);
            touched = key;
            continue;
        }
        coming.push_back(i);
        if (known) going.push_back(i);
    }
    standing.remove(going, cloud);
    const int count = int(slots.size());
    parallel_for(count, [&](int k) {
        const auto from = std::size_t(k), i = std::size_t(slots[from]);
        set_splat(cloud, i, now, from);
        if (i < before) state_.normal[i] = turned_normal(as[from].F, state_.normal[i]);
    });
    for (const std::uint32_t i : coming) put(i);
}

}  // namespace knead
