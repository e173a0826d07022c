#include "host/solver/edits.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <concepts>
#include <numeric>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "cuda/mpm/material.h"
#include "host/base/parallel.h"
#include "host/solver/bodies.h"
#include "host/solver/material_spec.h"
#include "host/solver/piece_count.h"

namespace knead {
namespace {

// Many are called per particle: a message is made only where it is needed.
void require(bool fact, const char* otherwise)
{
    if (!fact) throw std::invalid_argument(otherwise);
}
template <class Message>
requires std::invocable<Message>
void require(bool fact, Message&& otherwise)
{
    if (!fact) throw std::invalid_argument(otherwise());
}

bool finite(Vec3<double> v) { return std::isfinite(v.x + v.y + v.z); }
bool finite(const Particle<double>& p)
{
    return finite(p.x) && finite(p.v) && finite(p.C.a) && finite(p.C.b) && finite(p.C.c) &&
           std::isfinite(trace(p.e) + p.e.xy + p.e.xz + p.e.yz + p.k);
}

bool finite(const Gaussian<double>& g)
{
    return finite(g.x) && finite(g.F.a) && finite(g.F.b) && finite(g.F.c);
}
constexpr const char* not_finite = "a Gaussian with a number that is not finite";
constexpr const char* not_finite_clay = "a particle with a number that is not finite";
constexpr const char* needed =
    "a material needs a density, a mass, a volume and a stiffness above 0";
constexpr long most_particles = 200000000;
constexpr const char* too_many = "more than 2e8 particles";

// The first index for which holds() is false; `count` if there is none. Parallel, to keep edits
// short in VR: 500 000 places take 15 ms on one core. `work`: total number of places.
template <class Holds>
long first_failing(std::size_t count, std::size_t work, Holds&& holds)
{
    std::atomic<std::int64_t> first = std::int64_t(count);
    const LoopOptions options{.threads = work > 4096 ? 0 : 1};
    parallel_parts(std::int64_t(count), options, [&](std::int64_t from, std::int64_t to, int) {
        for (std::int64_t i = from; i < to && i < first; ++i) {
            if (holds(std::size_t(i))) continue;
            std::int64_t known = first;
            while (i < known && !first.compare_exchange_weak(known, i)) {
            }
        }
    });
    return first;
}

void check_material(const Material<double>& m)
{
    require(m.density > 0 && m.mass > 0 && m.volume > 0 && sound_speed(m) > 0, needed);
    if (const auto fault = fault_of(stated(m))) throw std::invalid_argument(fault->text());
    check_materials({m});
}

// A material with particles of another volume.
Material<double> of_volume(Material<double> m, double volume)
{
    m.volume = volume, m.mass = m.density * volume;
    return m;
}

}  // namespace

std::vector<int> EditableSimulator::piece_counts(std::span<const int> group, int groups) const
{
    return knead::piece_counts(particles(), config().lattice, config().materials, group, groups);
}

SomeGaussians EditableSimulator::gaussians_of(const Snapshot& snapshot,
                                              std::span<const int> objects) const
{
    SomeGaussians some;
    std::vector<int> wanted(objects.begin(), objects.end());
    std::sort(wanted.begin(), wanted.end());
    const std::vector<Gaussian<double>> all = held(snapshot).gaussians;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (!std::binary_search(wanted.begin(), wanted.end(), all[i].object)) continue;
        some.indices.push_back(int(i)), some.gaussians.push_back(all[i]);
    }
    return some;
}

std::vector<Vec3<double>> Simulator::places(const Box3<double>& box) const
{
    std::vector<Vec3<double>> inside;
    for (const Particle<double>& p : particles())
        if (contains(box, p.x)) inside.push_back(p.x);
    return inside;
}

