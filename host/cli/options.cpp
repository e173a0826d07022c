// The options of the verbs that simulate: run, record, vr, view.
#include "host/cli/options.h"

#include <fmt/format.h>

#include <filesystem>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/paths.h"
#include "host/cli/verbs.h"
#include "host/session/session_file.h"

namespace knead {

CLI::Validator between(double low, double high)
{
    const auto refused = [low, high](std::string& word) {
        double value = 0;
        if (CLI::detail::lexical_cast(word, value) && value >= low && value <= high)
            return std::string();
        return fmt::format("expected a number from {} to {}, found \"{}\"", low, high, word);
    };
    return CLI::Validator(refused, fmt::format("{} to {}", low, high));
}

CLI::Validator setting()
{
    const auto refused = [](std::string& word) {
        const std::string path = "." + word.substr(0, word.find('=')) + ".";
        const bool fine = word.find('=') != std::string::npos && path.find("..") == path.npos;
        return fine ? "" : "expected path.key=value, found \"" + word.substr(0, 60) + "\"";
    };
    return CLI::Validator(refused, "");
}

void check_scene(const std::string& name)
{
    std::error_code problem;
    const std::string form = ending(name);
    if (name.empty() || is_standard(name) || (!form.empty() && form != ".json") ||
        std::filesystem::exists(name, problem))
        return;
    const std::string given = std::filesystem::path(name).stem().string();
    const std::string near = likely_name(given, shipped_scenes());
    if (!near.empty())
        throw InputError(name + ": no such file, and no such scene; did you mean \"" + near +
                         "\"?");
}

std::string session_given(const std::string& scene, const std::vector<std::string>& settings,
                          int cells)
{
    if (!is_session(scene)) return "";
    if (settings.empty() && cells == 0) return scene;
    throw UsageError(std::string(cells > 0 ? "--cells" : "--set") +
                     ": a session goes on with its own settings");
}

namespace {

void add_cells(CLI::App* verb, int& cells)
{
    verb->add_option("--cells", cells,
                     "Along the domain's longest axis instead of the scene's: a multiple of 4")
        ->check(CLI::Range(8, 1024));
}

// Options for the results of a run.
void add_results(CLI::App* run, RunOptions& o)
{
    run->add_option("--mesh", o.mesh, "glb, ply, obj, stl or none")->capture_default_str();
    run->add_option("--mesh-every", o.mesh_every, "meshes/mesh_0001 and on, every N frames")
        ->check(CLI::Range(0, 10000000));
    run->add_option("--particles-every", o.particles_every,
                    "particles/particles_0001.ply and on, every N frames")
        ->check(CLI::Range(0, 10000000));
    run->add_option("--pictures", o.pictures, "A picture every N frames; 0: none")
        ->check(CLI::Range(0, 10000000));
    run->add_flag("--video", o.video, "video.mp4, by ffmpeg");
    run->add_flag("--particles", o.particles, "particles.ply of the last frame");
    run->add_option("--splats", o.splats,
                    "ply, compressed.ply, splat, spz, sog, glb or none, of a scene that has splats")
        ->capture_default_str();
}

}  // namespace

// The options are static: the closure that main calls refers to them.
void add_run(CLI::App& app, Verb& chosen)
{
    static RunOptions o;
    CLI::App* run = app.add_subcommand("run", "Simulate a scene with its hands, headless");
    run->add_option("SCENE", o.scene, "Scene (.json); -: the standard input");
    run->add_option("--device", o.device, "auto, cuda, cuda:N, cpu or cpu:double")
        ->capture_default_str();
    run->add_option("--set", o.settings, "path.key=value, e.g. objects.0.material.young=2e6")
        ->take_all()
        ->expected(1)
        ->check(setting());
    run->add_option("--hands", o.hands, "A recording or gesture instead of the scene's");
    add_cells(run, o.cells);
    run->add_option("--frames", o.frames, "Stop after N frames")->check(CLI::Range(1, 10000000));
    run->add_option("--out", o.out, "Folder for report.json, frames.csv, mesh, pictures");
    run->add_flag("--overwrite", o.overwrite, "Replace results that are there");
    run->add_flag("--deterministic", o.deterministic, "Bitwise reproducible results");
    run->add_option("--seed", o.seed, "Seed of particle positions and gestures")
        ->check(CLI::Range(0, 2147483647));
    run->add_option("--max-memory", o.max_memory, "MiB that a run may take; 0: what is free")
        ->check(between(0, most_memory));
    run->add_option("--audit", o.audit_every, "Look at the whole state every N frames")
        ->check(CLI::Range(1, 10000000));
    add_results(run, o);
    run->add_option("--commands", o.commands,
                    "Apply the commands of this log between the frames that it says");
    run->add_flag("--keep-going", o.keep_going, "Go on when a command is refused");
    CLI::Option* resume =
        run->add_option("--resume", o.resume, "Resume the interrupted run in this folder");
    for (CLI::Option* other : run->get_options())
        if (other != resume && other != run->get_help_ptr()) resume->excludes(other);
    run->add_option("--threads", o.threads, "CPU threads; 0: all")->check(CLI::Range(0, 4096));
    run->add_option("--time-limit", o.time_limit, "Seconds after which it ends, with its results")
        ->check(between(0, longest_time));
    run->add_option("--checkpoint", o.checkpoint,
                    "Seconds from checkpoint to checkpoint, with --out; 60 if not given, 0: none")
        ->check(between(0, longest_time));
    run->add_flag("--json", o.json, "The report on stdout");
    run->add_flag("-q,--quiet", o.quiet, "No progress, no summary");
    run->add_flag("-v,--verbose", o.verbose, "A line per frame");
    run->callback([&chosen] {
        o.scene = file_or_shipped(o.scene);
        // A name without an extension is that of a gesture.
        if (!ending(o.hands).empty()) o.hands = file_or_shipped(o.hands);
        chosen = [] { return check_scene(o.scene), run_verb(o); };
    });
}

void add_record(CLI::App& app, Verb& chosen)
{
    static RecordOptions o;
    CLI::App* record =
        app.add_subcommand("record", "Write the hands of a scripted gesture to a file");
    record->add_option("GESTURE", o.gesture, "squeeze, imprint, poke, cut, ...");
    record->add_option("OUT", o.out, "File ending in .hands or .jsonl");
    record->add_flag("--live", o.live, "Explain how to record hands in a headset");
    record->add_option("--rate", o.rate, "Frames per second")->capture_default_str();
    record->add_option("--seconds", o.seconds, "Length; 0: the gesture's own");
    record->add_option("--radius", o.radius, "Of the ball that is shaped [m]")
        ->capture_default_str();
    record->add_option("--depth", o.depth,
                       "Deepest penetration over the radius; 0: the gesture's own");
    record->add_option("--jitter", o.jitter, "Tracking noise, rms [m]");
    record->add_option("--dropouts", o.dropouts, "Chance per hand and frame to lose it");
    record->add_option("--latency", o.latency, "Of the tracker [s]")->capture_default_str();
    record->add_option("--seed", o.seed, "Of noise and dropouts")->capture_default_str();
    record->add_flag("--overwrite", o.overwrite, "Replace a file that is there");
    record->add_flag("-q,--quiet", o.quiet, "Say nothing");
    record->callback([&chosen] { chosen = [] { return record_verb(o); }; });
}

void add_vr(CLI::App& app, Verb& chosen)
{
    static VrOptions o;
    CLI::App* vr = app.add_subcommand("vr", "Shape a scene's clay with your hands, in a headset");
    vr->add_option("SCENE", o.scene,
                   "Scene (.json), a session (.knead) to go on with, or new: an empty table")
        ->capture_default_str();
    vr->add_option("--device", o.device, "auto, cuda, cuda:N or cpu")->capture_default_str();
    vr->add_option("--set", o.settings, "path.key=value, e.g. objects.0.material.young=2e6")
        ->take_all()
        ->expected(1)
        ->check(setting());
    add_cells(vr, o.cells);
    vr->add_option("--frames", o.frames, "Leave after N frames of the display")
        ->check(CLI::Range(1, 10000000));
    vr->add_option("--out", o.out, "Folder for headset.json, mesh.glb and hands.hands");
    vr->add_option("--record", o.record, "The hands, to a file ending in .hands or .jsonl");
    vr->add_flag("--hands-only", o.hands_only, "Records hands; the clay stands still");
    vr->add_option("--place", o.place, "x,y,z of the clay before the user [m]")
        ->capture_default_str();
    vr->add_option("--rate", o.rate, "Frames per second of the display, where it has that rate")
        ->check(between(0, 1000));
    vr->add_flag("--standing", o.standing, "Places count from the floor, not from the head");
    vr->add_flag("--see-through", o.see_through, "The room behind the clay, where the headset can");
    vr->add_flag("--recorded", o.recorded, "The scene's recorded hands shape it; you watch");
    vr->add_flag("--no-panel", o.no_panel, "Without the panel beside the clay");
    vr->add_flag("--no-sound", o.no_sound, "Nothing is heard of what hands do to clay");
    vr->add_option("--binding", o.binding, "OpenGL by auto, egl, glx or wgl")
        ->capture_default_str();
    vr->add_option("--eye-scale", o.eye_scale,
                   "Share of an eye's sides that is drawn at least where OpenGL is too slow; 1: "
                   "always whole")
        ->capture_default_str()
        ->check(between(0.1, 1));
    vr->add_option("--foveate", o.foveate,
                   "Degrees from the middle of a lens up to which every pixel of splats is drawn; "
                   "then 1 of 2 x 2, from 15 more on 1 of 4 x 4")
        ->check(between(1, 89));
    vr->add_option("--samples", o.samples,
                   "Of a pixel: 1, 2, 4 or 8; 0: 4 on a GPU that has time for them, else 1")
        ->check(CLI::Range(0, 8));
    vr->add_option("--patience", o.patience, "Seconds that a lost runtime is waited for")
        ->capture_default_str()
        ->check(between(0, longest_time));
    vr->add_flag("--deterministic", o.deterministic,
                 "The display steps the simulation: the same hands give the same bits");
    vr->add_option("--threads", o.threads, "CPU threads; 0: all")->check(CLI::Range(0, 4096));
    vr->add_flag("--overwrite", o.overwrite, "Replace results that are there");
    vr->add_flag("--json", o.json, "What happened, on stdout as JSON");
    vr->add_flag("-q,--quiet", o.quiet, "No messages, no summary");
    vr->callback([&chosen] {
        o.scene = file_or_shipped(o.scene);
        chosen = [] { return check_scene(o.scene), vr_verb(o); };
    });
}

void add_view(CLI::App& app, Verb& chosen)
{
    static ViewOptions o;
    CLI::App* view = app.add_subcommand("view", "Shape a scene's clay in a window");
    view->add_option(
            "SCENE", o.scene,
            "Scene (.json), a session (.knead) to go on with, splats (.ply, .spz, .sog, ...) "
            "for an empty table, or new: the empty table")
        ->capture_default_str();
    view->add_option("--device", o.device, "auto, cuda, cuda:N, cpu or cpu:double")
        ->capture_default_str();
    view->add_option("--set", o.settings, "path.key=value, for the scene")
        ->take_all()
        ->expected(1)
        ->check(setting());
    add_cells(view, o.cells);
    view->add_option("--size", o.size, "WIDTHxHEIGHT of the window [pixels]")
        ->capture_default_str();
    view->add_option("--frames", o.frames, "Ends after N drawn frames")
        ->check(CLI::Range(1, 10000000));
    view->add_option("--screenshot", o.screenshot, "Picture (.png) of the last frame")
        ->needs("--frames");
    view->add_option("--script", o.script,
                     "Mouse and key events from a file; each drawn frame simulates one frame");
    view->add_option("--out", o.out, "Folder for view.json, mesh.glb and hands.hands");
    view->add_option("--record", o.record, "The hands, to a file ending in .hands or .jsonl");
    view->add_flag("--paused", o.paused, "Begins paused");
    view->add_flag("--bare", o.bare, "Begins without panels");
    view->add_option("--max-memory", o.max_memory, "MiB that it may take; 0: what is free")
        ->check(between(0, most_memory));
    view->add_flag("--overwrite", o.overwrite, "Replace results that are there");
    view->add_flag("-q,--quiet", o.quiet, "No summary");
    view->callback([&chosen] {
        o.scene = file_or_shipped(o.scene);
        chosen = [] { return check_scene(o.scene), view_verb(o); };
    });
}

}  // namespace knead
