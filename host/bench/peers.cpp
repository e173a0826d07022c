// Other implementations on the same scene: each is a separate program that reads the scene from a
// file and prints as its last line, in JSON, its time per substep and the final distribution of the
// clay.
#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/base/child.h"
#include "host/base/errors.h"
#include "host/base/outputs.h"
#include "host/bench/ball.h"
#include "host/bench/bench.h"

namespace knead {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr int peer_substeps = 5;
constexpr double dt = 1e-4, peer_frame = peer_substeps * dt;  // [s]

// Both cones close on the ball at 1 m/s from just outside without rotating, so that peers need no
// surface velocity from a tool's spin.
Motion upright(double from, double to)
{
    const auto at = [](double time) { return wrists(0.31 - time, 0); };
    return {at(from), at(to), {1, 1}};
}

Setup peer_scene(const Bench& bench, int nodes)
{
    Setup s = ball(nodes);
    add_tools(s);
    s.step.fixed = dt;
    s.threads = bench.options.threads;
    s.passes = 1;  // as in the paper's algorithm
    return s;
}

// The cones' spheres at the end of every frame, in the peers' format: per frame and sphere x y z r
// [m].
Json posed_spheres(const Setup& setup, int count)
{
    Json all = Json::array();
    for (int f = 0; f <= count; ++f) {
        const Motion motion = upright(f * peer_frame, f * peer_frame);
        Json now = Json::array();
        for (const Binding<float>& b : setup.rig.spheres) {
            Binding<double> wide{};
            for (int k = 0; k < 4; ++k) {
                wide.joint[k] = b.joint[k], wide.weight[k] = double(b.weight[k]);
                wide.offset[k] = cast<double>(b.offset[k]);
            }
            const Vec3<double> c = centre(wide, [&](int j) { return motion.from[std::size_t(j)]; });
            now.push_back({c.x, c.y, c.z, b.radius});
        }
        all.push_back(now);
    }
    return all;
}

Json described(const Setup& setup, const PeerOptions& options)
{
    const Material<double>& m = setup.materials[0];
    Json cones = Json::array(), contact_mode = Json::array();
    for (const Primitive& p : setup.rig.primitives) {
        const Tool<double>& tool = setup.tools[std::size_t(p.tool)];
        cones.push_back({p.sphere[0], p.sphere[1]});
        contact_mode.push_back(
            {{"sticky", tool.mode == ContactMode::sticky}, {"friction", tool.friction}});
    }
    return {{"nodes", options.nodes},
            {"dx", setup.lattice.dx},
            {"dt", dt},
            {"substeps", peer_substeps},
            {"frames", options.frames},
            {"warm_frames", options.warm_frames},
            {"gravity", {setup.gravity.x, setup.gravity.y, setup.gravity.z}},
            {"margin", walls_on<double>(setup.lattice, setup.walls).first.x - 1},
            {"wall_friction", setup.walls.friction},
            {"mu", m.mu},
            {"lambda", m.lambda},
            {"yield", m.yield},
            {"mass", m.mass},
            {"volume", m.volume},
            {"particles", setup.particles.size()},
            {"cones", cones},
            {"contact_mode", contact_mode},
            {"spheres", posed_spheres(setup, options.frames)}};
}

// x y z of every particle, as native floats.
std::string raw_positions(const Setup& setup)
{
    std::string bytes(setup.particles.size() * 12, '\0');
    for (std::size_t i = 0; i < setup.particles.size(); ++i) {
        const Vec3<float> x = cast<float>(setup.particles[i].x);
        const float each[] = {x.x, x.y, x.z};
        std::memcpy(&bytes[12 * i], each, sizeof each);
    }
    return bytes;
}

ProbePlaces places_of(const std::vector<Particle<double>>& all)
{
    ProbePlaces p{};
    const double share = 1 / double(all.size());
    for (const Particle<double>& q : all) {
        const double x[] = {q.x.x, q.x.y, q.x.z};
        for (std::size_t k = 0; k < 3; ++k) p[k] += share * x[k];
    }
    for (const Particle<double>& q : all) {
        const double x[] = {q.x.x, q.x.y, q.x.z};
        for (std::size_t k = 0; k < 3; ++k) p[3 + k] += share * (x[k] - p[k]) * (x[k] - p[k]);
    }
    for (std::size_t k = 3; k < 6; ++k) p[k] = std::sqrt(p[k]);
    return p;
}

struct Ours {
    double substep = 0;
    ProbePlaces places{};
};

Ours ours(const Bench& bench, const Setup& setup, const PeerOptions& peers)
{
    const std::unique_ptr<Simulator> solver = make_solver(setup, bench.device);
    SessionLoopOptions options;
    options.duration = peer_frame, options.hand_rate = 1 / peer_frame,
    options.frames = peers.frames;
    options.interrupted = [&] { return bench.stopped(); };
    SessionLoop loop(*solver, upright, options);
    std::vector<double> times;
    loop.observe([&](const FrameResult& f) {
        if (f.number > peers.warm_frames)
            times.push_back(f.times.solver / std::max(1, f.stats.substeps));
    });
    loop.run();
    if (loop.failure()) std::rethrow_exception(loop.failure());
    return {spread(times).median, places_of(*loop.particles())};
}

// Reads three numbers under a key; false if missing.
bool three(const Json& said, const char* key, double* to)
{
    if (!said.contains(key) || !said[key].is_array() || said[key].size() != 3) return false;
    for (std::size_t k = 0; k < 3; ++k) {
        if (!said[key][k].is_number()) return false;
        to[k] = said[key][k].get<double>();
    }
    return true;
}

}  // namespace