void check_materials(const std::vector<Material<double>>& materials)
{
    for (const Material<double>& m : materials) {
        const double sum = m.density + m.mu + m.lambda + m.bulk + m.yield + m.hardening +
                           m.yield_floor + m.friction + m.cohesion + m.compress + m.stretch +
                           m.snow + m.viscosity + m.exponent + m.mass + m.volume;
        require(std::isfinite(sum), "a material's constants are finite numbers");
        require(go_together(m.elasticity, m.plasticity),
                "a plasticity with a yield surface needs neo-Hookean or Hencky elasticity (fixed "
                "corotated softens where it is pressed below half its length)");
        require(m.plasticity != Plasticity::clamp || packing_gives_up_energy(m.compress, m.snow),
                "snow whose `compress` and `snow` keep 1.5 compress (snow + 3) below 1, or packing "
                "it makes energy");
    }
}

SceneState::SceneState(const SimulationConfig& config, const InitialState& contents)
    : now(config), counts(config.materials.size(), 0)
{
    check_materials(config.materials);
    check_rig(config.rig, config.tools);
    for (const Particle<double>& p : contents.particles) {
        require(p.object >= 0 && p.object < int(counts.size()), [&] {
            return fmt::format("a particle of object {}, which has no material", p.object);
        });
        ++counts[std::size_t(p.object)];
        now.cuts = now.cuts || p.label() != 0;
    }
    for (const Tool<double>& tool : now.tools) now.cuts = now.cuts || tool.blade;
    for (const Gaussian<double>& g : contents.gaussians) now.cuts = now.cuts || g.label() != 0;
    bodies_of(now);
    check_gaussians(contents.gaussians);
}

SceneState::SceneState(const SavedState& state) : SceneState(state.config, state.contents)
{
    const long places = long(bodies_of(now).fields()) * sliding_places(now.lattice.size, now.walls);
    for (const SlidingNode& n : state.sliding) now.cuts = now.cuts || n.place >= places;
}

long SceneState::count() const { return std::accumulate(counts.begin(), counts.end(), 0l); }

double SceneState::mass() const
{
    double sum = 0;
    for (std::size_t i = 0; i < counts.size(); ++i)
        sum += double(counts[i]) * now.materials[i].mass;
    return sum;
}

std::vector<AddedPiece> pieces_of(Clays clays)
{
    constexpr std::size_t piece = 1024;
    std::vector<AddedPiece> pieces;
    std::size_t first = 0;
    for (std::size_t k = 0; k < clays.size(); ++k)
        for (std::span<const Particle<double>> left = clays[k]; !left.empty();) {
            pieces.push_back({k, left.first(std::min(left.size(), piece)), first});
            first += pieces.back().of.size(), left = left.subspan(pieces.back().of.size());
        }
    return pieces;
}

// The scene without clay, and with the materials, gravity, walls, contact of bodies and
// cuts of `config`.
SceneState SceneState::emptied(const SimulationConfig& config) const
{
    const auto step = [](const StepOptions& s) {
        return std::tuple{s.fixed, s.courant, s.tool, s.largest};
    };
    const auto rest = [](const Rest<double>& r) {
        return std::tuple{r.mode, r.speed, r.frames, r.push, r.reach};
    };
    require(config.lattice.size == now.lattice.size && config.lattice.dx == now.lattice.dx,
            "the scene has another lattice than the simulator");
    require(step(config.step) == step(now.step) && rest(config.rest) == rest(now.rest) &&
                config.grid_contact == now.grid_contact && config.passes == now.passes,
            "the scene has other options of substeps, rest or contact than the simulator");
    SceneState next = *this;
    for (const Material<double>& m : config.materials) {
        const bool removed = m == Material<double>{};
        require(removed || (m.density > 0 && m.mass > 0 && m.volume > 0 && sound_speed(m) > 0),
                needed);
    }
    check_materials(config.materials);
    next.now.materials = config.materials;
    next.counts.assign(config.materials.size(), 0);
    next.set_gravity(config.gravity);
    next.set_walls(config.walls);
    next.now.contact = config.contact;
    next.now.cuts = config.cuts;
    for (const Tool<double>& tool : now.tools) next.now.cuts = next.now.cuts || tool.blade;
    bodies_of(next.now);
    return next;
}

