#include "host/solver/reference.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string>

#include "cuda/contact/skinning.h"
#include "cuda/mpm/body_contact.h"
#include "cuda/mpm/g2p.h"
#include "cuda/mpm/grid.h"
#include "cuda/mpm/mean_pressure.h"
#include "cuda/mpm/p2g.h"
#include "cuda/mpm/plasticity.h"
#include "cuda/mpm/project.h"
#include "host/base/parallel.h"
#include "host/solver/edits.h"
#include "host/solver/pieces.h"
#include "host/solver/substep.h"

namespace knead {

Reference::Reference(const Setup& given)
    : scene(given),
      q(given.particles),
      splats(given.gaussians),
      depth(q.size()),
      owner(tools_of_spheres(given.rig)),
      spheres(given.rig.spheres.size()),
      shapes(given.rig.primitives.size()),
      walls(walls_on<double>(given.lattice, given.walls)),
      bodies(bodies_of(given)),
      blades(given.cuts),
      threads(given.threads > 0 ? given.threads : loop_threads())
{
    if (shapes.size() > max_primitives)
        throw std::invalid_argument("at most " + std::to_string(max_primitives) + " primitives");
    check_materials(scene.materials);
    if (!given.gaussians.empty()) SceneState{given};
    for (const Binding<float>& b : scene.rig.spheres) bindings.push_back(cast<double>(b));
    for (const Tool<double>& t : scene.tools) blades = blades || t.blade;
    for (const Particle<double>& p : q) blades = blades || p.label() != 0;
    scene.cuts = blades, bodies = bodies_of(scene);
    fields.resize(bodies.colours > 0 ? std::size_t(bodies.fields()) : blades ? 3 : 1);
    sliding.resize(fields.size());
    for (auto& field : fields) field.resize(std::size_t(scene.lattice.node_count()));
    for (auto& field : sliding)
        field.resize(std::size_t(sliding_places(given.lattice.size, given.walls)));
}

// A frame: substeps as long as stability allows, each dt chosen one substep ahead.  (22)
FrameStats Reference::advance(const Motion& motion, double duration)
{
    stats = {};
    Lag lag{};
    for (std::size_t t = 0; t < scene.tools.size(); ++t) set_tool(scene.tools[t], motion, t);
    if (bodies.shared() && bodies.colour_by(body_graph(q, scene.lattice, bodies.body)))
        for (auto& field : sliding) std::fill(field.begin(), field.end(), Sliding<double>{});
    stats.welded_bodies = bodies.welded;
    const StepLimits limits = step_limits(scene);
    const double tool = tool_step(scene, motion, duration);
    const int bound = take_substep_bound();
    Step step = step_at(limits, 0, extremes(), tool, duration);
    while (step.dt > 0) {
        const Step next = step_after(step, limits, extremes(), tool, duration);
        substep(motion, step.start / duration, next.start / duration, step.dt);
        count(step, stats);
        lag.add(step.dt);
        const bool last = !(next.dt > 0) || ends_here(next.start, duration, stats, bound);
        if (lag.due() || last)
            deform(lag, last || clears_each_time(blades, duration, tool)), lag = {};
        if (last) break;
        step = next;
    }
    stats.active_blocks = active_blocks();
    stats.fastest = extremes().speed;
    stats[Count::moved] = long(q.size()) * stats.substeps;
    end_cuts();
    return stats;
}

void Reference::substep(const Motion& motion, double from, double to, double dt)
{
    pose(motion, from, to, dt);
    p2g(dt);
    separate(dt);
    grid(dt);
    share_pressure();
    g2p(dt);
    project(dt);
    plasticity(dt);
    repair();
}

// Poses medial spheres by skinning (20), (21), and derives the shapes (13), (14).
void Reference::pose(const Motion& motion, double from, double to, double dt)
{
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        const Tool<double>& tool = scene.tools[std::size_t(owner[i])];
        spheres[i] = posed(stretched(bindings[i], tool.stretch), joints_at<double>(motion, from),
                           joints_at<double>(motion, to), dt, tool.size);
    }
    active = {};
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        const Primitive& p = scene.rig.primitives[i];
        const auto sphere = [&](int k) { return spheres[std::size_t(p.sphere[k])]; };
        shapes[i] = shape(p.count, sphere(0), sphere(1), sphere(2));
        const bool finite = std::isfinite(dot(shapes[i].low, shapes[i].high));
        if (finite && scene.tools[std::size_t(p.tool)].active)
            active.bits[i / 32] |= 1u << (i % 32);
    }
}

