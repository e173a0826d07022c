// knead replay: computes a session again, compares it with its log, and exports from it.
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/interrupt.h"
#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/base/parallel.h"
#include "host/base/paths.h"
#include "host/base/print.h"
#include "host/cli/progress.h"
#include "host/cli/verbs.h"
#include "host/files/mesh_file.h"
#include "host/files/particle_file.h"
#include "host/hands/recording.h"
#include "host/live/live_session.h"
#include "host/live/session_log.h"
#include "host/session/backend.h"
#include "host/session/session_file.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

bool on_gpu(const SessionFile& file) { return file.meta().device.starts_with("cuda"); }

// The device of the session, unless another is given.
Device device_of(const SessionFile& file, const std::string& given)
{
    if (given != "auto") return resolved(parse_device(given));
    return resolved(parse_device(on_gpu(file) ? "cuda" : "cpu"));
}

// Whether simulators of these names compute the same bits: "cpu float, 8 lanes, 2 threads" does
// with any number of threads.
bool same_arithmetic(const std::string& a, const std::string& b)
{
    return a.substr(0, a.rfind(" lanes")) == b.substr(0, b.rfind(" lanes"));
}

// How far the particles of a replay are from those that the session stored.
struct Distance {
    long frame = 0;
    double rms = 0, most = 0;  // [m]
};
Distance distance(long frame, const std::vector<Particle<double>>& here,
                  const std::vector<Particle<double>>& there)
{
    Distance found{frame, 0, 0};
    const std::size_t count = std::min(here.size(), there.size());
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const double d = length(here[i].x - there[i].x);
        sum += d * d, found.most = std::max(found.most, d);
    }
    if (here.size() != there.size()) found.most = INFINITY;
    found.rms = std::sqrt(sum / double(std::max<std::size_t>(1, count)));
    return found;
}

class SessionCheck {
  public:
    SessionCheck(const ReplayVerbOptions& options, const SessionFile& from)
        : o(options), file(from), device(device_of(from, o.device))
    {
    }
    int run();

  private:
    void expect(SessionReplay& replay);
    void find_states();
    bool has_step(StepId id) const;
    bool captures_step() const;
    ReplayOptions replay_options(Progress& progress);
    void play(SessionReplay& replay);
    void report() const;
    void write(const SessionReplay& replay) const;

    const ReplayVerbOptions& o;
    const SessionFile& file;
    const Device device;
    std::optional<StepId> to_step;
    bool exact = true;  // equal runs give the bits of the session
    long frames = 0, compared = 0, first = -1;
    std::map<long, std::uint64_t> states;  // by frames before: ids
    std::vector<Distance> distances;
};

void SessionCheck::expect(SessionReplay& replay)
{
    file.each_event([&](const SessionEvent& event) {
        if (const HashEvent* hash = std::get_if<HashEvent>(&event)) replay.expect(*hash);
        return true;
    });
}

// By the frames before them. Those of beginnings of steps are not among them.
void SessionCheck::find_states()
{
    for (const std::uint64_t id : file.states()) {
        const StoredState state = file.state(id);
        if (state.frames > 0) states[state.frames] = id;
    }
}

void SessionCheck::write(const SessionReplay& replay) const
{
    const Vec3<double> by = replay.scene().origin;
    std::vector<Particle<double>> clay = replay.simulator().particles();
    if (!o.mesh.empty()) {
        const EditableSimulator* of = replay.simulator().editable();
        std::vector<Mesh> meshes =
            surface(clay, of ? of->config().materials : replay.scene().setup.materials,
                    replay.scene().surface);
        move_by(meshes, by);
        write_mesh(o.mesh, meshes);
    }
    for (Particle<double>& q : clay) q.x = q.x + by;
    if (!o.particles.empty()) write_particles(o.particles, clay);
}