// Checks and counts the particles; particle(i) returns each.
template <class At>
void SceneState::fill(std::size_t count, At&& particle)
{
    require(long(count) < most_particles, too_many);
    const long bad = first_failing(count, count, [&](std::size_t i) {
        const Particle<double> p = particle(i);
        return known(p.object) && finite(p) && p.sides <= below &&
               between(now.walls, p.x, now.lattice.dx);
    });
    if (bad < long(count)) {
        const Particle<double> p = particle(std::size_t(bad));
        check_object(p.object);
        require(finite(p), not_finite_clay);
        require(p.sides <= below, "a particle with an invalid label");
        check_place(p.x);
    }
    for (std::size_t i = 0; i < count; ++i) {
        const Particle<double> p = particle(i);
        ++counts[std::size_t(p.object)];
        now.cuts = now.cuts || p.label() != 0;
    }
    bodies_of(now);
}

SceneState SceneState::replaced(const SimulationConfig& config, const ClayRows& clay) const
{
    const std::size_t n = clay.count;
    require(
        clay.planes.size() == clay_planes * n && clay.object.size() == n && clay.sides.size() == n,
        [&] {
            return fmt::format(
                "clay of {0} particles: expected {1} numbers, {0} objects and {0} labels, not "
                "{2}, {3} and {4}",
                n, clay_planes * n, clay.planes.size(), clay.object.size(), clay.sides.size());
        });
    SceneState next = emptied(config);
    next.fill(n, [&](std::size_t i) { return cast<double>(particle_at(clay, i)); });
    next.check_gaussians(clay.gaussians);
    return next;
}

SceneState SceneState::replaced(const SimulationConfig& config, const InitialState& contents) const
{
    SceneState next = emptied(config);
    const std::vector<Particle<double>>& clay = contents.particles;
    next.fill(clay.size(), [&](std::size_t i) -> const Particle<double>& { return clay[i]; });
    next.check_gaussians(contents.gaussians);
    return next;
}

bool SceneState::same_rules(const SceneState& replacement) const
{
    const SimulationConfig& next = replacement.now;
    const auto same = [](Vec3<double> a, Vec3<double> b) {
        return a.x == b.x && a.y == b.y && a.z == b.z;
    };
    const WallOptions &a = now.walls, &b = next.walls;
    return counts == replacement.counts && now.materials == next.materials &&
           now.contact == next.contact && now.cuts == next.cuts &&
           same(now.gravity, next.gravity) && same(a.min, b.min) && same(a.max, b.max) &&
           a.mode == b.mode && a.friction == b.friction;
}

// Throws std::invalid_argument if bodies would be impossible after a change of the configuration.
template <class Change>
void SceneState::check_with(Change&& change) const
{
    if (!now.contact.separate) return;
    SimulationConfig next = now;
    change(next);
    bodies_of(next);
}

std::vector<int> SceneState::add_each(const Material<double>& material, Clays clays)
{
    check_material(material);
    long sum = count();
    long added = 0;
    for (const std::vector<Particle<double>>& clay : clays) added += long(clay.size());
    const auto fits = [&](const Particle<double>& p) {
        return finite(p) && between(now.walls, p.x, now.lattice.dx);
    };
    const std::vector<AddedPiece> pieces = pieces_of(clays);
    const long bad = first_failing(pieces.size(), std::size_t(added), [&](std::size_t k) {
        return std::all_of(pieces[k].of.begin(), pieces[k].of.end(), fits);
    });
    if (bad < long(pieces.size())) {
        const auto& of = pieces[std::size_t(bad)].of;
        const Particle<double>& p = *std::find_if_not(of.begin(), of.end(), fits);
        require(finite(p), not_finite_clay);
        check_place(p.x);
    }
    sum += added;
    require(sum < most_particles, too_many);
    check_with([&](SimulationConfig& next) { next.materials.push_back(material); });
    std::vector<int> objects;
    for (const std::vector<Particle<double>>& clay : clays) {
        objects.push_back(int(counts.size()));
        now.materials.push_back(material);
        counts.push_back(long(clay.size()));
    }
    return objects;
}