// Particles scatter mass and momentum to 27 nodes.  (1), (2); with labels (25), bodies (25a)
void Reference::p2g(double dt)
{
    const Lattice<double>& lattice = scene.lattice;
    for (auto& field : fields)
        for (const int n : occupied) field[std::size_t(n)] = {};
    occupied.clear();
    for (const Particle<double>& p : q) {
        const Stencil<double> s = stencil(p.x, lattice.spacing);
        const Material<double>& m = scene.materials[std::size_t(p.object)];
        scatter(p, m, s, lattice.spacing, dt, [&](Int3 step, const Node<double>& share) {
            const int n = lattice.index(s.base + step);
            if (fields[uncut][std::size_t(n)].m == 0 && share.m > 0) occupied.push_back(n);
            for (std::uint32_t f = 0; f < fields.size(); ++f) {
                Node<double>& to = fields[f][std::size_t(n)];
                const bool in = bodies.colours > 0 ? f == field_of(p.object, p.label())
                                                   : p.label() != opposite(f);
                if (f == uncut || in) to = {to.p + share.p, to.m + share.m};
            }
        });
    }
}

// Bodies exchange momentum at nodes where they touch.  (25a)
void Reference::separate(double dt)
{
    if (bodies.colours == 0) return;
    const Lattice<double>& lattice = scene.lattice;
    const BodyFields<double> constants = body_fields<double>(bodies, scene);
    const auto update = [&](std::size_t slot) {  // changes the node's momenta; masses stay
        const Int3 n = lattice.node_at(occupied[slot]);
        const auto node = [&](int field, Int3 at) -> Node<double>& {
            return fields[std::size_t(field)][std::size_t(lattice.index(at))];
        };
        const auto mass = [&](int f, Int3 step) {
            return lattice.stores(n + step) ? node(f, n + step).m : 0.0;
        };
        const auto momentum = [&](int f) { return node(f, n).p; };
        const auto add = [&](int f, Vec3<double> impulse) {
            node(f, n).p = node(f, n).p + impulse;
        };
        if (constants.labels > 1)
            separate_fields<labels_of_clay>(constants, lattice.dx, dt, mass, momentum, add);
        else
            separate_fields<1>(constants, lattice.dx, dt, mass, momentum, add);
    };
    parallel_for(occupied.size(), LoopOptions{.threads = threads}, update);
}

// The side of a blade on which field f of bodies is kept at node n; uncut: neither, as its clay
// there moves with uncut clay.
std::uint32_t Reference::sliced_side(std::size_t f, Int3 n) const
{
    const int labels = bodies.labels, label = int(f - 1) % labels, first = int(f) - label;
    const auto mass = [&](int k) {
        return fields[std::size_t(first + k)][std::size_t(scene.lattice.index(n))].m;
    };
    if (labels == 1) return uncut;
    const LabelledClay<double> clay{mass(uncut), mass(above), mass(below)};
    return clay.bridged() ? std::uint32_t(uncut) : std::uint32_t(label);
}

// Velocities of all fields of bodies at node n, and their mean in field 0.
void Reference::put_bodies(Int3 n, Node<double> (&of)[most_fields])
{
    const auto at = std::size_t(scene.lattice.index(n));
    for (int c = 1; bodies.labels > 1 && c <= bodies.colours; ++c)
        weld_velocities<double>(
            1 + (c - 1) * bodies.labels, [&](int f) { return of[f]; },
            [&](int f, const Node<double>& node) { of[f] = node; });
    Vec3<double> sum{};
    double mass = 0;
    for (std::size_t f = 1; f < fields.size(); ++f) {
        fields[f][at].p = of[f].p;
        sum = sum + of[f].m * of[f].p, mass += of[f].m;
    }
    fields[uncut][at].p = mass > 0 ? (1 / mass) * sum : Vec3<double>{};
}

