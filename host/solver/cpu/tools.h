// The tools of a substep on the CPU: posed spheres, shapes, and the candidate primitives of each
// block.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "cuda/contact/cut.h"
#include "cuda/contact/skinning.h"
#include "cuda/mpm/lattice.h"
#include "host/solver/cpu/namespace.h"
#include "host/solver/simulator.h"
#include "host/solver/substep.h"

namespace knead {
inline namespace KNEAD_CPU_LEVEL {

template <class R>
struct PosedTools {
    std::vector<Binding<R>> bindings;  // with the tools' stretch applied
    std::vector<Primitive> primitives;
    std::vector<Tool<R>> tools;
    std::vector<int> owner;       // tool of each sphere
    std::vector<Binding<R>> rig;  // as given, unstretched
    std::vector<Sphere<R>> spheres;
    std::vector<Shape<R>> shapes;
    std::vector<Mask> masks;   // per lattice block
    std::vector<Int3> masked;  // block coordinates whose mask is not empty
    std::vector<char> near;    // per lattice block: its own or a neighbour's mask is not empty
    bool blades = false;       // a tool is a blade, or clay carries labels of a cut

    PosedTools(const SimulationConfig& setup, const Lattice<R>& lattice);
    Colliders<R> colliders() const
    {
        return {{spheres.data(), int(spheres.size())},
                {primitives.data(), int(primitives.size())},
                {shapes.data(), int(shapes.size())},
                {tools.data(), int(tools.size())}};
    }
    // Sets activity, scale and stretch of the tools for a frame of this motion.
    void activate(const Motion& motion);
    // Poses the tools at the end of the substep over the fractions [s0, s1] of the frame, which
    // lasts dt [s].
    void pose(const Motion& motion, double s0, double s1, double dt);
    void mask_blocks(const Lattice<R>& lattice);
    // The candidates at x; an empty mask outside the lattice.
    const Mask& mask_at(const Lattice<R>& lattice, Vec3<R> x) const;
};

template <class R>
PosedTools<R>::PosedTools(const SimulationConfig& setup, const Lattice<R>& lattice)
    : primitives(setup.rig.primitives),
      owner(tools_of_spheres(setup.rig)),
      spheres(setup.rig.spheres.size()),
      shapes(setup.rig.primitives.size()),
      masks(std::size_t(lattice.block_count()) + 1),
      near(std::size_t(lattice.block_count()))
{
    for (const Binding<float>& b : setup.rig.spheres) rig.push_back(cast<R>(b));
    bindings = rig;
    for (const Tool<double>& t : setup.tools) {
        tools.push_back({t.mode, R(t.friction), t.blade, t.active});
        blades = blades || t.blade;
    }
    blades = blades || setup.cuts;
}

template <class R>
void PosedTools<R>::activate(const Motion& motion)
{
    for (std::size_t t = 0; t < tools.size(); ++t) set_tool(tools[t], motion, t);
    for (std::size_t i = 0; i < rig.size(); ++i)
        bindings[i] = stretched(rig[i], tools[std::size_t(owner[i])].stretch);
}

template <class R>
void PosedTools<R>::pose(const Motion& motion, double s0, double s1, double dt)
{
    const auto from = joints_at<R>(motion, s0), to = joints_at<R>(motion, s1);
    for (std::size_t i = 0; i < bindings.size(); ++i)
        spheres[i] = posed(bindings[i], from, to, R(dt), tools[std::size_t(owner[i])].size);
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        const Primitive& p = primitives[i];
        shapes[i] = shape(p.count, spheres[std::size_t(p.sphere[0])],
                          spheres[std::size_t(p.sphere[1])], spheres[std::size_t(p.sphere[2])]);
    }
}

template <class R>
void PosedTools<R>::mask_blocks(const Lattice<R>& lattice)
{
    const Int3 size = lattice.blocks();
    const auto mark_near = [&](char mark) {
        for (Int3 b : masked)
            for (int z = std::max(b.z - 1, 0); z < std::min(b.z + 2, size.z); ++z)
                for (int y = std::max(b.y - 1, 0); y < std::min(b.y + 2, size.y); ++y)
                    for (int x = std::max(b.x - 1, 0); x < std::min(b.x + 2, size.x); ++x)
                        near[std::size_t(lattice.block_of({4 * x, 4 * y, 4 * z}))] = mark;
    };
    mark_near(0);
    for (Int3 b : masked) masks[std::size_t(lattice.block_of(4 * b))] = {};
    masked.clear();
    const R edge = block_edge * lattice.dx;
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        const Tool<R>& tool = tools[std::size_t(primitives[i].tool)];
        const Shape<R>& s = shapes[i];
        if (!tool.active || !std::isfinite(dot(s.low, s.high))) continue;
        const R band = R(candidate_band(tool.blade)) * lattice.dx;
        const auto low = [&](R x, int n) {
            return int(std::clamp(std::floor((x - band) / edge), R(0), R(n)));
        };
        const auto high = [&](R x, int n) {
            return int(std::clamp(std::floor((x + band) / edge), R(-1), R(n - 1)));
        };
        for (int z = low(s.low.z, size.z); z <= high(s.high.z, size.z); ++z)
            for (int y = low(s.low.y, size.y); y <= high(s.high.y, size.y); ++y)
                for (int x = low(s.low.x, size.x); x <= high(s.high.x, size.x); ++x) {
                    const Vec3<R> middle = {edge * (R(x) + R(0.5)), edge * (R(y) + R(0.5)),
                                            edge * (R(z) + R(0.5))};
                    if (!reaches(s, middle, edge, band)) continue;
                    Mask& m = masks[std::size_t(lattice.block_of({4 * x, 4 * y, 4 * z}))];
                    if (std::all_of(m.bits, m.bits + mask_words, [](auto w) { return w == 0; }))
                        masked.push_back({x, y, z});
                    m.bits[i / 32] |= 1u << (i % 32);
                }
    }
    mark_near(1);
}

template <class R>
const Mask& PosedTools<R>::mask_at(const Lattice<R>& lattice, Vec3<R> x) const
{
    const R s = 1 / lattice.dx;
    const Vec3<R> g = s * x;
    const bool inside = g.x >= 0 && g.y >= 0 && g.z >= 0 && g.x < R(lattice.size.x) &&
                        g.y < R(lattice.size.y) && g.z < R(lattice.size.z);
    if (!inside) return masks.back();
    return masks[std::size_t(lattice.block_of({int(g.x), int(g.y), int(g.z)}))];
}

}  // namespace KNEAD_CPU_LEVEL
}  // namespace knead
