// knead run: a scene and its hands, headless.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "host/base/errors.h"
#include "host/base/interrupt.h"
#include "host/base/json_reader.h"
#include "host/base/machine.h"
#include "host/base/outputs.h"
#include "host/cli/progress.h"
#include "host/cli/verbs.h"
#include "host/files/mesh_file.h"
#include "host/files/particle_file.h"
#include "host/hands/recording.h"
#include "host/scene/seed.h"
#include "host/session/device.h"
#include "host/session/frame_writer.h"
#include "host/session/report.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

Scene scene_of(const RunOptions& o)
{
    std::vector<std::string> settings = o.settings;
    if (o.seed) settings.push_back(fmt::format("seed={}", *o.seed));
    if (o.pictures >= 0) settings.push_back(fmt::format("pictures.every={}", o.pictures));
    if (o.deterministic) settings.push_back("deterministic=true");
    Scene scene = read_scene(o.scene, settings);
    if (!o.hands.empty()) {
        if (!scene.has_hands) throw UsageError("--hands: the scene has no \"hands\" to replace");
        scene.hands.recording = o.hands;
    }
    scene.setup.threads = o.threads;
    const bool shows = o.video || (scene.picture_every > 0 && !o.out.empty());
    // A video is made of about 30 pictures a second.
    if (!shows)
        scene.picture_every = 0;
    else if (scene.picture_every == 0)
        scene.picture_every = std::max(1, int(std::lround(scene.frame_rate / 30)));
    return scene;
}

void check_options(const RunOptions& o)
{
    if (o.out.empty() && (o.video || o.particles || o.pictures > 0))
        throw UsageError("--video, --particles and --pictures need --out DIR");
    if (o.mesh != "glb" && o.mesh != "ply" && o.mesh != "obj" && o.mesh != "none")
        throw UsageError("--mesh: expected glb, ply, obj or none, found \"" + o.mesh + "\"");
}

class Session {
  public:
    explicit Session(const RunOptions& options) : o(options), scene(scene_of(o)) {}

    int run();

  private:
    std::string in_folder(const std::string& name) const
    {
        return (fs::path(o.out) / name).string();
    }
    void prepare();
    void open_writer();
    void watch(RunWatch& watch, Progress& progress);
    void write(const RunRecord& record);
    void note(const std::string& text) const
    {
        if (!o.quiet) std::fprintf(stderr, "knead: %s\n", text.c_str());
    }
    void attempt(const std::string& name, const std::function<void(const std::string&)>& write);
    void refused(const std::string& why)
    {
        std::fprintf(stderr, "knead: %s\n", why.c_str());
        output_refused = true;
    }
    int code(const RunRecord& record) const;

    const RunOptions& o;
    Scene scene;
    RunRule rule;
    RunFacts facts;
    std::unique_ptr<FrameWriter> writer;
    bool has_video = false, output_refused = false;
};

// All that can be refused is refused here, before the work starts.
void Session::prepare()
{
    const std::size_t memory =
        o.max_memory > 0 ? std::size_t(o.max_memory * 0x1p20) : available_memory();
    build(scene, memory);
    if (!o.out.empty()) {
        std::vector<std::string> names{"report.json", "frames.csv"};
        if (o.mesh != "none") names.push_back("mesh." + o.mesh);
        if (o.particles) names.push_back("particles.ply");
        if (o.video) names.push_back("video.mp4");
        if (scene.picture_every > 0) names.push_back("pictures");
        prepare_folder(o.out, names, o.overwrite);
    }
    rule.frames = o.frames;
    rule.time_limit = o.time_limit;
    rule.last_mesh = !o.out.empty() && o.mesh != "none";
    facts.threads = o.threads;
    facts.settings = o.settings;
}

void Session::open_writer()
{
    if (scene.picture_every == 0) return;
    has_video = o.video && Video::available();
    if (o.video && !has_video) {
        facts.left_out.push_back("video: ffmpeg is not on the PATH");
        note(facts.left_out.back());
    }
    try {
        writer = std::make_unique<FrameWriter>(scene, in_folder("pictures"),
                                               has_video ? in_folder("video.mp4") : "",
                                               scene.frame_rate / scene.picture_every);
        rule.mesh_every = scene.picture_every;
    } catch (const std::runtime_error& e) {
        note(e.what());
        facts.left_out.push_back(std::string("pictures: ") + e.what());
    }
}

