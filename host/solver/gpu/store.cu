// Device memory of a scene: validated, converted to float, laid out for the kernels.
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
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        const Particle<double>& q = s.particles[i];
        const std::string name = "particle " + std::to_string(i);
        require(between(s.walls, q.x, s.lattice.dx), name + " lies outside of the walls");
        require(q.object >= 0 && q.object < int(s.materials.size()),
                name + " has no material " + std::to_string(q.object));
    }
}

void check(const Setup& s)
{
    const Int3 n = s.lattice.size;
    require(n.x > 0 && n.y > 0 && n.z > 0 && n.x % 4 == 0 && n.y % 4 == 0 && n.z % 4 == 0,
            "the lattice needs multiples of 4 nodes along each axis");
    require(double(n.x) * n.y * n.z < 2147483648.0, "the lattice has 2^31 nodes or more");
    require(s.lattice.dx > 0 && std::isfinite(s.lattice.dx), "the lattice needs a spacing > 0");
    require(has_room(s.lattice, s.walls),
            "the walls need 2 nodes of the lattice beyond each, and room between them");
    require(s.particles.size() < 200000000,
            "at most 2e8 particles, not " + std::to_string(s.particles.size()));
    for (const Material<double>& m : s.materials)
        require(m.density > 0 && m.mass > 0 && m.volume > 0 && sound_speed(m) > 0,
                "a material without density, mass, volume or stiffness");
    check_particles(s);
    check_tools(s);
}

// Box of the nodes around the clay; without clay, a few of the lattice's lowest nodes.
Lattice<float> box_of(const std::vector<Particle<double>>& clay, const Lattice<float>& whole,
                      int spare)
{
    Int3 low{}, end{};
    if (!clay.empty()) low = whole.size;
    for (const Particle<double>& q : clay) {
        const Int3 base = base_node(cast<float>(q.x), whole.spacing);
        low = {min(low.x, base.x), min(low.y, base.y), min(low.z, base.z)};
        end = {max(end.x, base.x + 3), max(end.y, base.y + 3), max(end.z, base.z + 3)};
    }
    return box_around(whole, low, end, spare);
}

}  // namespace

void check_tools(const SimulationConfig& s)
{
    check_rig(s.rig, s.tools);
    require(s.tools.size() <= std::size_t(max_tools),
            std::to_string(s.tools.size()) + " tools, at most " + std::to_string(max_tools));
    require(s.rest.mode == RestMode::none || s.tools.size() <= std::size_t(max_boxes),
            "rest.mode supports at most " + std::to_string(max_boxes) + " tools");
    require(joints_of(s.rig) <= max_joints,
            std::to_string(joints_of(s.rig)) + " joints, at most " + std::to_string(max_joints));
}

Store::Store(const Setup& setup, RegionPadding given, int device)
    : room(given), pool(std::make_shared<Pool>(device))
{
    check(setup);
    const SceneState rules(setup);
    const auto n = int(setup.particles.size());
    const Lattice<float> whole{setup.lattice.size, float(setup.lattice.dx)};
    used = features_of(rules.config(), setup.deterministic);
    all.lattice = box_of(setup.particles, whole, room.spare);
    const std::size_t need = row_places(std::size_t(n)) * sizeof(float4) +
                             std::size_t(n) * 2 * sizeof(int) + sort_scratch_bytes(n, whole, used) +
                             NodeArrays::bytes_for(all.lattice, used);
    std::size_t unused = 0, total = 0;
    gpu::check(cudaMemGetInfo(&unused, &total), "memory");
    if (need > unused)
        throw std::runtime_error("gpu: the scene needs " + std::to_string(need >> 20) +
                                 " MiB, the device has " + std::to_string(unused >> 20) +
                                 " MiB free");
    box = NodeArrays(all.lattice, used);
    clocks = DeviceArray<Clock>(1), input = DeviceArray<FrameInput>(1);
    found = DeviceArray<Extent>(1);
    all.clock = clocks.data(), all.input = input.data();
    resize(n);
    set_rules(rules), set_tools(rules);
    point();
    std::vector<int> order(setup.particles.size());
    std::iota(order.begin(), order.end(), 0);
    upload(setup.particles, order);
    Clock start{};
    start.done = 6;  // so that all places of its rings lie in the past
    const Extent around = extent(every_object, {{1, 0, 0, 0}, {}}, 0, nullptr);
    start.set_peak(1, around.peak);
    start.drift = 1e30;
    set_clock(start);
}

bool Store::write_input(const SimulationConfig& config, const Motion& motion, double duration,
                        int bound, int slot)
{
    FrameInput& to = *next_input[slot].data();
    to.duration = duration, to.tool_step = 1e30, to.most_substeps = bound;
    if (!used.tools) return false;
    to.tool_step = tool_step(config, motion, duration);
    const int joints = all.tools.joints;
    std::copy_n(motion.from.begin(), joints, to.joints);
    std::copy_n(motion.to.begin(), joints, to.joints + joints);
    bool any = false;
    for (std::size_t t = 0; t < config.tools.size(); ++t) {
        const Tool<double>& tool = config.tools[t];
        to.tools[t] = {tool.mode, float(tool.friction), tool.blade, true};
        set_tool(to.tools[t], motion, t);
        any = any || to.tools[t].active;
    }
    return any;
}

