#include "host/scene/seed.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "cuda/math/node4.h"
#include "cuda/mpm/walls.h"
#include "host/base/errors.h"
#include "host/hands/motion.h"
#include "host/scene/packing.h"
#include "host/scene/solid_mesh.h"
#include "host/scene/strand.h"

namespace knead {
namespace {

constexpr double max_particles = 1e9;  // indices are int

std::string place(const Scene& scene, std::size_t object)
{
    return fmt::format("{}: /objects/{}", scene.path, object);
}

// Errors state positions in the frame of the scene's file.
void check_between_walls(const Scene& scene, std::size_t index)
{
    const Object& o = scene.objects[index];
    const double slack = 1e-6 * scene.setup.lattice.dx;
    const Vec3<double> centre = middle_of(o) + scene.origin, size = extents(o),
                       min = scene.setup.walls.min + scene.origin,
                       max = scene.setup.walls.max + scene.origin;
    const auto check = [&](const char* axis, double c, double edge, double low, double high) {
        if (c - edge / 2 >= low - slack && c + edge / 2 <= high + slack) return;
        throw InputError(fmt::format(
            "{}: expected the object between the walls, {} from {:.6g} to {:.6g} m, found {} from "
            "{:.6g} to {:.6g} m",
            place(scene, index), axis, low, high, axis, c - edge / 2, c + edge / 2));
    };
    check("x", centre.x, size.x, min.x, max.x);
    check("y", centre.y, size.y, min.y, max.y);
    check("z", centre.z, size.z, min.z, max.z);
}

// Memory [bytes]. Per particle: the input list, one copy by an audit, and the solver's own data
// twice with its sorting keys; the same for a Gaussian. Per node: the grid, the tiles' sums and the
// masks. Plus the density lattice of the surface.
struct Memory {
    double clay, nodes, surface;
    double all() const { return clay + nodes + surface; }
};
Memory memory_of(const Scene& scene)
{
    const auto nodes = [](Int3 n) { return double(n.x) * n.y * n.z; };
    constexpr double particle = 2 * sizeof(Particle<double>) + 2 * sizeof(Particle<float>) + 32;
    constexpr double splat = 2 * sizeof(Gaussian<double>) + 2 * sizeof(Gaussian<float>) + 8;
    constexpr double node = 5 * sizeof(Node<float>) + double(sizeof(Mask)) / block_nodes;
    double splats = 0;
    for (const Object& o : scene.objects)
        if (o.given) splats += double(o.given->splats.size());
    return {expected_particles(scene) * particle + splats * splat,
            nodes(scene.setup.lattice.size) * node,
            nodes(scene.surface.lattice.size) * sizeof(float)};
}

void check_memory(const Scene& scene, std::size_t memory)
{
    const Memory needs = memory_of(scene);
    const double particles = expected_particles(scene), bytes = needs.all();
    const bool surface = needs.surface > max(needs.clay, needs.nodes);
    if (particles > max_particles)
        throw MemoryError(
            fmt::format("{}: /objects: expected at most {:.3g} particles, found {:.4g}", scene.path,
                        max_particles, particles));
    if (bytes > double(memory))
        throw MemoryError(fmt::format(
            "{}: {:.4g} particles on {} x {} x {} nodes and their surface need about {:.1f} MiB, "
            "and {:.1f} MiB are free: {}",
            scene.path, particles, scene.setup.lattice.size.x, scene.setup.lattice.size.y,
            scene.setup.lattice.size.z, bytes / 0x1p20, double(memory) / 0x1p20,
            surface ? "fewer nodes of the surface (/surface/nodes)"
                    : "fewer cells (/domain/cells) or particles per cell (/objects/*/per_cell)"));
}

// True if an earlier object contains x.
bool taken(const Scene& scene, std::size_t index, Vec3<double> x)
{
    for (std::size_t k = 0; k < index; ++k)
        if (inside(scene.objects[k], x)) return true;
    return false;
}

[[noreturn]] void refuse_empty(const Scene& scene, std::size_t index, double spacing)
{
    throw InputError(
        fmt::format("{}: expected an object that holds particles, found none in it: "
                    "smaller than a cell's {:.3g} m, or inside an earlier object",
                    place(scene, index), spacing));
}

// Adds the particles that were loaded with the object.
void put_object(Scene& scene, std::size_t index)
{
    Object& o = scene.objects[index];
    Setup& setup = scene.setup;
    if (!o.given) throw std::logic_error(place(scene, index) + ": its splats are not loaded");
    o.material.volume = o.given->volume;
    o.material.mass = o.material.density * o.material.volume;
    if (o.local()) return setup.materials.push_back(o.material);  // particles: added near hands
    const std::size_t before = setup.particles.size();
    for (const Vec3<double>& p : o.given->particles)
        if (!taken(scene, index, p))
            setup.particles.push_back({p, o.velocity, {}, {}, 0, int(index), 0});
    if (setup.particles.size() == before) refuse_empty(scene, index, std::cbrt(o.given->volume));
    for (const Vec3<double>& x : o.given->splats)
        setup.gaussians.push_back(gaussian_at(x, int(index)));
    setup.materials.push_back(o.material);
}

// Depths of objects for filling one of them with particles that are h apart. Those of meshes are
// taken from a lattice.
class Depths {
  public:
    Depths(const Scene& of, std::size_t last, double h) : scene(of), lattices(last + 1)
    {
        for (std::size_t k = 0; k <= last; ++k) {
            const Object& o = of.objects[k];
            if (o.shape != ShapeKind::mesh || !o.solid) continue;
            const double unit = mesh_extent(o);
            lattices[k] = std::make_unique<DepthLattice>(*o.solid, o.mesh.hollow / unit,
                                                         0.5 * h / unit, 1.25 * h / unit);
        }
    }
    double operator()(std::size_t k, Vec3<double> x) const
    {
        const Object& o = scene.objects[k];
        if (!lattices[k]) return depth(o, x);
        const double unit = mesh_extent(o);
        const Vec3<double> d = rotate(conjugate(o.rotation), x - o.centre);
        return unit * lattices[k]->depth((1 / unit) * d);
    }