void SessionCheck::report() const
{
    if (o.json) {
        nlohmann::ordered_json all{{"frames", frames}};
        if (exact)
            all["equal"] = first < 0;
        else
            all["equal"] = nullptr, all["distances"] = nlohmann::ordered_json::array();
        if (first >= 0) all["first"] = first;
        for (const Distance& d : distances)
            all["distances"].push_back({{"frame", d.frame}, {"rms_m", d.rms}, {"max_m", d.most}});
        return print(all.dump() + "\n");
    }
    if (!exact) {
        print(fmt::format("{} frames; not bit for bit: the session's device or mode differs\n",
                          frames));
        for (const Distance& d : distances)
            print(
                fmt::format("frame {}: {:.3g} m rms, {:.3g} m at most\n", d.frame, d.rms, d.most));
    } else if (!o.check) {
        print(fmt::format("{} frames\n", frames));
    } else if (first < 0) {
        print(fmt::format("{} frames, equal; compared: {}\n", frames, compared));
    } else {
        print(fmt::format("{} frames; frame {} is the first that differs\n", frames, first));
    }
}

bool SessionCheck::has_step(StepId id) const
{
    History past(std::size_t(1) << 40);
    file.read_history(past, 0);
    return past.find(id) != nullptr;
}

ReplayOptions SessionCheck::replay_options(Progress& progress)
{
    ReplayOptions options;
    options.make_solver = [&](const Setup& setup) {
        auto made = make_solver(setup, device);
        const bool before = exact;
        exact = file.meta().deterministic && same_arithmetic(made->name(), file.meta().device);
        if (before && !exact) find_states();
        return made;
    };
    options.stepped = file.meta().stepped;
    options.stored_state = [&](std::uint64_t id) { return file.state(id); };
    options.read_history = [&](History& past) { file.read_history(past, 0); };
    options.to_step = to_step;
    options.after_frame = [&](long frame, const Simulator& simulator) {
        progress.show(int(frame));
        if (const auto stored = states.find(frame); stored != states.end())
            distances.push_back(distance(frame, simulator.particles(),
                                         file.state(stored->second).state.contents.particles));
        return !interrupted();
    };
    if (!o.check) return options;
    options.compared = [&](const ReplayedHash& hash) {
        ++compared;
        if (exact && !hash.equal && first < 0) first = hash.frame;
    };
    return options;
}

// A step of a command before the first frame has no event: frames are not needed for it.
bool SessionCheck::captures_step() const
{
    bool captures = !to_step;
    file.each_event([&](const SessionEvent& event) {
        const StepCaptured* captured = std::get_if<StepCaptured>(&event);
        return !(captures = captures || (captured && captured->id == *to_step));
    });
    return captures;
}

void SessionCheck::play(SessionReplay& replay)
{
    const bool captures = captures_step();
    bool stopped = false, any = false;
    file.each_event([&](const SessionEvent& event) {
        any = true;
        if (!captures && std::holds_alternative<FrameEvent>(event)) return false;
        try {
            return !(stopped = !replay.add(event));
        } catch (const std::runtime_error& e) {
            if (!o.check || !exact) throw;
            std::fprintf(stderr, "knead: after frame %ld: %s\n", replay.frames(), e.what());
            if (first < 0) first = replay.frames() + 1;
            return false;
        }
    });
    if (!any)
        throw InputError(file.chunks().path() +
                         ": it has no events to compute again; `knead convert` writes its clay");
    frames = replay.frames();
    if (!to_step || stopped || interrupted()) return;
    if (!has_step(*to_step))
        throw InputError(fmt::format("{}: no step {} was captured", file.chunks().path(), o.to));
    replay.add(StepRestored{*to_step});
}

int SessionCheck::run()
{
    if (!o.to.empty()) {
        StepId to = 0;
        const auto [end, problem] = std::from_chars(o.to.data(), o.to.data() + o.to.size(), to);
        if (problem != std::errc() || end != o.to.data() + o.to.size())
            throw UsageError("--to: expected the number of a step, found \"" + o.to + "\"");
        to_step = to;
    }
    Progress progress(int(file.frames()), o.quiet || o.json);
    SessionReplay replay(live_scene_of(file.scene()), replay_options(progress));
    expect(replay);
    play(replay);
    progress.clear();
    if (interrupted()) return 128 + interrupted();
    write(replay);
    if (!o.record.empty()) write_recording(o.record, file.recording());
    report();
    return first >= 0 ? exit_check : exit_ok;
}

}  // namespace

int replay_verb(const ReplayVerbOptions& o)
{
    for (const std::string& file : {o.mesh, o.particles, o.record})
        if (!file.empty()) prepare_file(file, o.overwrite);
    set_loop_threads(o.threads);
    const SessionFile file(o.file);
    watch_interrupts();
    return SessionCheck(o, file).run();
}

}  // namespace knead