bool understood(const std::string& said, PeerRow& row, ProbePlaces& places)
{
    for (std::size_t end = said.size(); end > 0;) {
        const std::size_t start = said.find_last_of('\n', end - 1) + 1;
        const Json line = Json::parse(said.substr(start, end - start), nullptr, false);
        end = start > 0 ? start - 1 : 0;
        if (!line.is_object() || !line.contains("substep_us")) continue;
        if (!line["substep_us"].is_number() || !(line["substep_us"].get<double>() > 0) ||
            !three(line, "centre", &places[0]) || !three(line, "extent", &places[3]))
            return false;
        row.said = line;
        row.substep = 1e-6 * line["substep_us"].get<double>();
        return true;
    }
    return false;
}

namespace {

// Reason why a peer with this exit code gave no results.
std::string problem_of(int code, const std::string& program, double limit)
{
    if (code == 127) return "not run: no program " + program;
    if (code == 3) return "not run: Python has no taichi here";
    if (code == ended_late) return fmt::format("no figures: it took more than {} s", limit);
    return fmt::format("no figures: it ended with {}", code);
}

struct Peer {
    std::string name;
    std::vector<std::string> words;
};

void run_peer(Bench& bench, const Peer& peer, double limit, const Ours& mine)
{
    bench.say("peer " + peer.name);
    PeerRow row;
    row.name = peer.name, row.ours = mine.substep;
    std::string said;
    ProbePlaces places{};
    const int code = output_of(peer.words, said, limit);
    if (code == 127 || code == ended_late || !understood(said, row, places))
        row.problem = problem_of(code, peer.words[0], limit);
    else
        for (std::size_t k = 0; k < places.size(); ++k)
            row.apart = std::max(row.apart, std::abs(places[k] - mine.places[k]));
    bench.result.peers.push_back(row);
}

// Temporary folder, removed with its contents by the destructor.
struct Folder {
    fs::path path;
    Folder()
    {
        std::string name = (fs::temp_directory_path() / "knead-peers-XXXXXX").string();
        if (!mkdtemp(name.data())) throw OutputError(name + ": cannot be made");
        path = name;
    }
    Folder(const Folder&) = delete;
    ~Folder()
    {
        std::error_code ignored;
        fs::remove_all(path, ignored);
    }
};

}  // namespace

void run_peers(Bench& bench, const PeerOptions& options)
{
    const Setup setup = peer_scene(bench, options.nodes);
    const Folder folder;
    const std::string scene = (folder.path / "scene.json").string(),
                      positions = (folder.path / "positions.f32").string();
    write_whole(scene, described(setup, options).dump());
    write_whole(positions, raw_positions(setup));
    bench.say("the peers' scene");
    const Ours mine = ours(bench, setup, options);
    const fs::path here = fs::read_symlink("/proc/self/exe").parent_path();
    const bool gpu = bench.device.kind == DeviceKind::cuda;
    const std::string script = (fs::path(bench.figures.folder) / "peers/taichi_mpm.py").string();
    const std::string on = gpu ? "cuda" : "cpu";
    std::vector<Peer> peers;
    if (gpu) peers.push_back({"plain CUDA", {(here / "peer_plain").string(), scene, positions}});
    peers.push_back({"taichi", {"python3", script, scene, positions, on, "each-substep"}});
    peers.push_back({"taichi, projecting once a frame",
                     {"python3", script, scene, positions, on, "each-frame"}});
    for (const Peer& peer : peers) run_peer(bench, peer, options.limit, mine);
}

void run_peers(Bench& bench)
{
    PeerOptions options;
    if (bench.options.quick) options.frames = 60;
    run_peers(bench, options);
}

}  // namespace knead
