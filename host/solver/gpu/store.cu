// What the device holds of a scene: checked, converted to float, laid out for the kernels.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "host/solver/gpu/store.cuh"

namespace knead::gpu {
namespace {

void require(bool fact, const std::string& otherwise)
{
    if (!fact) throw std::invalid_argument("gpu: " + otherwise);
}

void check_particles(const Setup& s)
{
    const double rounding = 1e-6 * s.lattice.dx;
    const Vec3<double>&low = s.walls.min, &high = s.walls.max;
    const auto inside = [rounding](double x, double from, double to) {
        return x >= from - rounding && x <= to + rounding;
    };
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        const Particle<double>& q = s.particles[i];
        const std::string name = "particle " + std::to_string(i);
        require(inside(q.x.x, low.x, high.x) && inside(q.x.y, low.y, high.y) &&
                    inside(q.x.z, low.z, high.z),
                name + " lies outside of the walls");
        require(q.object >= 0 && q.object < int(s.materials.size()),
                name + " has no material " + std::to_string(q.object));
    }
}

void check_tools(const Setup& s)
{
    require(s.rig.primitives.size() <= std::size_t(max_primitives),
            std::to_string(s.rig.primitives.size()) + " primitives, at most " +
                std::to_string(max_primitives));
    require(s.tools.size() <= std::size_t(max_tools),
            std::to_string(s.tools.size()) + " tools, at most " + std::to_string(max_tools));
    for (const Primitive& p : s.rig.primitives) {
        require(p.count >= 1 && p.count <= 3, "a primitive has 1 to 3 spheres");
        require(p.tool >= 0 && p.tool < int(s.tools.size()), "a primitive without its tool");
        for (int sphere : p.sphere)
            require(sphere >= 0 && sphere < int(s.rig.spheres.size()),
                    "a primitive without its sphere");
    }
    require(s.rest.mode == RestMode::none || s.tools.size() <= std::size_t(max_boxes),
            "clay may be still with at most " + std::to_string(max_boxes) + " tools");
    for (const Binding<float>& b : s.rig.spheres)
        for (int j : b.joint)
            require(j >= 0 && j < max_joints, "a sphere without its joint, or one past the " +
                                                  std::to_string(max_joints) + "th");
}

void check(const Setup& s)
{
    const Int3 n = s.lattice.size;
    require(n.x > 0 && n.y > 0 && n.z > 0 && n.x % 4 == 0 && n.y % 4 == 0 && n.z % 4 == 0,
            "the lattice needs multiples of 4 nodes along each axis");
    require(double(n.x) * n.y * n.z < 2147483648.0, "the lattice has 2^31 nodes or more");
    require(s.lattice.dx > 0 && std::isfinite(s.lattice.dx), "the lattice needs a spacing > 0");
    const Walls<double> walls = walls_on<double>(s.lattice, s.walls);
    const auto fits = [](int first, int free, int size) {
        return first >= 3 && free > 0 && first + free <= size - 3;
    };
    require(fits(walls.first.x, walls.free.x, n.x) && fits(walls.first.y, walls.free.y, n.y) &&
                fits(walls.first.z, walls.free.z, n.z),
            "the walls need 2 nodes of the lattice beyond each, and room between them");
    require(!s.particles.empty() && s.particles.size() < 200000000,
            "1 to 2e8 particles, not " + std::to_string(s.particles.size()));
    require(!s.materials.empty(), "no material");
    for (const Material<double>& m : s.materials)
        require(m.density > 0 && m.mass > 0 && m.volume > 0 && sound_speed(m) > 0,
                "a material without density, mass, volume or stiffness");
    check_particles(s);
    check_tools(s);
}

Features features_of(const Setup& s)
{
    const bool tools = !s.rig.primitives.empty();
    const bool blades = tools && std::any_of(s.tools.begin(), s.tools.end(),
                                             [](const Tool<double>& t) { return t.blade; });
    Features n{tools, s.deterministic, blades, s.rest.mode != RestMode::none,
               PlasticityClass::elastic};
    for (const Material<double>& m : s.materials) {
        const bool plain =
            m.elasticity == Elasticity::neo_hookean &&
            (m.plasticity == Plasticity::none || m.plasticity == Plasticity::von_mises);
        if (!plain)
            n.plasticity = PlasticityClass::any;
        else if (m.plasticity == Plasticity::von_mises && n.plasticity == PlasticityClass::elastic)
            n.plasticity = PlasticityClass::plastic;
    }
    return n;
}

// The nodes around a scene's clay.
Lattice<float> box_of(const Setup& s, Room room)
{
    const Lattice<float> whole{s.lattice.size, float(s.lattice.dx)};
    Int3 low = whole.size, end{};
    for (const Particle<double>& q : s.particles) {
        const Int3 base = base_node(cast<float>(q.x), whole.spacing);
        low = {min(low.x, base.x), min(low.y, base.y), min(low.z, base.z)};
        end = {max(end.x, base.x + 3), max(end.y, base.y + 3), max(end.z, base.z + 3)};
    }
    return box_around(whole, low, end, room.spare);
}

// The largest power of two that keeps a sum of magnitude up to `bound` within 62 bits.
float fixed_scale(double bound) { return std::ldexp(1.0f, 61 - std::ilogb(bound)); }

}  // namespace