// Momenta become velocities (3), (18), (18a); beside a blade each label has its own (24), (25). A
// node is updated together with its mirror images across walls.
void Reference::grid(double dt)
{
    const Lattice<double>& lattice = scene.lattice;
    const Colliders<double> tools = colliders();
    const double light = negligible_mass(scene);
    ++substeps;
    const auto update = [&](std::size_t slot, Counts<long>& counts) {
        const Int3 n = lattice.node_at(occupied[slot]);
        const auto at = [&](std::size_t f, Int3 m) -> Node<double>& {
            return fields[f][std::size_t(lattice.index(m))];
        };
        const auto [is_mirror, mirror_offset] =
            mirror_set(n, walls, [&](Int3 to) { return at(uncut, n + to).m; });
        if (is_mirror) return;
        Node<double> v[most_fields][8] = {};
        const bool apart = bodies.colours > 0;
        for (std::size_t f = apart; f < fields.size(); ++f) {
            const std::uint32_t side = !blades ? uncut : apart ? sliced_side(f, n) : unsigned(f);
            const auto obstacles = [&](Vec3<double>& u) {
                if (!scene.grid_contact) return false;
                const Vec3<double> x = lattice.position(n), free = u;
                u = apply_tools(tools, active, x, u);
                if (side != uncut) u = sliced(tools, active, x, u, lattice.dx, side);
                return differ(u, free);
            };
            for (int k = 0; k < mirror_count(mirror_offset); ++k)
                v[f][k] = at(f, mirror_node(n, mirror_offset, k));
            update_mirrors(
                n, mirror_offset, lattice, walls, scene.gravity, dt, InArray<double>{v[f]},
                obstacles,
                [&](double mass) {
                    ++counts[mass > light ? Count::clipped : Count::clipped_negligible];
                },
                SlidingInArray<double>{sliding[f].data(), lattice.dx, substeps},
                [&](Int3 m) { return at(uncut, m).m; });
        }
        for (int k = 0; k < mirror_count(mirror_offset); ++k) {
            const Int3 m = mirror_node(n, mirror_offset, k);
            Node<double> one[3] = {v[uncut][k], v[above][k], v[below][k]};  // without bodies
            if (blades && !apart)
                divide(one, {one[uncut].m, one[above].m, one[below].m}, [&] {
                    return slope(lattice, m, [&](Int3 other) {  // masses are unchanged here
                        return at(below, other).m - at(above, other).m;
                    });
                });
            if (apart) {
                Node<double> of[most_fields];
                for (std::size_t f = 1; f < fields.size(); ++f) of[f] = v[f][k];
                put_bodies(m, of);
                continue;
            }
            for (std::size_t f = 0; f < fields.size(); ++f) at(f, m).p = one[f].p;
        }
    };
    stats.counts +=
        parallel_sum<Counts<long>>(occupied.size(), LoopOptions{.threads = threads}, update);
}

// Nearly incompressible clay takes the mean pressure of its cell.  (7a)
void Reference::share_pressure()
{
    const auto material = [&](const Particle<double>& p) -> const Material<double>& {
        return scene.materials[std::size_t(p.object)];
    };
    if (std::none_of(scene.materials.begin(), scene.materials.end(), shares_pressure<double>))
        return;
    std::vector<PressureSum<double>> sums(fields[uncut].size());
    const auto cell = [&](const Particle<double>& p) -> PressureSum<double>& {
        return sums[std::size_t(scene.lattice.index(base_node(p.x, scene.lattice.spacing)))];
    };
    for (const Particle<double>& p : q)
        if (shares_pressure(material(p)))
            cell(p).add(own_pressure(p, material(p)), material(p).volume);
    for (Particle<double>& p : q)
        if (shares_pressure(material(p))) apply_mean_pressure(p, material(p), cell(p).mean());
}

// Gathers velocity and gradient (8); updates strain and position (9).
void Reference::g2p(double dt)
{
    const Lattice<double>& lattice = scene.lattice;
    before = q;
    per_cell.resize(q.size());
    const auto update = [&](std::size_t i, long& sudden) {
        Particle<double>& p = q[i];
        const Stencil<double> s = stencil(p.x, lattice.spacing);
        const std::vector<Node<double>>& field = fields[field_of(p.object, p.label())];
        const auto node = [&](Int3 step) {
            return field[std::size_t(lattice.index(s.base + step))];
        };
        const auto sum = gather(p, s, lattice.spacing, [&](Int3 step) { return four(node(step)); });
        const double mass = scene.materials[std::size_t(p.object)].mass;
        per_cell[i] = mass_around(sum) / mass;
        damp_isolated_particle(p.C, node(nearest_node).m / mass);
        sudden += abrupt(p.C, dt);
        p.e = advance_b(p.e, p.C, dt);
        p.x = p.x + dt * p.v;
    };
    stats[Count::abrupt] += parallel_sum<long>(q.size(), LoopOptions{.threads = threads}, update);
}

// Projects particles out of tools and walls, and to their side of a blade.  (19), (23), (24)
void Reference::project(double dt)
{
    const Colliders<double> tools = colliders();
    const PushoutLimits<double> pushout = pushout_limits(step_limits(scene));
    struct Sums {
        Counts<long> counts{};
        std::uint32_t touched = 0;
        double deepest = 0;
        void operator+=(const Sums& s)
        {
            counts += s.counts, touched |= s.touched;
            deepest = std::fmax(deepest, s.deepest);
        }
    };
    const auto update = [&](std::size_t i, Sums& sums) {
        Particle<double>& p = q[i];
        if (blades && scene.passes > 0)
            sums.counts[Count::covered] += cut(p, tools, active, scene.lattice.dx, sums.touched);
        depth[i] =
            knead::project(p, tools, active, scene.passes, pushout, per_cell[i], dt, sums.touched);
        sums.counts[Count::projected] += depth[i] > 0;
        sums.counts[Count::moved_far] += depth[i] > scene.lattice.dx;
        sums.deepest = std::fmax(sums.deepest, depth[i]);
        sums.counts[Count::confined] += confine(p, walls);
    };
    const Sums all = parallel_sum<Sums>(q.size(), LoopOptions{.threads = threads}, update);
    stats.counts += all.counts, stats.touched |= all.touched;
    stats.found_depth = std::fmax(stats.found_depth, all.deepest - pushout.skin);
}

