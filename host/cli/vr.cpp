// knead vr: live simulation in a headset.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "host/base/errors.h"
#include "host/base/interrupt.h"
#include "host/base/json_reader.h"
#include "host/base/machine.h"
#include "host/base/parallel.h"
#include "host/base/print.h"
#include "host/base/quiet_stderr.h"
#include "host/cli/options.h"
#include "host/cli/verbs.h"
#include "host/run/estimate.h"
#include "host/scene/domain.h"
#include "host/scene/new_scene.h"
#include "host/session/backend.h"
#include "host/session/session_file.h"
#include "host/ui/live_results.h"
#include "host/vr/headset_run.h"

namespace knead {
namespace {

Vec3<double> place_of(const std::string& text)
{
    std::istringstream in(text);
    Vec3<double> place{};
    char first = 0, second = 0;
    in >> place.x >> first >> place.y >> second >> place.z;
    const auto near = [](double x) { return std::abs(x) <= 10; };
    if (!in || !(in >> std::ws).eof() || first != ',' || second != ',' ||
        !(near(place.x) && near(place.y) && near(place.z)))
        throw UsageError("--place: expected x,y,z, each within 10 m, found \"" +
                         text.substr(0, 60) + "\"");
    return place;
}

GlBinding binding_of(const std::string& text)
{
    if (text == "auto") return GlBinding::automatic;
    if (text == "egl") return GlBinding::egl;
    if (text == "glx") return GlBinding::glx;
    if (text == "wgl") return GlBinding::wgl;
    throw UsageError("--binding: expected auto, egl, glx or wgl, found \"" + text.substr(0, 60) +
                     "\"");
}

HeadsetLoopOptions options_of(const VrOptions& o, Device device)
{
    HeadsetLoopOptions options;
    options.headset.binding = binding_of(o.binding);
    options.headset.floor = o.standing ? Floor::standing : Floor::seated;
    options.headset.rate = o.rate, options.headset.patience = o.patience;
    options.headset.see_through = o.see_through;
    options.device = device;
    options.stepped = o.deterministic, options.recorded = o.recorded;
    options.hands_only = o.hands_only;
    options.workplace.at = place_of(o.place);
    options.frames = o.frames;
    options.panel = !o.no_panel;
    options.sound = !o.no_sound;
    options.min_scale = o.eye_scale;
    options.foveate = o.foveate;
    options.samples = o.samples;
    options.notify = [quiet = o.quiet](const std::string& text) {
        QuietStderr::lift();
        if (!quiet) std::fprintf(stderr, "knead: %s\n", text.c_str());
    };
    options.should_stop = [] { return interrupted() != 0; };
    return options;
}

LiveOutputs outputs_of(const VrOptions& o)
{
    return {o.out, o.record, "headset.json", o.overwrite};
}

Json report_of(const VrOptions& o, const HeadsetEnd& end, const LiveResults& results)
{
    Json of{{"schema", "knead.headset/1"}, {"scene", o.scene}, {"settings", o.settings}};
    const HeadsetInfo& f = end.facts;
    of["headset"] = {
        {"runtime", f.runtime},   {"system", f.system},          {"binding", f.binding},
        {"renderer", f.renderer}, {"extensions", f.extensions},  {"missing", f.missing},
        {"width", f.width},       {"height", f.height},          {"depth", f.depth},
        {"hands", f.hands},       {"see_through", f.see_through}};
    of["display"] = end.figures.figures();
    of["display"]["rate_hz"] = end.rate;
    of["length_s"] = end.length;
    of["drawn"] = end.drawn;
    of["renewals"] = end.sessions_recreated;
    of["shared"] = end.shared;
    of["gl_errors"] = end.gl_errors, of["stray_gl_errors"] = end.runtime_gl_errors;
    of["reason"] = end.reason;
    add_simulation(of, results, o.deterministic);
    of["simulation"]["behind_s"] = end.state->backlog.missing_time + end.left_out;
    return of;
}

// Environment defaults of libraries loaded later; the user's values take precedence.
void set_defaults_of_libraries()
{
    // Load all kernels at startup, not each at its first launch.
    default_variable("CUDA_MODULE_LOADING", "EAGER");
    default_variable("ALSOFT_LOGLEVEL", "0");  // errors are reported by SoundOut::open()
}

void summarise(const VrOptions& o, const HeadsetEnd& end, const Json& report)
{
    if (o.json) print(report.dump(2) + "\n");
    if (o.json || o.quiet) return;
    print(fmt::format("headset       {}, {} x {} an eye, {}\n{}state hash    {}\n",
                      end.facts.runtime, end.facts.width, end.facts.height, end.facts.renderer,
                      end.figures.summary(), end.hash));
}

}  // namespace

int vr_verb(const VrOptions& given)
{
    VrOptions o = given;
    set_defaults_of_libraries();
    set_loop_threads(o.threads);
    const std::string session = session_given(o.scene, given.settings, given.cells);
    const Device device = resolved(parse_device(o.device));
    HeadsetLoopOptions options = options_of(o, device);
    options.session = session;
    if (o.cells > 0)
        o.settings.push_back(cells_setting(parse_json(scene_text(o.scene), o.scene), o.cells));
    options.protects = !o.hands_only && (!o.deterministic || !session.empty());
    if (o.hands_only && o.record.empty() && o.out.empty())
        throw UsageError("--hands-only needs --record FILE, or --out DIR");
    const LiveOutputs outputs = outputs_of(o);
    const FolderLock lock = prepare(outputs);
    std::vector<std::string> settings = o.settings;
    if (o.deterministic) settings.push_back("deterministic=true");
    auto scene = std::make_shared<LiveScene>(
        *(session.empty() ? load_live_scene(o.scene, settings) : load_session_scene(session)));
    o.scene = scene->scene.path;
    if (o.deterministic && !session.empty() && !SessionFile(session).meta().deterministic)
        throw UsageError("--deterministic: the session is not deterministic");
    options.scene = o.scene, options.settings = settings;
    scene->scene.setup.threads = o.threads;
    watch_interrupts();
    if (!o.hands_only) options.notify(cost_text(scene->scene, device));
    HeadsetRun run(scene, options);
    HeadsetEnd end = run.wait();
    LiveResults results{
        std::move(end.hands), std::move(end.commands), end.state, {end.hash, end.particles}};
    const Json report = report_of(o, end, results);
    const bool written = write_results(outputs, results, report);
    summarise(o, end, report);
    if (!end.reason.empty()) {
        std::fprintf(stderr, "knead: %s\n", end.reason.c_str());
        return exit_resource;
    }
    if (!end.state->failure.empty()) return exit_numbers;
    if (interrupted() != 0) return 128 + interrupted();
    return written ? exit_ok : exit_output;
}

}  // namespace knead
