#include "host/verify/clay.h"

#include <algorithm>
#include <cmath>

#include "host/base/errors.h"
#include "host/base/interrupt.h"
#include "host/scene/presets.h"
#include "host/solver/reference.h"

namespace knead {

Setup between_walls(Int3 cells, double dx, ContactMode mode, double friction)
{
    const auto nodes = [](int free) { return (free + 7 + 3) / 4 * 4; };  // whole blocks
    const auto face = [dx](int n) { return dx * n; };
    Setup s{};
    s.lattice = {{nodes(cells.x), nodes(cells.y), nodes(cells.z)}, dx};
    s.walls = {{face(3), face(3), face(3)},
               {face(3 + cells.x), face(3 + cells.y), face(3 + cells.z)},
               mode,
               friction};
    return s;
}

Place floor_of(const Setup& s)
{
    const Place &a = s.walls.min, &b = s.walls.max;
    return {(a.x + b.x) / 2, a.y, (a.z + b.z) / 2};
}

static MaterialSpec solid(Plasticity plasticity, double young, double poisson, double density)
{
    return {.name = "solid",
            .elasticity = Elasticity::neo_hookean,
            .plasticity = plasticity,
            .density = density,
            .young = young,
            .poisson = poisson};
}

Material<double> elastic(double young, double poisson, double density)
{
    return made(solid(Plasticity::none, young, poisson, density));
}

Material<double> plastic(double young, double poisson, double density, double yield)
{
    MaterialSpec spec = solid(Plasticity::von_mises, young, poisson, density);
    spec.yield = yield, spec.yield_floor = yield / 100;
    return made(spec);
}

int fill(Setup& s, Material<double> material, Place from, Place to, int per_axis,
         const std::function<bool(Place)>& inside)
{
    const double h = s.lattice.dx / per_axis;
    material.volume = h * h * h;
    material.mass = material.density * material.volume;
    const auto object = int(s.materials.size());
    s.materials.push_back(material);
    const auto count = [h](double low, double high) { return int(std::lround((high - low) / h)); };
    const Int3 n{count(from.x, to.x), count(from.y, to.y), count(from.z, to.z)};
    for (int z = 0; z < n.z; ++z)
        for (int y = 0; y < n.y; ++y)
            for (int x = 0; x < n.x; ++x) {
                Particle<double> q{};
                q.x = from + Place{h * (x + 0.5), h * (y + 0.5), h * (z + 0.5)};
                q.object = object;
                if (inside(q.x)) s.particles.push_back(q);
            }
    return object;
}

int add_ball_tool(Setup& s, double radius, ContactMode mode, double friction)
{
    const auto number = int(s.tools.size()), sphere = int(s.rig.spheres.size());
    Binding<float> b{};
    for (int& j : b.joint) j = number;
    b.weight[0] = 1, b.radius = float(radius);
    s.rig.spheres.push_back(b);
    s.rig.primitives.push_back({1, {sphere, sphere, sphere}, number});
    s.tools.push_back({mode, friction, false, true});
    return number;
}

std::vector<Particle<double>> by_id(const Simulator& solver)
{
    const EditableSimulator* editable = solver.editable();
    return editable ? editable->save().contents.particles : solver.particles();
}

FrameStats drive(Simulator& solver, double frame, double end,
                 const std::function<std::vector<Joint<double>>(double)>& at,
                 const std::function<bool(double)>& observe)
{
    FrameStats all;
    const auto frames = long(std::ceil(end / frame - 1e-9));
    for (long i = 0; i < frames; ++i) {
        if (interrupted()) throw std::runtime_error("interrupted");
        const double from = double(i) * frame, to = std::fmin(double(i + 1) * frame, end);
        const FrameStats s = solver.advance({at(from), at(to), {}}, to - from);
        add_to(all, s);
        if (!observe(to)) break;
    }
    return all;
}

FrameStats drive(Simulator& solver, double frame, double end,
                 const std::function<bool(double)>& observe)
{
    return drive(
        solver, frame, end, [](double) { return std::vector<Joint<double>>{}; }, observe);
}

}  // namespace knead