// Return map of each material.  (10), (11)
void Reference::plasticity(double dt)
{
    const auto update = [&](std::size_t i, long& yielded) {
        yielded += yield(q[i], scene.materials[std::size_t(q[i].object)], dt);
    };
    stats[Count::yielded] += parallel_sum<long>(q.size(), LoopOptions{.threads = threads}, update);
}

void Reference::repair()
{
    for (std::size_t i = 0; i < q.size(); ++i)
        stats[Count::repaired] += knead::repair(q[i], before[i]);
}

// Gaussians are advected and deformed by the velocities around them, kept within walls and, if
// `clear`, out of tools.  (31)-(34)
void Reference::deform(const Lag& lag, bool clear)
{
    const Lattice<double>& lattice = scene.lattice;
    const Colliders<double> tools = colliders();
    const double per_mass = 1 / lightest_particle(scene);
    const auto update = [&](std::size_t i, Counts<long>& counts) {
        Gaussian<double>& g = splats[i];
        const Gaussian<double> start = g;
        const Int3 base = base_node(g.x, lattice.spacing);
        const std::vector<Node<double>>& field = fields[field_of(g.object, g.label())];
        const auto node = [&](Int3 step) {
            return node_share(field[std::size_t(lattice.index(base + step))], per_mass);
        };
        if (!knead::deform(g, lattice.spacing, lag.each<double>(), lag.substeps, node))
            counts[Count::stranded] += lag.substeps;
        keep_within(g, walls);
        if (clear)
            counts[Count::splats_projected] +=
                keep_out(g, tools, active, scene.passes, blades, walls, lattice.dx);
        counts[Count::splats_repaired] += knead::repair(g, start);
    };
    stats.counts +=
        parallel_sum<Counts<long>>(splats.size(), LoopOptions{.threads = threads}, update);
}

// End of a frame: the start of a stroke clears old labels near the blade; its end labels complete
// pieces.
void Reference::end_cuts()
{
    if (!blades) return;
    const bool covered = stats[Count::covered] > 0;
    const auto everywhere = [&](Vec3<double>) -> const Mask& { return active; };
    relabel_pieces(q, splats, scene.lattice, bodies, colliders(), everywhere, covered, was_covered);
    was_covered = covered;
}

Colliders<double> Reference::colliders() const
{
    const Rig& rig = scene.rig;
    return {{spheres.data(), int(spheres.size())},
            {rig.primitives.data(), int(rig.primitives.size())},
            {shapes.data(), int(shapes.size())},
            {scene.tools.data(), int(scene.tools.size())}};
}

Extremes Reference::extremes() const
{
    Extremes most{};
    for (std::size_t i = 0; i < q.size(); ++i) {
        const Particle<double>& p = q[i];
        most.speed = std::fmax(most.speed, std::sqrt(speed_that_counts(dot(p.v, p.v), depth[i])));
        most.stiffness =
            std::fmax(most.stiffness, stiffness(p, scene.materials[std::size_t(p.object)]));
    }
    return most;
}

// Number of blocks with mass.
long Reference::active_blocks() const
{
    std::set<int> blocks;
    for (const int n : occupied) blocks.insert(n / block_nodes);
    return long(blocks.size());
}

std::vector<double> Reference::penetration() const
{
    std::vector<double> depths;
    for (const Particle<double>& p : q) {
        const Contact<double> hit = deepest_contact(colliders(), active, p.x);
        if (hit.phi < 0) depths.push_back(-hit.phi);
    }
    return depths;
}

std::vector<Vec3<double>> Reference::velocities() const
{
    if (shapes.empty() || scene.passes == 0) return {};
    const Lattice<double>& lattice = scene.lattice;
    std::vector<Vec3<double>> all(q.size());
    for (std::size_t i = 0; i < q.size(); ++i) {
        all[i] = q[i].v;
        if (depth[i] > 0)
            all[i] = velocity_at(q[i].x, lattice.spacing, q[i].v, [&](Int3 n) {
                return fields[uncut][std::size_t(lattice.index(n))];
            });
    }
    return all;
}

std::size_t Reference::memory() const
{
    return (q.capacity() + before.capacity()) * sizeof(Particle<double>) +
           fields.size() * fields[0].capacity() * sizeof(Node<double>);
}

std::string Reference::name() const
{
    return "reference: cpu double, " + std::to_string(threads) + " threads";
}

}  // namespace knead
