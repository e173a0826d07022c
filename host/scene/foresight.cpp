#include "host/scene/foresight.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/base/errors.h"
#include "host/solver/substep.h"

namespace knead {
namespace {

double rest_stiffness(const Object& o) { return stiffness(Particle<double>{}, o.material); }

// Scene key of the object with the largest `measure`.
template <class Measure>
std::string most(const Scene& scene, const char* key, Measure&& measure)
{
    const auto less = [&](const Object& a, const Object& b) { return measure(a) < measure(b); };
    const auto found = std::max_element(scene.objects.begin(), scene.objects.end(), less);
    return fmt::format("objects.{}.{}", found - scene.objects.begin(), key);
}

bool is_fluid(const Object& o) { return o.material.plasticity == Plasticity::fluid; }

// Kinematic viscosity of a liquid [m^2/s].
double spreading(const Object& o)
{
    return is_fluid(o) ? o.material.viscosity / o.material.density : 0;
}

std::string key_of(const Scene& scene, StepChoice chosen)
{
    if (chosen.limit == Limit::fixed) {
        const bool paper = scene.clock == ClockMode::paper && chosen.dt == scene.paper_dt;
        return paper ? "paper.dt" : "step.fixed";
    }
    if (chosen.limit == Limit::viscosity) return most(scene, "material.viscosity", spreading);
    if (chosen.limit == Limit::sound) {
        const auto less = [](const Object& a, const Object& b) {
            return rest_stiffness(a) < rest_stiffness(b);
        };
        const bool fluid =
            is_fluid(*std::max_element(scene.objects.begin(), scene.objects.end(), less));
        return most(scene, fluid ? "material.bulk" : "material.young", rest_stiffness);
    }
    if (chosen.dt == scene.setup.step.largest) return "step.largest";
    return most(scene, "velocity", [](const Object& o) { return length(o.velocity); });
}

// Everything that limits a substep. Particles are left out: there may be many.
Setup steps_of(const Scene& scene)
{
    Setup setup;
    setup.lattice = scene.setup.lattice, setup.step = scene.setup.step;
    return setup;
}

}  // namespace

Foresight foresee(const Scene& scene)
{
    Setup setup = steps_of(scene);
    Extremes clay{};
    for (const Object& o : scene.objects) {
        setup.materials.push_back(o.material);
        clay.speed = std::max(clay.speed, length(o.velocity));
        clay.stiffness = std::max(clay.stiffness, rest_stiffness(o));
    }
    const StepLimits limits = step_limits(setup);
    const double frame = frame_duration(scene), no_tool = 1e30;
    const double dt = choose_dt(limits, clay, no_tool, frame).dt;
    const StepChoice longest = longest_dt(limits, clay);
    if (longest.dt >= frame)
        return {frame, 1, scene.clock == ClockMode::paper ? "paper.dt" : "frame_rate"};
    return {dt, std::ceil(frame / dt * (1 - 1e-9)), key_of(scene, longest)};
}

void check_substeps(const Scene& scene)
{
    const Foresight f = foresee(scene);
    if (f.substeps <= scene.most_substeps) return;
    std::string pointer = "/" + f.key;
    std::replace(pointer.begin(), pointer.end(), '.', '/');
    throw InputError(fmt::format(
        "{}: {}: expected a value with which a frame of {:.3g} s needs at most {} substeps "
        "(--set step.most_substeps=N allows more), found substeps of {:.3g} s, {:.3g} "
        "a frame",
        scene.path, pointer, frame_duration(scene), scene.most_substeps, f.dt, f.substeps));
}

void check_substeps(const Scene& scene, const Material<double>& material)
{
    Setup setup = steps_of(scene);
    setup.materials.push_back(material);
    Extremes clay{};
    clay.stiffness = stiffness(Particle<double>{}, material);
    const double frame = frame_duration(scene), no_tool = 1e30;
    const double dt = choose_dt(step_limits(setup), clay, no_tool, frame).dt;
    if (std::ceil(frame / dt * (1 - 1e-9)) <= scene.most_substeps) return;
    const bool fluid = material.plasticity == Plasticity::fluid;
    throw std::invalid_argument(
        fmt::format("{}: expected a value that needs at most {} substeps a frame "
                    "(step.most_substeps), found {:.3g}",
                    fluid ? "bulk or viscosity" : "young", scene.most_substeps, frame / dt));
}

}  // namespace knead