void Store::send_input(int slot, cudaStream_t stream) const
{
    const auto joints = std::size_t(all.tools.joints);
    const std::size_t bytes =
        used.tools ? offsetof(FrameInput, joints) + 2 * joints * sizeof(Joint<double>)
                   : offsetof(FrameInput, tools);
    gpu::check(cudaMemcpyAsync(input.data(), next_input[slot].data(), bytes, cudaMemcpyHostToDevice,
                               stream),
               "send input");
}

std::vector<float4> Store::rows_on(int side) const
{
    std::vector<float4> to(particle_rows * std::size_t(count()));
    gpu::check(cudaMemcpy(to.data(), all.particles[side].rows, to.size() * sizeof to[0],
                          cudaMemcpyDefault),
               "download");
    return to;
}

std::vector<int> Store::order(int side) const
{
    const auto n = std::size_t(count());
    std::vector<int> to(n);
    if (!to.empty())
        gpu::check(
            cudaMemcpy(to.data(), ids[side].data(), to.size() * sizeof to[0], cudaMemcpyDefault),
            "download");
    return to;
}

namespace {

// Downloads what a kernel has written to the free row, one T per particle.
template <class T>
std::vector<T> left_in_free_row(const Store& store, cudaStream_t stream, const char* what)
{
    const int side = store.clock(stream).side;
    std::vector<T> to(std::size_t(store.count()));
    gpu::check(cudaMemcpy(to.data(), free_row(store.views().particles, side),
                          to.size() * sizeof to[0], cudaMemcpyDefault),
               what);
    return to;
}

}  // namespace

std::vector<float> Store::depths(cudaStream_t stream) const
{
    return left_in_free_row<float>(*this, stream, "depths");
}

std::vector<float4> Store::velocities(cudaStream_t stream) const
{
    return left_in_free_row<float4>(*this, stream, "velocities");
}

std::vector<Particle<double>> in_double(const ParticleView& on_host)
{
    std::vector<Particle<double>> out(static_cast<std::size_t>(on_host.count));
    for (int i = 0; i < on_host.count; ++i) {
        Particle<float> q = on_host.load(i);
        q.hold(false);
        out[std::size_t(on_host.ids[i])] = cast<double>(q);
    }
    return out;
}

std::vector<Particle<double>> Store::particles() const
{
    const int side = clock().side;
    std::vector<float4> host_rows = rows_on(side);
    std::vector<int> host_ids = order(side);
    return in_double({host_rows.data(), host_ids.data(), int(host_ids.size())});
}

// Downloads only the first of the six rows of each particle.
std::vector<Vec3<double>> Store::places_in(const Box3<double>& within) const
{
    std::vector<float4> first(static_cast<std::size_t>(count()));
    if (!first.empty())
        check(cudaMemcpy(first.data(), all.particles[clock().side].rows,
                         first.size() * sizeof first[0], cudaMemcpyDefault),
              "particles");
    std::vector<Vec3<double>> inside;
    for (const float4& row : first) {
        const Vec3<double> x = cast<double>(Vec3<float>{row.x, row.y, row.z});
        if (contains(within, x)) inside.push_back(x);
    }
    return inside;
}

void Store::set_sides(const std::vector<Particle<double>>& q) const
{
    const int side = clock().side;
    const std::vector<int> host_ids = order(side);
    std::vector<float4> host_rows = rows_on(side);
    const ParticleView view{host_rows.data(), nullptr, int(host_ids.size())};
    for (int i = 0; i < view.count; ++i)
        view.set_sides(i, q[std::size_t(host_ids[std::size_t(i)])].sides);
    gpu::upload(all.particles[side].rows, host_rows.data(), host_rows.size());
}

void Store::clear_grids() const
{
    const auto clear = [](const auto& array) {
        if (array.size()) gpu::check(cudaMemset(array.data(), 0, array.bytes()), "clear");
    };
    for (int parity = 0; parity < 2; ++parity) clear(box.nodes[parity]), clear(box.sums[parity]);
    clear(box.marks);
    settle("clear");
}

void Store::set_clock(const Clock& clock) const { gpu::upload(clocks.data(), &clock, 1); }

Clock Store::clock(cudaStream_t stream) const
{
    wait(stream, "clock");
    return clocks.downloaded()[0];
}

std::size_t Store::bytes() const
{
    std::size_t sum = materials.bytes() + bindings.bytes() + primitives.bytes() +
                      mid_frame.bytes() + travel.bytes() + in_line.bytes() + near_runs.bytes() +
                      sliding.bytes() + clocks.bytes() + input.bytes() + scratch.bytes() +
                      rows.bytes() + runs.bytes() + run_listed.bytes() + box.bytes() +
                      other_rows.bytes() + other_ids.bytes() + places.bytes() + gone.bytes();
    for (int s = 0; s < 2; ++s) sum += spheres[s].bytes() + shapes[s].bytes() + ids[s].bytes();
    return sum;
}

}  // namespace knead::gpu
