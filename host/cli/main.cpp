// Command line: declares verbs and their options. Each verb is implemented in the file of its name.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <sstream>

#include "host/base/abandonable.h"
#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/machine.h"
#include "host/base/outputs.h"
#include "host/base/paths.h"
#include "host/base/print.h"
#include "host/bench/bench.h"
#include "host/cli/manual.h"
#include "host/cli/options.h"
#include "host/cli/verbs.h"
#include "host/document/command_page.h"
#include "host/ui/controls.h"
#include "host/verify/verify.h"

namespace knead {
namespace {

void add_info(CLI::App& app, Verb& chosen)
{
    static InfoOptions o;
    CLI::App* info = app.add_subcommand(
        "info", "Describe a scene, recording, mesh, report, particles or splats");
    info->add_option("FILE", o.file, "The file; -: the standard input")->required();
    info->add_option("--set", o.settings, "path.key=value, for scenes")
        ->take_all()
        ->expected(1)
        ->check(setting());
    info->add_option("--cells", o.cells,
                     "Of a scene, along the longest axis of its domain: a multiple of 4")
        ->check(CLI::Range(8, 1024));
    info->add_flag("--json", o.json, "JSON on stdout");
    info->callback([&chosen] {
        o.file = file_or_shipped(o.file);
        chosen = [] { return check_scene(o.file), info_verb(o); };
    });
}

void add_compare(CLI::App& app, Verb& chosen)
{
    static CompareOptions o;
    CLI::App* compare = app.add_subcommand("compare", "Compare two reports or two particle files");
    compare->add_option("FIRST", o.first, "report.json or particles.ply")->required();
    compare->add_option("SECOND", o.second, "The same kind")->required();
    compare->add_option("--tolerance", o.tolerance, "Relative for reports, metres for particles")
        ->capture_default_str()
        ->check(between(0, 1e300));
    compare
        ->add_option("--slower", o.slower,
                     "Fail where the second's frame takes this many times as long")
        ->check(between(0, 1e300));
    compare->add_flag("--json", o.json, "JSON on stdout");
    compare->callback([&chosen] { chosen = [] { return compare_verb(o); }; });
}

void add_convert(CLI::App& app, Verb& chosen)
{
    static ConvertOptions o;
    CLI::App* convert = app.add_subcommand("convert",
                                           "Meshes (.glb .obj .ply .stl .3mf), recordings (.hands "
                                           ".jsonl), particles (.ply .csv), splats "
                                           "(.ply .compressed.ply .splat .ksplat .spz .sog .glb)");
    convert->add_option("IN", o.in, "The file to read; -: the standard input")->required();
    convert
        ->add_option("OUT", o.out,
                     "The file to write; its ending is its format; -: the standard output")
        ->required();
    convert->add_option("--from", o.from, "Format of the standard input, e.g. obj");
    convert->add_option("--to", o.to, "Format of the standard output, e.g. stl");
    convert->add_option("--spz-version", o.spz_version, "Version of .spz: 2, 3 or 4")
        ->check(between(2, 4));
    convert->add_option("--scale", o.scale, "Multiplies a mesh, about the origin")
        ->check(between(1e-9, 1e9));
    convert
        ->add_option(
            "--unit", o.unit,
            "Of the numbers of a mesh that is written, if those that are read are metres: m, "
            "cm, mm, in; .3mf: mm, others: m")
        ->check(CLI::IsMember({"m", "cm", "mm", "in"}));
    convert->add_flag("--overwrite", o.overwrite, "Replace a file that is there");
    convert->add_flag("-q,--quiet", o.quiet, "Say nothing");
    convert->callback([&chosen] {
        o.in = file_or_shipped(o.in);
        chosen = [] { return convert_verb(o); };
    });
}

void add_render(CLI::App& app, Verb& chosen)
{
    static RenderOptions o;
    CLI::App* render =
        app.add_subcommand("render", "Draw files of splats (.ply .splat .ksplat .spz .sog .glb)");
    render->add_option("FILE", o.files, "Splats; several are one scene. Or the folder of a run")
        ->required();
    render->add_option("--out", o.out, "Picture (.png)");
    render->add_option(
        "--video", o.video,
        "Video (.mp4 .mkv .webm .mov .avi) of an orbit, a path, or a run's pictures");
    render->add_option("--rate", o.rate, "Frames per second of the video")
        ->capture_default_str()
        ->check(between(1, 240));
    render->add_option("--path", o.path, "File of camera keys (knead.path/1)");
    render->add_option("--eye", o.eye, "x,y,z: position of the camera [m]; default: in front");
    render->add_option("--at", o.at, "x,y,z: target of the camera [m]; default: the centre");
    render->add_option("--up", o.up, "The axis that points upwards: x, y, z or =-x, =-y, =-z")
        ->capture_default_str();
    render->add_option("--fov", o.field, "Horizontal field of view [degrees]")
        ->capture_default_str()
        ->check(between(1, 170));
    render
        ->add_option("--foveate", o.foveate,
                     "Degrees from the middle of an eye's view up to which every pixel is drawn; "
                     "then 1 of 2 x 2, from 15 more on 1 of 4 x 4")
        ->check(between(1, 89));
    render->add_option("--orbit", o.orbit, "N pictures, once around: OUT_0000.png and on")
        ->check(CLI::Range(1, 9999));
    render->add_option("--size", o.size, "WIDTHxHEIGHT of an eye [pixels]")->capture_default_str();
    render->add_flag("--stereo", o.stereo, "Two eyes, 64 mm apart, side by side");
    render->add_option("--background", o.background, "r,g,b: 0 to 1 each; otherwise black");
    render->add_option("--device", o.device, "auto, cuda, cuda:N, cpu, cpu:double (exact, slow)")
        ->capture_default_str();
    render->add_flag("--overwrite", o.overwrite, "Replace files that are there");
    render->add_flag("-q,--quiet", o.quiet, "Say nothing");
    render->callback([&chosen] { chosen = [] { return render_verb(o); }; });
}

void add_replay(CLI::App& app, Verb& chosen)
{
    static ReplayVerbOptions o;
    CLI::App* replay =
        app.add_subcommand("replay", "Compute a session again: compare it, or export from it");
    replay->add_option("FILE", o.file, "A session (.knead)")->required();
    replay->add_flag("--check", o.check, "Compare with the session; exit code 1 if it differs");
    replay->add_option("--to", o.to, "Number of the step to end with");
    replay->add_option("--device", o.device, "auto: that of the session; cuda, cuda:N, cpu")
        ->capture_default_str();
    replay->add_option("--record", o.record, "File for the session's hands (.hands .jsonl)");
    replay->add_option("--mesh", o.mesh, "File for the clay at the end (.glb .ply .obj .stl)");
    replay->add_option("--particles", o.particles, "The same as particles (.ply .csv)");
    replay->add_option("--threads", o.threads, "CPU threads; 0: all")->check(CLI::Range(0, 4096));
    replay->add_flag("--json", o.json, "JSON on stdout");
    replay->add_flag("--overwrite", o.overwrite, "Replace files that are there");
    replay->add_flag("-q,--quiet", o.quiet, "No progress");
    replay->callback([&chosen] {
        o.file = file_or_shipped(o.file);
        chosen = [] { return replay_verb(o); };
    });
}

void add_session(CLI::App& app, Verb& chosen)
{
    static SessionVerbOptions o;
    CLI::App* session = app.add_subcommand(
        "session", "List sessions that can be recovered; check a session, or make it smaller");
    session
        ->add_option("ACTION", o.action,
                     "list; verify FILE; compact FILE: without events, hands and older states")
        ->required()
        ->check(CLI::IsMember({"list", "verify", "compact"}));
    session->add_option("FILE", o.file, "A session (.knead), or a working log (.log)");
    session->add_option("--out", o.out, "With compact: the file to write instead of FILE");
    session->add_flag("--json", o.json, "JSON on stdout");
    session->add_flag("--overwrite", o.overwrite, "Replace a file that is there");
    session->add_flag("-q,--quiet", o.quiet, "Say nothing");
    session->callback([&chosen] {
        if (o.action == "verify") o.file = file_or_shipped(o.file);
        chosen = [] { return session_verb(o); };
    });
}

void add_doctor(CLI::App& app, Verb& chosen)
{
    static DoctorOptions o;
    CLI::App* doctor = app.add_subcommand(
        "doctor", "Report what is installed, what is missing, and leftovers of killed programs");
    doctor->add_option("FOLDER", o.folders,
                       "Folders to search for leftovers; default: the working directory");
    doctor->add_flag("--json", o.json, "JSON on stdout");
    doctor->callback([&chosen] { chosen = [] { return doctor_verb(o); }; });
}

void add_bench(CLI::App& app, Verb& chosen)
{
    static BenchOptions o;
    CLI::App* bench =
        app.add_subcommand("bench", "Measure the speed of this machine on the squeeze");
    bench->add_option(
        "SUITE", o.suites,
        "stages, paper, scale, surface, localized, deterministic, splats, undo, targets; none: "
        "all");
    bench->add_option("--device", o.device, "auto, cuda, cuda:N or cpu")->capture_default_str();
    bench->add_option("--out", o.out,
                      "Folder for results; profiling/results/<device> if not given");
    bench->add_flag("--overwrite", o.overwrite, "Replace results that are there");
    bench->add_flag("--quick", o.quick, "Few frames and small sizes, as a functional test");
    bench->add_flag("--peers", o.peers, "Other implementations too, on one scene");
    bench->add_option(
        "--data", o.data,
        "Folder of plot.py, peers.json, targets.json and peers/; otherwise those that "
        "came with the program");
    bench->add_option("--scene", o.scene, "Scene to vary")->capture_default_str();
    bench->add_flag("--count", o.count,
                    "Instructions and bytes, too, by the GPU's counters (needs CUPTI)");
    bench->add_option("--threads", o.threads, "CPU threads; 0: all")->check(CLI::Range(0, 4096));
    bench->add_option("--case-limit", o.case_limit, "Seconds after which a case begins no frame")
        ->check(between(0, longest_time));
    bench->add_option("--max-memory", o.max_memory, "MiB of the host; 0: what is free")
        ->check(between(0, most_memory));
    bench->add_option("--max-particles", o.max_particles, "Largest size of the suite scale")
        ->check(between(1e3, 2e8));
    bench->add_flag("--json", o.json, "The results on stdout as JSON");
    bench->add_flag("-q,--quiet", o.quiet, "No progress");
    bench->callback([&chosen] { chosen = [] { return bench_verb(o); }; });
}

void add_verify(CLI::App& app, Verb& chosen)
{
    static VerifyOptions o;
    CLI::App* verify = app.add_subcommand(
        "verify", "Check accuracy, convergence and stability against independent references");
    verify->add_option("SUITE", o.suites,
                       "accuracy, convergence, stability, workprecision; none: all");
    verify->add_option("--device", o.device, "auto, cuda, cuda:N, cpu or reference")
        ->capture_default_str();
    verify->add_option("--only", o.only, "Parts whose name contains this");
    verify->add_option("--case", o.one, "Run one case of the stability suite and print it as JSON");
    verify->add_option("--out", o.out, "Folder for verify.json, verify.csv, report.md, pictures");
    verify->add_option("--data", o.data,
                       "Folder of plot_verify.py and known.json; otherwise the program's");
    verify->add_flag("--overwrite", o.overwrite, "Replace results that are there");
    verify->add_flag("--quick", o.quick, "Small sizes and a sample of the cases: minutes");
    verify->add_option("--threads", o.threads, "CPU threads; 0: all")->check(CLI::Range(0, 4096));
    verify->add_flag("--json", o.json, "The results on stdout as JSON");
    verify->add_flag("-q,--quiet", o.quiet, "Only the last line");
    verify->callback([&chosen] { chosen = [] { return verify_verb(o); }; });
}

void add_list(CLI::App& app, Verb& chosen)
{
    static ListOptions o;
    CLI::App* list = app.add_subcommand("list", "Name what a scene can use");
    list->add_option("KIND", o.kind, "presets, materials (the same), gestures, scenes")->required();
    list->callback([&chosen] { chosen = [] { return list_verb(o); }; });
}

void add_new(CLI::App& app, Verb& chosen)
{
    static NewOptions o;
    CLI::App* make = app.add_subcommand("new", "Write a scene to start from, with comments");
    make->add_option("SCENE", o.out, "File ending in .json; -: the standard output")->required();
    make->add_flag("--overwrite", o.overwrite, "Replace a file that is there");
    make->add_flag("-q,--quiet", o.quiet, "Say nothing");
    make->callback([&chosen] { chosen = [] { return new_verb(o); }; });
}

// Text of `knead --help`. app.help() would return the help of the parsed verb, `help` itself.
std::string whole_help(const CLI::App& app)
{
    return app.get_formatter()->make_help(&app, "knead", CLI::AppFormatMode::Normal);
}

void add_help(CLI::App& app, Verb& chosen)
{
    static std::string verb, shell, folder;
    static bool manual = false;
    CLI::App* help = app.add_subcommand("help", "Describe the program, or one of its verbs");
    help->add_option("VERB", verb,
                     "What is described; commands: those of logs; keys: of the window");
    help->add_flag("--man", manual, "As a page of the manual, in roff");
    help->add_option("--completion", shell, "Completion for a shell instead: bash, zsh");
    help->add_option("--pages", folder, "Write all pages and completions into this folder");
    help->callback([&] {
        chosen = [&app] {
            if (!folder.empty()) {
                write_pages(app, folder);
                return int(exit_ok);
            }
            if ((verb == "commands" || verb == "keys") && shell.empty() && !manual) {
                print(verb == "keys" ? keys_text() : commands_help());
                return int(exit_ok);
            }
            std::string text = manual_page(app, verb);
            if (!shell.empty())
                text = completion(app, shell);
            else if (!manual)
                text = verb.empty() ? whole_help(app) : app.get_subcommand(verb)->help("knead");
            print(text);
            return int(exit_ok);
        };
    });
}

// Prints a suggestion for an unknown verb or option.
void suggest(const CLI::App& app, const std::vector<std::string>& words)
{
    const auto say = [](const std::string& word, const std::vector<std::string>& known) {
        const std::string near = likely_name(word, known);
        if (!near.empty())
            std::fprintf(stderr, "%s: did you mean \"%s\"?\n", word.c_str(), near.c_str());
    };
    const CLI::App* verb = nullptr;
    std::vector<std::string> verbs;
    for (const CLI::App* one : app.get_subcommands([](const CLI::App*) { return true; })) {
        verbs.push_back(one->get_name());
        if (!words.empty() && words[0] == one->get_name()) verb = one;
    }
    if (!verb) {
        if (!words.empty()) say(words[0], verbs);
        return;
    }
    std::vector<std::string> options;
    for (const CLI::Option* option : verb->get_options())
        for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
    for (const std::string& word : words) {
        const std::string name = word.substr(0, word.find('='));
        const bool there = std::find(options.begin(), options.end(), name) != options.end();
        if (name.starts_with("--") && name.size() > 2 && !there) say(name, options);
    }
}

// Makes output errors independent of the environment: exceeding the file size limit (ulimit -f) is
// a write error, not a fatal signal; closed standard streams keep their descriptors reserved, so
// that printing to them fails and writes to no other file.
void prepare_outputs()
{
    std::signal(SIGXFSZ, SIG_IGN);
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        if (fcntl(stream, F_GETFD) < 0)
            open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

int program(int count, char** words)
{
    prepare_outputs();
    CLI::App app("Clay shaped by hands", "knead");
    app.set_version_flag("-V,--version", "knead " + knead_version());
    app.require_subcommand(1);
    app.footer(
        "Exit codes: 0 ok, 1 check failed, 2 usage, 3 bad input, 4 no GPU, headset or memory,\n"
        "5 files cannot be written, 6 numerical failure, 7 device lost, 130 interrupted,\n"
        "143 terminated, 129 terminal closed");
    Verb chosen;
    add_run(app, chosen);
    add_record(app, chosen);
    add_vr(app, chosen);
    add_info(app, chosen);
    add_compare(app, chosen);
    add_convert(app, chosen);
    add_render(app, chosen);
    add_view(app, chosen);
    add_replay(app, chosen);
    add_session(app, chosen);
    add_doctor(app, chosen);
    add_bench(app, chosen);
    add_verify(app, chosen);
    add_list(app, chosen);
    add_new(app, chosen);
    add_help(app, chosen);
    try {
        app.parse(count, words);
    } catch (const CLI::ParseError& e) {
        std::ostringstream text;
        const int code = app.exit(e, text, std::cerr);
        print(text.str());
        if (code == 0) return exit_code_after_printing(exit_ok);
        suggest(app, {words + 1, words + count});
        return exit_usage;
    }
    return end_of_process(exit_code_after_printing(run_and_report(chosen)));
}

}  // namespace
}  // namespace knead

int main(int count, char** words)
{
    return knead::run_and_report([&] { return knead::program(count, words); });
}