Store::Store(const Setup& setup, Room given) : room(given)
{
    check(setup);
    used = features_of(setup);
    all.lattice = box_of(setup, room);
    all.walls = walls_on<float>(setup.lattice, setup.walls);
    all.gravity = cast<float>(setup.gravity);
    all.limits = step_limits(setup);
    allocate(setup);
    upload(setup);

    double mass = 0;
    for (const Particle<double>& q : setup.particles)
        mass += setup.materials[std::size_t(q.object)].mass;
    // No speed that the lattice can carry at a hundredth of the longest stable substep is lost.
    const double speed = 100 * all.limits.sound / all.limits.courant;
    all.grid.mass_scale = fixed_scale(mass);
    all.grid.momentum_scale = fixed_scale(mass * speed);
    all.materials = {cast<float>(setup.materials[0]), materials.data(),
                     int(setup.materials.size())};
    all.grid.fields = used.blades ? 3 : 1;
    for (int side = 0; side < 2; ++side) {
        all.particles[side] = {rows.data() + std::size_t(side) * setup.particles.size(),
                               ids[side].data(), int(setup.particles.size())};
    }
    const int joints = joints_of(setup.rig);
    all.tools = {input.data()->joints,
                 input.data()->joints + joints,
                 joints,
                 bindings.data(),
                 {spheres[0].span(), spheres[1].span()},
                 {shapes[0].span(), shapes[1].span()},
                 amid.span(),
                 travel.data(),
                 {primitives.data(), int(primitives.size())},
                 {input.data()->tools, int(setup.tools.size())},
                 nullptr,
                 in_line.data(),
                 setup.grid_contact,
                 setup.passes};
    const Rest<double>& rest = setup.rest;
    all.rest = {{rest.mode, float(rest.speed), rest.frames, float(rest.push), float(rest.reach)},
                run_length(used)};
    all.rest.run_listed = run_listed.data(), all.rest.list = runs.data();
    all.clock = clocks.data();
    all.input = input.data();
    point();
}

