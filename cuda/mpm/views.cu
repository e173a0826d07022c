// Makes each stage's view from all device data.
#include "cuda/mpm/stages.cuh"

namespace knead::gpu {
namespace {

template <class T>
Span<const T> const_view(const Span<T>& span)
{
    return {span.data, span.count};
}

RigView rig_view(const ToolView& t)
{
    return {t.from, t.to, t.joints, t.bindings, t.primitives, t.tools};
}

SweptView swept_view(const ToolView& t)
{
    return {t.primitives, t.tools, t.mid_frame.data, t.travel};
}

ContactView contact_view(const ToolView& t)
{
    return {{const_view(t.spheres[0]), const_view(t.spheres[1])},
            {const_view(t.shapes[0]), const_view(t.shapes[1])},
            t.primitives,
            t.tools};
}

NearView near_view(const Views& d)
{
    return {d.stored, d.tools.masks, d.tools.passes, d.tools.pushout};
}

ScatterView scatter_view(const Views& d)
{
    const GridView& g = d.grid;
    return {d.lattice,
            g.rim,
            g.momentum_scale,
            g.mass_scale,
            {g.nodes[0], g.nodes[1]},
            {g.sums[0], g.sums[1]},
            g.marks,
            {g.list[0], g.list[1], g.list[2]},
            d.clock};
}

}  // namespace

BeginView begin_view(const Views& d)
{
    return {d.input, d.limits, d.rest.options.mode, d.clock, d.conditions};
}

SweepView sweep_view(const Views& d)
{
    return {rig_view(d.tools), d.tools.mid_frame.data, d.tools.travel};
}

MaskView mask_view(const Views& d) { return {swept_view(d.tools), d.lattice, d.tools.masks}; }

PoseView pose_view(const Views& d)
{
    const ToolView& t = d.tools;
    return {rig_view(t),
            d.clock,
            {t.spheres[0].data, t.spheres[1].data},
            {t.shapes[0].data, t.shapes[1].data}};
}

LineUpView line_up_view(const Views& d)
{
    return {{read_only(d.particles[0]), read_only(d.particles[1])},
            d.lattice,
            near_view(d),
            d.tools.run_count,
            d.clock,
            d.tools.near_runs,
            d.tools.runs};
}

SortView sort_view(const Views& d) { return {{d.particles[0], d.particles[1]}, d.clock}; }

KeyView key_view(const Views& d) { return {sort_view(d), d.lattice, d.rest.fastest}; }

SettledView settled_view(const Views& d)
{
    return {sort_view(d), d.rest.activity, d.rest.range, d.rest.run_listed, d.rest.list};
}

ActivityView activity_view(const Views& d)
{
    const RestView& r = d.rest;
    return {swept_view(d.tools), d.lattice, r.options,    r.quiet, r.fastest,
            r.activity,          r.range,   r.run_listed, d.clock};
}

SpreadView spread_view(const Views& d) { return {d.lattice, d.rest.options, d.rest.activity}; }

StampView stamp_view(const Views& d)
{
    const RestView& r = d.rest;
    return {d.clock, r.activity, d.lattice.block_count(), r.free, r.guard, r.changed, r.reached};
}

PressureFindView pressure_find_view(const Views& d)
{
    return {d.pressure,
            {read_only(d.particles[0]), read_only(d.particles[1])},
            d.materials,
            d.lattice,
            d.clock};
}

PressureClearView pressure_clear_view(const Views& d)
{
    return {d.pressure, {d.grid.list[0], d.grid.list[1], d.grid.list[2]}, d.clock};
}

P2gView p2g_view(const Views& d)
{
    return {scatter_view(d), {read_only(d.particles[0]), read_only(d.particles[1])},
            d.materials,     d.rest.options.mode,
            d.gravity,       d.rest.list};
}

GridUpdateView grid_view(const Views& d)
{
    const GridView& g = d.grid;
    const RestView& r = d.rest;
    return {contact_view(d.tools),
            d.tools.masks,
            d.tools.grid_contact,
            d.lattice,
            d.walls,
            d.gravity,
            d.limits,
            g.fields,
            g.momentum_scale,
            g.mass_scale,
            g.negligible_mass,
            g.rim,
            {g.nodes[0], g.nodes[1]},
            {g.sums[0], g.sums[1]},
            g.marks,
            {g.list[0], g.list[1], g.list[2]},
            d.sliding,
            d.clock,
            {r.options.mode,
             r.run,
             r.range,
             {r.woken[0], r.woken[1]},
             r.guard,
             r.reached,
             r.run_listed,
             r.list},
            (d.overlaps & overlap::contact_ahead) != 0};
}

BodyView body_view(const Views& d)
{
    const GridView& g = d.grid;
    return {d.lattice,
            d.bodies,
            {g.list[0], g.list[1], g.list[2]},
            d.clock,
            g.momentum_scale,
            1 / g.momentum_scale,
            1 / g.mass_scale,
            {g.nodes[0], g.nodes[1]},
            {g.sums[0], g.sums[1]}};
}

G2pView g2p_view(const Views& d)
{
    const RestView& r = d.rest;
    return {scatter_view(d),
            {d.grid.nodes[0], d.grid.nodes[1]},
            d.materials,
            d.free,
            d.walls,
            contact_view(d.tools),
            near_view(d),
            d.pressure,
            d.tools.runs,
            r.list,
            {d.particles[0], d.particles[1]},
            pose_view(d),
            {r.options, d.gravity, r.guard, r.range, r.free, r.changed, {r.woken[0], r.woken[1]}},
            d.conditions.captured,
            d.conditions.again,
            (d.overlaps & overlap::pose_ahead) != 0};
}

PenetrationView penetration_view(const Views& d)
{
    return {
        d.lattice, contact_view(d.tools), d.tools.masks, d.clock, {d.particles[0], d.particles[1]}};
}

VelocityView velocity_view(const Views& d)
{
    return {penetration_view(d), d.tools.pushout.skin, {d.grid.nodes[0], d.grid.nodes[1]}};
}

}  // namespace knead::gpu
