#include "host/solver/between.h"

#include <algorithm>
#include <cmath>

#include "cuda/contact/contact.h"
#include "cuda/math/box.h"
#include "host/solver/cpu/tools.h"

namespace knead {
namespace {

struct Body {
    std::size_t tool = 0;
    Mask mask{};                             // primitives
    Box3<double> box = empty_box<double>();  // around them [m]
};

// Of all tools; blades and inactive ones have no primitives.
std::vector<Body> all_bodies(const PosedTools<double>& posed)
{
    std::vector<Body> all(posed.tools.size());
    for (std::size_t tool = 0; tool < all.size(); ++tool) all[tool].tool = tool;
    for (std::size_t i = 0; i < posed.shapes.size(); ++i) {
        const auto owner = std::size_t(posed.primitives[i].tool);
        if (!posed.tools[owner].active || posed.tools[owner].blade) continue;
        const Shape<double>& s = posed.shapes[i];
        if (!std::isfinite(dot(s.low, s.high))) continue;
        Body& b = all[owner];
        b.mask.bits[i / 32] |= 1u << (i % 32);
        grow(b.box, Box3<double>{s.low, s.high});
    }
    return all;
}

// Active tools whose bounding box meets the bounding box of another.
std::vector<Body> bodies_of(const PosedTools<double>& posed)
{
    const std::vector<Body> all = all_bodies(posed);
    std::vector<Body> met;
    for (const Body& b : all)
        if (std::any_of(all.begin(), all.end(),
                        [&](const Body& o) { return &o != &b && intersects(b.box, o.box); }))
            met.push_back(b);
    return met;
}

}  // namespace

std::vector<double> depths_between(const SimulationConfig& setup, const Motion& motion,
                                   const std::vector<Particle<double>>& particles)
{
    std::vector<double> depths;
    if (setup.tools.size() < 2) return depths;
    PosedTools<double> posed(setup, {{4, 4, 4}, setup.lattice.dx});  // masks are not used
    posed.activate(motion);
    posed.pose(motion, 1, 1, 1);
    const Colliders<double> tools = posed.colliders();
    const std::vector<Body> bodies = bodies_of(posed);
    const auto at = [&](const Body& b, Vec3<double> x) {
        return contains(b.box, x) ? deepest_contact(tools, b.mask, x)
                                  : Contact<double>{0, {}, {}, -1};
    };
    const auto depth_of = [&](Vec3<double> x) {
        for (const Body& in : bodies) {
            const Contact<double> hit = at(in, x);
            if (!(hit.phi < 0)) continue;
            const Vec3<double> out = x - hit.phi * hit.n;
            for (const Body& other : bodies)
                if (&other != &in && at(other, out).phi < 0) return -hit.phi;
        }
        return 0.0;
    };
    for (const Particle<double>& p : particles)
        if (const double depth = depth_of(p.x); depth > 0) depths.push_back(depth);
    return depths;
}

std::vector<char> tools_in_clay(const SimulationConfig& config, const Motion& motion,
                                const Simulator& simulator, float size)
{
    std::vector<char> inside(config.tools.size(), 0);
    if (inside.empty()) return inside;
    Motion full = motion;
    full.active.assign(inside.size(), 1), full.size.assign(inside.size(), size);
    PosedTools<double> posed(config, {{4, 4, 4}, config.lattice.dx});  // masks are not used
    posed.activate(full);
    posed.pose(full, 1, 1, 1);
    const Colliders<double> tools = posed.colliders();
    for (const Body& body : all_bodies(posed)) {
        if (!(body.box.low.x <= body.box.high.x)) continue;
        const std::vector<Vec3<double>> near = simulator.places(body.box);
        inside[body.tool] = std::any_of(near.begin(), near.end(), [&](Vec3<double> x) {
            return deepest_contact(tools, body.mask, x).phi < 0;
        });
    }
    return inside;
}

}  // namespace knead