void Store::allocate(const Setup& setup)
{
    const auto n = setup.particles.size();
    const std::size_t sort_bytes =
        sort_scratch_bytes(int(n), {setup.lattice.size, float(setup.lattice.dx)}, used);
    const std::size_t need = n * (row_places * sizeof(float4) + 2 * sizeof(int)) + sort_bytes +
                             NodeArrays::bytes_for(all.lattice, used);
    std::size_t unused = 0, total = 0;
    gpu::check(cudaMemGetInfo(&unused, &total), "memory");
    if (need > unused)
        throw std::runtime_error("gpu: the scene needs " + std::to_string(need >> 20) +
                                 " MiB, the device has " + std::to_string(unused >> 20) +
                                 " MiB free");
    for (DeviceArray<int>& each : ids) each = DeviceArray<int>(n);
    box = NodeArrays(all.lattice, used);
    rows = DeviceArray<float4>(row_places * n);
    scratch = DeviceArray<unsigned char>(sort_bytes);
    std::vector<Material<float>> cast_materials;
    for (const Material<double>& m : setup.materials) cast_materials.push_back(cast<float>(m));
    materials = DeviceArray<Material<float>>(cast_materials);
    bindings = DeviceArray<Binding<float>>(setup.rig.spheres);
    primitives = DeviceArray<Primitive>(setup.rig.primitives);
    for (int parity = 0; parity < 2; ++parity) {
        spheres[parity] = DeviceArray<Sphere<float>>(setup.rig.spheres.size());
        shapes[parity] = DeviceArray<Shape<float>>(setup.rig.primitives.size());
    }
    amid = DeviceArray<Shape<float>>(setup.rig.primitives.size());
    travel = DeviceArray<float>(setup.rig.primitives.size());
    if (used.rests) {
        const auto run_count = std::size_t(blocks_for(int(n), run_length(used)));
        run_listed = DeviceArray<unsigned>(run_count), runs = DeviceArray<int>(run_count);
    }
    if (used.tools) {
        std::vector<int> all_runs(std::size_t(blocks_for(int(n), run_length(used))));
        std::iota(all_runs.begin(), all_runs.end(), 0);
        in_line = DeviceArray<int>(all_runs);
    }
    clocks = DeviceArray<Clock>(1);
    input = DeviceArray<FrameInput>(1);
}

void Store::upload(const Setup& setup) const
{
    const std::size_t n = setup.particles.size();
    std::vector<float4> host_rows(particle_rows * n);
    std::vector<int> host_ids(n);
    std::iota(host_ids.begin(), host_ids.end(), 0);
    const ParticleView view{host_rows.data(), host_ids.data(), int(n)};
    Clock start{};
    float fastest = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const Particle<float> q = cast<float>(setup.particles[i]);
        view.store(int(i), q);
        fastest = std::max(fastest, dot(q.v, q.v));
    }
    gpu::check(cudaMemcpy(rows.data(), host_rows.data(), host_rows.size() * sizeof(float4),
                          cudaMemcpyDefault),
               "upload");
    gpu::check(cudaMemcpy(ids[0].data(), host_ids.data(), ids[0].bytes(), cudaMemcpyDefault),
               "upload");
    start.done = 6;  // of its rings, all places are behind it
    start.fastest[1] = std::bit_cast<unsigned>(fastest);
    start.drift = 1e30;
    set_clock(start);
}

bool Store::write_input(const Setup& setup, const Motion& motion, double duration, int slot)
{
    FrameInput& to = *next_input[slot].data();
    to.duration = duration, to.tool_step = 1e30;
    if (!used.tools) return false;
    to.tool_step = tool_step(setup, motion, duration);
    const int joints = all.tools.joints;
    std::copy_n(motion.from.begin(), joints, to.joints);
    std::copy_n(motion.to.begin(), joints, to.joints + joints);
    bool any = false;
    for (std::size_t t = 0; t < setup.tools.size(); ++t) {
        const Tool<double>& tool = setup.tools[t];
        const bool active = t >= motion.active.size() || motion.active[t];
        to.tools[t] = {tool.mode, float(tool.friction), tool.blade, active};
        any = any || active;
    }
    return any;
}

void Store::send_input(int slot, cudaStream_t stream) const
{
    const std::size_t joints = std::size_t(all.tools.joints);
    const std::size_t bytes =
        used.tools ? offsetof(FrameInput, joints) + 2 * joints * sizeof(Joint<double>)
                   : offsetof(FrameInput, tools);
    gpu::check(cudaMemcpyAsync(input.data(), next_input[slot].data(), bytes, cudaMemcpyHostToDevice,
                               stream),
               "send orders");
}

