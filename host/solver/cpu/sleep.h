// Sleeping on the CPU, by block. The rules are in cuda/mpm/sleep.h.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "cuda/contact/sweep.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/sleep.h"
#include "host/solver/cpu/tools.h"

namespace knead {
inline namespace KNEAD_CPU_LEVEL {

template <class R>
struct Stillness {
    Rest<R> options;
    Lattice<R> lattice;
    // Per block of the lattice; empty without sleeping.
    std::vector<int> quiet;        // consecutive frames at rest
    std::vector<int> activity;     // Activity in this frame
    std::vector<int> free, guard;  // substep from which the clay moves; from which it is tested for
                                   // a push
    std::vector<char> listed;      // particles are binned and processed
    std::vector<char> roused;      // pushed in this substep
    int now = 0;                   // index of the substep in the frame

    Stillness(const Rest<double>& rest, const Lattice<R>& lattice);
    bool any() const { return options.mode != RestMode::none; }
    // holds(): the clay of block b is still in this substep. feels(): it is tested for a push.
    bool holds(int b) const { return any() && free[std::size_t(b)] > now; }
    bool feels(int b) const { return guard[std::size_t(b)] <= now; }
    // Material of a particle as seen by its nodes (stored in `room` if modified), and a velocity
    // added to the particle's in the scatter [m/s].
    const Material<R>& felt(const Particle<R>& q, const std::vector<Material<R>>& materials,
                            Material<R>& room) const
    {
        const Material<R>& m = materials[std::size_t(q.object)];
        return stands(options.mode, q) ? room = as_held(m) : m;
    }
    Vec3<R> rise(const Particle<R>& q, Vec3<R> gravity, R dt) const
    {
        return stands(options.mode, q) ? held_rise(gravity, dt) : Vec3<R>{};
    }
    // Begins a frame. fastest[b]: largest squared speed in block b [m^2/s^2]; `boxes`: around the
    // tools.
    void begin(const std::vector<R>& fastest, const std::vector<Box3<R>>& boxes);
    // Ends a substep: pushed blocks move from the next substep on. Calls visit(block) for each.
    template <class Visit>
    void end(Visit&& visit);

  private:
    template <class Visit>
    void for_each_within(Int3 at, int steps, Visit&& visit) const;
    void spread(Activity from);
    void wake(int b);
};

template <class R>
Stillness<R>::Stillness(const Rest<double>& rest, const Lattice<R>& of)
    : options{rest.mode, R(rest.speed), rest.frames, R(rest.push), R(rest.reach)}, lattice(of)
{
    if (!any()) return;
    const auto blocks = std::size_t(lattice.block_count());
    for (std::vector<int>* each : {&quiet, &activity, &free, &guard}) each->assign(blocks, 0);
    listed.assign(blocks, 1), roused.assign(blocks, 0);
}

// Calls visit(block index) for all blocks within `steps` of `at`, inclusive.
template <class R>
template <class Visit>
void Stillness<R>::for_each_within(Int3 at, int steps, Visit&& visit) const
{
    const Int3 size = lattice.blocks();
    for (int z = std::max(at.z - steps, 0); z <= std::min(at.z + steps, size.z - 1); ++z)
        for (int y = std::max(at.y - steps, 0); y <= std::min(at.y + steps, size.y - 1); ++y)
            for (int x = std::max(at.x - steps, 0); x <= std::min(at.x + steps, size.x - 1); ++x)
                visit(std::size_t(lattice.block_of({4 * x, 4 * y, 4 * z})));
}

template <class R>
void Stillness<R>::spread(Activity from)
{
    for (int b = 0; b < lattice.block_count(); ++b)
        if (activity[std::size_t(b)] == from)
            for_each_within(lattice.block_at(b), 1, [&](std::size_t n) {
                activity[n] = std::max(activity[n], neighbour_of(options, from));
            });
}

template <class R>
void Stillness<R>::begin(const std::vector<R>& fastest, const std::vector<Box3<R>>& boxes)
{
    const R edge = block_edge * lattice.dx;
    for (int b = 0; b < lattice.block_count(); ++b) {
        int& frames = quiet[std::size_t(b)];
        frames = rested(options, frames, fastest[std::size_t(b)]);
        const bool near = std::any_of(boxes.begin(), boxes.end(), [&](const Box3<R>& box) {
            return meets(box, lattice.block_at(b), edge);
        });
        activity[std::size_t(b)] = own_activity(options, frames, near);
    }
    for (Activity from : {moving, awake, knead::guard}) spread(from);
    for (std::size_t b = 0; b < activity.size(); ++b) {
        free[b] = activity[b] >= awake ? 0 : never;
        guard[b] = options.mode == RestMode::sleep && activity[b] >= knead::guard ? 0 : never;
        listed[b] = activity[b] >= support;
    }
    now = 0;
}

template <class R>
void Stillness<R>::wake(int b)
{
    const Int3 at = lattice.block_at(b);
    free[std::size_t(b)] = now + 1;
    for_each_within(at, 1, [&](std::size_t n) { guard[n] = std::min(guard[n], now + 2); });
    for_each_within(at, 2, [&](std::size_t n) { listed[n] = 1; });
}

template <class R>
template <class Visit>
void Stillness<R>::end(Visit&& visit)
{
    for (int b = 0; b < int(roused.size()); ++b) {
        if (!roused[std::size_t(b)]) continue;
        roused[std::size_t(b)] = 0;
        if (options.mode != RestMode::sleep) continue;
        wake(b), visit(b);
    }
    ++now;
}

// Per active tool, the bounding box of its primitives over a frame, enlarged by `reach` [m].
template <class R>
std::vector<Box3<R>> boxes_around(const PosedTools<R>& posed, const Motion& motion, R reach)
{
    const auto at = [&motion](double share) { return joints_at<R>(motion, share); };
    std::vector<Box3<R>> boxes(posed.tools.size(), empty_box<R>());
    for (const Primitive& p : posed.primitives) {
        if (!posed.tools[std::size_t(p.tool)].active) continue;
        R travel = 0;
        Sphere<R> s[3];
        for (int k = 0; k < 3; ++k)
            s[k] = mid_frame(posed.bindings[std::size_t(p.sphere[k])], {}, at(0), at(0.5), at(1),
                             travel);
        const Shape<R> middle = shape(p.count, s[0], s[1], s[2]);
        const R grown = travel + reach;
        if (!std::isfinite(dot(middle.low, middle.high) + grown)) continue;
        grow(boxes[std::size_t(p.tool)], expanded({middle.low, middle.high}, grown));
    }
    return boxes;
}

}  // namespace KNEAD_CPU_LEVEL
}  // namespace knead