  private:
    const Scene& scene;
    std::vector<std::unique_ptr<DepthLattice>> lattices;
};

// Depth of a point in the space that an object fills, bounded by the walls and by earlier objects
// [m].
double room(const Scene& scene, const Depths& depths, std::size_t index, Vec3<double> x)
{
    const Vec3<double> low = x - scene.setup.walls.min, high = scene.setup.walls.max - x;
    double d = min(min(min(low.x, low.y), min(low.z, high.x)), min(high.y, high.z));
    d = min(d, depths(index, x));
    for (std::size_t k = 0; k < index; ++k) d = min(d, -depths(k, x));
    return d;
}

// The layers of a strand between the walls and outside earlier objects.
void lay_strand(Scene& scene, std::size_t index, double h)
{
    const Object& o = scene.objects[index];
    std::vector<Vec3<double>> places;
    try {
        places = laid(*o.strand, h);
    } catch (const std::invalid_argument& e) {
        throw InputError(place(scene, index) + ": " + e.what());
    }
    for (const Vec3<double>& p : places) {
        const Vec3<double> x = o.centre + rotate(o.rotation, p);
        if (between(scene.setup.walls, x, scene.setup.lattice.dx) && !taken(scene, index, x))
            scene.setup.particles.push_back({x, o.velocity, {}, {}, 0, int(index), 0});
    }
}

void seed_object(Scene& scene, std::size_t index)
{
    Object& o = scene.objects[index];
    Setup& setup = scene.setup;
    const double h = setup.lattice.dx / std::cbrt(o.per_cell);
    o.material.volume = h * h * h;
    o.material.mass = o.material.density * o.material.volume;
    const auto strata = [h](Vec3<double> x) {
        return Int3{int(std::floor(x.x / h)), int(std::floor(x.y / h)), int(std::floor(x.z / h))};
    };
    if (o.shape == ShapeKind::mesh && !o.solid)
        throw std::logic_error(place(scene, index) + ": its mesh is not loaded");
    const Box3<double> box = box_of(o);
    const Packing packing{h,     o.per_cell,      scene.seed,
                          index, strata(box.low), strata(box.high) + Int3{1, 1, 1}};
    const std::size_t before = setup.particles.size();
    if (o.shape == ShapeKind::strand) {
        lay_strand(scene, index, h);
        if (setup.particles.size() == before) refuse_empty(scene, index, h);
        setup.materials.push_back(o.material);
        return;
    }
    const Depths depths(scene, index, h);
    for (const Vec3<double>& p :
         packed(packing, [&](Vec3<double> x) { return room(scene, depths, index, x); }))
        setup.particles.push_back({p, o.velocity, {}, {}, 0, int(index), 0});
    if (setup.particles.size() == before) refuse_empty(scene, index, h);
    setup.materials.push_back(o.material);
}

void add_tool(HandTools& to, const HandsOptions& hands, Side side)
{
    const std::string& name = hands.held[side];
    const Rig rig = name.empty() ? hand_rig(hands.topology, side) : tool_rig(name, side);
    const int base = int(to.rig.spheres.size()), tool = int(to.tools.size());
    const auto zoom = float(hands.zoom);
    for (const Binding<float>& b : rig.spheres)
        to.rig.spheres.push_back(stretched(b, {zoom, zoom}));
    for (Primitive p : rig.primitives) {
        for (int& s : p.sphere) s += base;
        p.tool = tool;
        to.rig.primitives.push_back(p);
    }
    const bool blade = name == "knife" || name == "scissors";
    to.tools.push_back({hands.mode, hands.friction, blade, true});
}

}  // namespace

double expected_particles(const Scene& scene)
{
    const double dx = scene.setup.lattice.dx;
    double count = 0;
    for (const Object& o : scene.objects) count += shape_volume(o) / (dx * dx * dx) * o.per_cell;
    return count;
}

double expected_bytes(const Scene& scene) { return memory_of(scene).all(); }

HandTools hand_tools(const HandsOptions& hands)
{
    HandTools made;
    for (Side side : tool_sides(hands)) add_tool(made, hands, side);
    return made;
}

void build(Scene& scene, std::size_t memory)
{
    Setup& setup = scene.setup;
    setup.particles.clear(), setup.gaussians.clear(), setup.materials.clear();
    setup.tools.clear();
    setup.rig = {};
    check_memory(scene, memory);
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
        if (!scene.objects[i].local() && scene.objects[i].shape != ShapeKind::strand)
            check_between_walls(scene, i);
    setup.particles.reserve(std::size_t(expected_particles(scene) * 1.02) + 64);
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
        scene.objects[i].shape == ShapeKind::splats ? put_object(scene, i) : seed_object(scene, i);
    if (!scene.has_hands) return;
    HandTools made = hand_tools(scene.hands);
    setup.rig = std::move(made.rig), setup.tools = std::move(made.tools);
    if (setup.rig.primitives.size() > max_primitives)
        throw InputError(fmt::format("{}: /hands: expected at most {} primitives, found {}",
                                     scene.path, max_primitives, setup.rig.primitives.size()));
}

}  // namespace knead