void SceneState::remove_each(std::span<const int> objects)
{
    std::vector<int> sorted(objects.begin(), objects.end());
    std::sort(sorted.begin(), sorted.end());
    require(std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end(),
            "an object is removed twice");
    for (const int object : objects) check_object(object);
    for (const int object : objects) {
        now.materials[std::size_t(object)] = {};
        counts[std::size_t(object)] = 0;
    }
}

bool SceneState::changes_category_only(int object, const Material<double>& material) const
{
    if (!known(object) || now.contact.separate) return false;
    const Material<double>& old = now.materials[std::size_t(object)];
    Material<double> next = of_volume(material, old.volume);
    return std::exchange(next.category, old.category) != old.category && next == old;
}

Plasticity SceneState::set_material(int object, const Material<double>& material)
{
    check_object(object);
    Material<double>& old = now.materials[std::size_t(object)];
    const Material<double> next = of_volume(material, old.volume);
    check_material(next);
    check_with([&](SimulationConfig& to) { to.materials[std::size_t(object)] = next; });
    const Plasticity law = old.plasticity;
    old = next;
    return law;
}

void SceneState::set_gravity(Vec3<double> gravity)
{
    require(finite(gravity), "gravity must be finite");
    require(
        std::max({std::abs(gravity.x), std::abs(gravity.y), std::abs(gravity.z)}) <= most_gravity,
        [] {
            return fmt::format("gravity: expected {:g} m/s^2 at most along each axis",
                               most_gravity);
        });
    now.gravity = gravity;
}

void SceneState::set_walls(const WallOptions& walls)
{
    require(has_room(now.lattice, walls),
            "the walls need 2 nodes of the lattice beyond each, and room between them");
    now.walls = walls;
}

void SceneState::set_contact(const BodyContact& contact)
{
    require(contact.friction >= 0 && contact.friction <= most_body_friction, [] {
        return fmt::format("friction of bodies: expected 0 to {:g}", most_body_friction);
    });
    SimulationConfig next = now;
    next.contact = contact;
    bodies_of(next);
    now.contact = contact;
}

void check_rig(const Rig& rig, const std::vector<Tool<double>>& tools)
{
    require(rig.primitives.size() <= std::size_t(max_primitives), [&] {
        return fmt::format("{} primitives, at most {}", rig.primitives.size(), max_primitives);
    });
    for (const Primitive& p : rig.primitives) {
        require(p.count >= 1 && p.count <= 3, "a primitive has 1 to 3 spheres");
        require(p.tool >= 0 && p.tool < int(tools.size()), "a primitive without its tool");
        for (int sphere : p.sphere)
            require(sphere >= 0 && sphere < int(rig.spheres.size()),
                    "a primitive without its sphere");
    }
    for (const Binding<float>& b : rig.spheres)
        for (int joint : b.joint) require(joint >= 0, "a sphere without its joint");
}

void SceneState::set_tools(const Rig& rig, const std::vector<Tool<double>>& tools)
{
    check_rig(rig, tools);
    check_with([&](SimulationConfig& next) { next.tools = tools; });
    now.rig = rig, now.tools = tools;
    for (const Tool<double>& tool : tools) now.cuts = now.cuts || tool.blade;
}

void SceneState::check_attach(int object, const std::vector<Vec3<double>>& places) const
{
    check_object(object);
    for (const Vec3<double>& x : places) {
        require(finite(x), not_finite);
        check_place(x, "a Gaussian");
    }
}

void check_edits(const GaussianEdits& edits, std::size_t gaussians, std::size_t particles)
{
    std::vector<char> is_split(gaussians, 0);
    for (const GaussianSplit& split : edits.splits) {
        require(split.index >= 0 && std::size_t(split.index) < gaussians,
                [&] { return fmt::format("there is no Gaussian {}", split.index); });
        require(!is_split[std::size_t(split.index)]++, "a Gaussian is split twice");
        require(finite(split.way), not_finite);
    }
    for (const GaussianBeside& added : edits.added) {
        require(added.particle >= 0 && std::size_t(added.particle) < particles,
                [&] { return fmt::format("there is no particle {}", added.particle); });
        require(finite(added.way), not_finite);
    }
}

