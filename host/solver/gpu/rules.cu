// Rules of a scene on the device: materials, tools, kernel variants.
#include <algorithm>
#include <array>
#include <cmath>

#include "cuda/mpm/body_graph.cuh"
#include "cuda/mpm/mean_pressure.h"
#include "host/solver/bodies.h"
#include "host/solver/gpu/store.cuh"

namespace knead::gpu {

Features features_of(const SimulationConfig& s, bool deterministic)
{
    const bool blades = s.cuts || std::any_of(s.tools.begin(), s.tools.end(),
                                              [](const Tool<double>& t) { return t.blade; });
    Features f{
        !s.rig.primitives.empty() || blades, deterministic,           blades,
        s.rest.mode != RestMode::none,       s.materials.size() != 1, PlasticityClass::elastic};
    f.colours = bodies_of(s).colours, f.bodies = f.colours > 0;  // of all frames
    if (f.bodies) f.tools = true;                                // its kernels are those with tools
    for (const Material<double>& m : s.materials) {
        if (!there(m)) continue;
        f.mean_pressure = f.mean_pressure || shares_pressure(m);
        const bool plain =
            m.elasticity == Elasticity::neo_hookean &&
            (m.plasticity == Plasticity::none || m.plasticity == Plasticity::von_mises);
        if (!plain)
            f.plasticity = PlasticityClass::any;
        else if (m.plasticity == Plasticity::von_mises && f.plasticity == PlasticityClass::elastic)
            f.plasticity = PlasticityClass::plastic;
    }
    return f;
}

namespace {

// The largest power of two that keeps a sum of magnitude up to `bound` within 62 bits.
float fixed_scale(double bound)
{
    return bound > 0 ? std::ldexp(1.0f, 61 - std::ilogb(bound)) : 1.0f;
}

// Fixed-point units of the pressure sums: float precision for the largest volume and the stiffest
// clay.
PressureView pressure_units(const std::vector<Material<double>>& materials)
{
    double volume = 0, stiffest = 0;
    for (const Material<double>& m : materials)
        if (there(m) && shares_pressure(m)) {
            const bool liquid = m.plasticity == Plasticity::fluid;
            volume = std::max(volume, m.volume);
            stiffest = std::max(stiffest, liquid ? m.bulk : m.lambda);
        }
    const auto units = [](double most) {
        return most > 0 ? std::ldexp(1.0f, 40 - std::ilogb(most)) : 1.0f;
    };
    return {{}, units(volume * stiffest), units(volume)};
}

// Uploads, and reallocates only if the array is too small.
template <class T>
void fill(DeviceArray<T>& to, const std::vector<T>& from)
{
    if (to.size() < from.size()) to = DeviceArray<T>(from.size() + from.size() / 2);
    upload(to.data(), from.data(), from.size());
}

}  // namespace

void Store::set_features(const Features& features)
{
    const bool same_nodes =
        features.tools == used.tools && features.blades == used.blades &&
        features.rests == used.rests && features.fixed_point == used.fixed_point &&
        features.mean_pressure == used.mean_pressure && features.colours == used.colours;
    used = features;
    if (same_nodes) return;
    set_box(all.lattice);
    reserve_runs();
}

void Store::set_rules(const SceneState& rules)
{
    const SimulationConfig& config = rules.config();
    set_features(features_of(config, used.fixed_point));
    std::vector<Material<float>> each;
    for (const Material<double>& m : config.materials) each.push_back(cast<float>(m));
    fill(materials, each);
    const Material<float> first = each.empty() ? Material<float>{} : each[0];
    bodies = bodies_of(config);
    set_colours(config);
    all.materials = {
        first,         1 / first.density, 1 / first.mass, materials.data(), int(each.size()),
        colours.data()};
    all.walls = walls_on<float>(config.lattice, config.walls);
    const auto wanted = std::size_t(sliding_places(all.walls)) * std::size_t(field_count(used));
    if (sliding.size() != wanted) sliding = DeviceArray<Sliding<float>>(wanted);
    all.sliding = sliding.data();
    all.gravity = cast<float>(config.gravity);
    all.limits = step_limits(config);
    all.tools.pushout = cast<float>(pushout_limits(all.limits));
    // The momentum scale admits one cell per substep at a hundredth of the longest stable dt.
    const double speed = 100 * std::sqrt(all.limits.stiffness) / all.limits.courant;
    all.grid.negligible_mass = float(negligible_mass(config));
    const Rest<double>& rest = config.rest;
    const bool holds = rest.mode == RestMode::localized;
    const double mass = (holds ? held_weight : 1) * rules.mass();
    all.grid.mass_scale = fixed_scale(mass);
    all.grid.momentum_scale = fixed_scale(mass * speed);
    all.pressure = pressure_units(config.materials);
    all.rest.options = {rest.mode, float(rest.speed), rest.frames, float(rest.push),
                        float(rest.reach)};
    point();
}

void Store::set_colours(const SimulationConfig& config)
{
    std::vector<int> first_fields = bodies.colour;
    for (int& c : first_fields)
        if (c > 0) c = 1 + (c - 1) * bodies.labels;
    fill(colours, first_fields);
    all.bodies = body_fields<float>(bodies, config);
    if (!bodies.shared()) return;
    fill(body_of, bodies.body);
    const Int3 bins = bins_of(config.lattice.size);
    const auto wanted = std::size_t(bins.x) * std::size_t(bins.y) * std::size_t(bins.z);
    if (bins_masks.size() < wanted) bins_masks = DeviceArray<unsigned long long>(wanted);
    if (graph.size() == 0) graph = DeviceArray<unsigned long long>(2 * most_bodies);
}

bool Store::recolour(const SimulationConfig& config, int side, cudaStream_t stream)
{
    if (!bodies.shared()) return false;
    const Int3 bins = bins_of(config.lattice.size);
    const auto places = std::size_t(bins.x) * std::size_t(bins.y) * std::size_t(bins.z);
    check(cudaMemsetAsync(bins_masks.data(), 0, places * sizeof(unsigned long long), stream),
          "bodies");
    check(cudaMemsetAsync(graph.data(), 0, graph.bytes(), stream), "bodies");
    body_graph(read_only(all.particles[side]), all.lattice, body_of.data(), bins_masks.data(),
               graph.data(), stream);
    std::array<unsigned long long, 2 * most_bodies> found;
    check(cudaMemcpyAsync(found.data(), graph.data(), sizeof found, cudaMemcpyDefault, stream),
          "bodies");
    wait(stream, "bodies");
    BodyGraph of;
    std::copy_n(found.begin(), most_bodies, of.touching.begin());
    std::copy_n(found.begin() + most_bodies, most_bodies, of.near.begin());
    if (!bodies.colour_by(of)) return false;
    set_colours(config);
    return true;
}

void Store::set_category(int object, int category)
{
    gpu::upload(&materials.data()[object].category, &category, 1);
    if (object == 0) all.materials.first.category = category;
}

void Store::set_tools(const SceneState& rules)
{
    const SimulationConfig& config = rules.config();
    check_tools(config);
    set_features(features_of(config, used.fixed_point));
    fill(bindings, config.rig.spheres), fill(primitives, config.rig.primitives);
    for (int parity = 0; parity < 2; ++parity) {
        spheres[parity] = DeviceArray<Sphere<float>>(config.rig.spheres.size());
        shapes[parity] = DeviceArray<Shape<float>>(config.rig.primitives.size());
    }
    mid_frame = DeviceArray<Shape<float>>(config.rig.primitives.size());
    travel = DeviceArray<float>(config.rig.primitives.size());
    point_at_tools(config);
    point();
}

void Store::point_at_tools(const SimulationConfig& config)
{
    const int joints = joints_of(config.rig);
    all.tools = {input.data()->joints,
                 input.data()->joints + joints,
                 joints,
                 bindings.data(),
                 {spheres[0].span(), spheres[1].span()},
                 {shapes[0].span(), shapes[1].span()},
                 mid_frame.span(),
                 travel.data(),
                 {primitives.data(), int(config.rig.primitives.size())},
                 {input.data()->tools, int(config.tools.size())},
                 box.masks.data(),
                 in_line.data(),
                 all.tools.run_count,
                 near_runs.data(),
                 config.grid_contact,
                 config.passes,
                 all.tools.pushout};
}

}  // namespace knead::gpu