void Session::watch(RunWatch& watch, Progress& progress)
{
    watch.frame = [&](const FrameRow& row) {
        if (o.verbose && !o.quiet) {
            progress.clear();
            note(fmt::format("frame {}: {} substeps, {:.3f} ms", row.frame, row.stats.substeps,
                             1e3 * row.wall));
        }
        progress.show(row.frame);
    };
    watch.picture = [&](const Frame& frame, const std::vector<Mesh>& meshes) {
        if (!writer) return;
        try {
            writer->add(frame, meshes);
        } catch (const OutputError& e) {
            refused(e.what());
            writer.reset();
        }
    };
}

// Writes one of the results; where the disk refuses, the others are still written.
void Session::attempt(const std::string& name, const std::function<void(const std::string&)>& write)
{
    try {
        write(in_folder(name));
        facts.outputs.push_back(in_folder(name));
    } catch (const std::runtime_error& e) {
        refused(e.what());
    }
}

void Session::write(const RunRecord& record)
{
    const bool files = !o.out.empty();
    const bool failed = record.end == End::numbers || record.end == End::device;
    if (files && o.mesh != "none" && record.meshes && !record.meshes->empty())
        attempt("mesh." + o.mesh, [&](const std::string& to) { write_mesh(to, *record.meshes); });
    if (files && (o.particles || failed))
        attempt("particles.ply",
                [&](const std::string& to) { write_particles(to, *record.last_good); });
    if (writer && writer->count() > 0) {
        facts.outputs.push_back(in_folder("pictures"));
        if (has_video) attempt("video.mp4", [&](const std::string&) { writer->close(); });
    }
    if (files)
        attempt("frames.csv", [&](const std::string& to) { write_whole(to, frames_csv(record)); });
    const auto text = [&] {
        return report(scene, record, facts).dump(2, ' ', false, Json::error_handler_t::replace) +
               "\n";
    };
    if (files) {
        facts.outputs.push_back(in_folder("report.json"));
        const std::string whole = text();
        facts.outputs.pop_back();
        attempt("report.json", [&](const std::string& to) { write_whole(to, whole); });
    }
    const std::string said = o.json ? text() : o.quiet ? "" : summary(report(scene, record, facts));
    std::fputs(said.c_str(), stdout);
}

int Session::code(const RunRecord& record) const
{
    if (!record.trouble.empty()) std::fprintf(stderr, "knead: %s\n", record.trouble.c_str());
    switch (record.end) {
        case End::interrupted:
            return interrupted() == 15 ? exit_terminate : exit_interrupt;
        case End::numbers:
            return exit_numbers;
        case End::device:
            return exit_device;
        case End::complete:
        case End::time_limit:
            break;
    }
    return output_refused ? exit_output : exit_ok;
}

int Session::run()
{
    const Device device = resolved(parse_device(o.device));
    prepare();
    std::unique_ptr<HandSource> hands;
    if (scene.has_hands) {
        const Recording recording = hands_of(scene);
        facts.hand_rate = recording.rate;
        facts.hand_latency = recording.latency;
        hands = std::make_unique<HandSource>(recording, scene.hands);
    }
    const std::unique_ptr<Solver> solver = make_solver(scene.setup, device);
    facts.solver = solver->name();
    rule.audit_every = o.audit_every > 0 ? o.audit_every : device.kind == DeviceKind::cuda ? 10 : 1;
    // All that can be wrong with what was given has been found: the old pictures may go.
    if (o.overwrite && !o.out.empty()) remove_pictures(in_folder("pictures"));
    open_writer();
    const std::vector<std::string> rest = left_out(scene, rule);
    facts.left_out.insert(facts.left_out.end(), rest.begin(), rest.end());
    scene.setup.particles = {};

    watch_interrupts();
    RunWatch watching;
    RunRecord record;
    {
        Progress progress(frames_wanted(scene, hands.get(), o.frames), o.quiet || o.verbose);
        watch(watching, progress);
        const double before = process_seconds();
        record = run_frames(scene, *solver, hands.get(), rule, watching);
        facts.cpu_seconds = process_seconds() - before;
    }
    if (scene.setup.rest.mode != RestMode::none)
        for (const std::string& spared : left_at_rest(record)) facts.left_out.push_back(spared);
    write(record);
    return code(record);
}

}  // namespace

int run_verb(const RunOptions& options)
{
    check_options(options);
    return Session(options).run();
}

}  // namespace knead