template <class R>
void SceneState::check_gaussians(const std::vector<Gaussian<R>>& all) const
{
    const long bad = first_failing(all.size(), all.size(), [&](std::size_t i) {
        const Gaussian<double> g = cast<double>(all[i]);
        return known(g.object) && finite(g) && g.sides <= below &&
               between(now.walls, g.x, now.lattice.dx);
    });
    if (bad == long(all.size())) return;
    const Gaussian<double> g = cast<double>(all[std::size_t(bad)]);
    check_object(g.object);
    require(finite(g), not_finite);
    require(g.sides <= below, "a Gaussian with an invalid label");
    check_place(g.x, "a Gaussian");
}
template void SceneState::check_gaussians(const std::vector<Gaussian<float>>&) const;
template void SceneState::check_gaussians(const std::vector<Gaussian<double>>&) const;

void SceneState::check_placed(std::span<const GaussianPlace> places) const
{
    const long bad = first_failing(places.size(), places.size(), [&](std::size_t i) {
        return known(places[i].object) &&
               between(now.walls, cast<double>(places[i].x), now.lattice.dx);
    });
    if (bad == long(places.size())) return;
    const GaussianPlace& place = places[std::size_t(bad)];
    check_object(place.object);
    check_place(cast<double>(place.x), "a Gaussian");
}

bool SceneState::known(int object) const
{
    return object >= 0 && object < int(counts.size()) && there(now.materials[std::size_t(object)]);
}

void SceneState::check_object(int object) const
{
    if (known(object)) return;
    const bool was = object >= 0 && object < int(counts.size());
    throw std::invalid_argument((was ? "there is no longer an object " : "there is no object ") +
                                std::to_string(object));
}

void SceneState::check_motion(const RigidMotion<double>& m)
{
    const double norm = m.q.w * m.q.w + m.q.x * m.q.x + m.q.y * m.q.y + m.q.z * m.q.z;
    require(finite(m.p) && std::abs(norm - 1) < 1e-6,
            "a motion needs a finite shift and a unit quaternion");
}

void SceneState::check_place(Vec3<double> x, const char* what) const
{
    if (between(now.walls, x, now.lattice.dx)) return;  // fast path: called for every particle
    throw std::invalid_argument(what + std::string(" at (") + std::to_string(x.x) + ", " +
                                std::to_string(x.y) + ", " + std::to_string(x.z) +
                                ") m would lie behind a wall");
}

void check_state(const SavedState& state, const SimulationConfig& of)
{
    const SimulationConfig& s = state.config;
    const std::vector<Particle<double>>& particles = state.contents.particles;
    require(s.lattice.size == of.lattice.size && s.lattice.dx == of.lattice.dx,
            "the state is of another lattice");
    std::vector<char> seen(particles.size(), 0);
    for (int id : state.order) {
        const bool fresh = id >= 0 && std::size_t(id) < seen.size() && !seen[std::size_t(id)];
        require(fresh, "the state's order is not one of its particles");
        seen[std::size_t(id)] = 1;
    }
    require(state.order.size() == seen.size(), "the state's order leaves out particles");
    require(state.speed_squared >= 0 && std::isfinite(state.speed_squared) &&
                state.stiffness >= 0 && std::isfinite(state.stiffness),
            "the state's speed or stiffness is invalid");
    const SceneState rules(state);
    const Bodies bodies = bodies_of(rules.config());
    const int fields = bodies.colours > 0 ? bodies.fields() : rules.config().cuts ? 3 : 1;
    const long places = long(fields) * sliding_places(s.lattice.size, s.walls);
    for (const SlidingNode& n : state.sliding)
        require(n.place >= 0 && n.place < places && n.force >= 0 && std::isfinite(n.force) &&
                    n.time > 0 && std::isfinite(n.time) && std::isfinite(n.impulse_deficit),
                "the state has invalid friction data");
    for (const Particle<double>& p : particles) {
        if (!finite(p)) require(false, "the state has a particle with a number that is not finite");
        rules.check_object(p.object);
        rules.check_place(p.x);
    }
}

}  // namespace knead