std::vector<float4> Store::rows_on(int side) const
{
    std::vector<float4> to(particle_rows * ids[side].size());
    gpu::check(cudaMemcpy(to.data(), all.particles[side].rows, to.size() * sizeof to[0],
                          cudaMemcpyDefault),
               "download");
    return to;
}

std::vector<float> Store::depths(cudaStream_t stream) const
{
    const int side = clock(stream).side;
    std::vector<float> to(ids[side].size());
    gpu::check(cudaMemcpy(to.data(), free_row(all.particles, side), to.size() * sizeof to[0],
                          cudaMemcpyDefault),
               "depths");
    return to;
}

std::vector<Particle<double>> Store::particles() const
{
    const int side = clock().side;
    std::vector<float4> host_rows = rows_on(side);
    std::vector<int> host_ids = ids[side].downloaded();
    const ParticleView view{host_rows.data(), host_ids.data(), int(host_ids.size())};
    std::vector<Particle<double>> out(host_ids.size());
    for (int i = 0; i < view.count; ++i) {
        Particle<float> q = view.load(i);
        q.hold(false);
        out[std::size_t(view.ids[i])] = cast<double>(q);
    }
    return out;
}

void Store::set_sides(const std::vector<Particle<double>>& q) const
{
    const int side = clock().side;
    const std::vector<int> host_ids = ids[side].downloaded();
    std::vector<float4> host_rows = rows_on(side);
    const ParticleView view{host_rows.data(), nullptr, int(host_ids.size())};
    for (int i = 0; i < view.count; ++i)
        view.set_sides(i, q[std::size_t(host_ids[std::size_t(i)])].sides);
    gpu::check(cudaMemcpy(all.particles[side].rows, host_rows.data(),
                          host_rows.size() * sizeof(float4), cudaMemcpyDefault),
               "labels");
    gpu::check(cudaDeviceSynchronize(), "labels");
}

Saved Store::resume() const
{
    const int side = clock().side;
    return {side, rows_on(side), ids[side].downloaded(), box.quiet.downloaded()};
}

void Store::put_back(const Saved& resume) const
{
    const auto send = [](auto* to, const auto& from) {
        if (!from.empty())
            gpu::check(cudaMemcpy(to, from.data(), from.size() * sizeof from[0], cudaMemcpyDefault),
                       "put back");
    };
    send(all.particles[resume.side].rows, resume.rows);
    send(ids[resume.side].data(), resume.ids), send(box.quiet.data(), resume.quiet);
    gpu::check(cudaDeviceSynchronize(), "put back");
}

void Store::clear_grids() const
{
    const auto clear = [](const auto& array) {
        if (array.size()) gpu::check(cudaMemset(array.data(), 0, array.bytes()), "clear");
    };
    for (int parity = 0; parity < 2; ++parity) clear(box.nodes[parity]), clear(box.sums[parity]);
    clear(box.marks);
    gpu::check(cudaDeviceSynchronize(), "clear");
}

void Store::set_clock(const Clock& clock) const
{
    gpu::check(cudaMemcpy(clocks.data(), &clock, sizeof clock, cudaMemcpyDefault), "clock");
    gpu::check(cudaDeviceSynchronize(), "clock");  // streams do not wait for the copy by themselves
}

Clock Store::clock(cudaStream_t stream) const
{
    wait(stream, "clock");
    return clocks.downloaded()[0];
}

std::size_t Store::bytes() const
{
    std::size_t sum = materials.bytes() + bindings.bytes() + primitives.bytes() + amid.bytes() +
                      travel.bytes() + in_line.bytes() + clocks.bytes() + input.bytes() +
                      scratch.bytes() + rows.bytes() + runs.bytes() + run_listed.bytes() +
                      box.bytes();
    for (int s = 0; s < 2; ++s) sum += spheres[s].bytes() + shapes[s].bytes() + ids[s].bytes();
    return sum;
}

}  // namespace knead::gpu
