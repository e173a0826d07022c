// knead view: live simulation in a window, with recorded hands or a hand controlled by the mouse.
#include <fmt/format.h>

#include <charconv>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/interrupt.h"
#include "host/base/json_reader.h"
#include "host/base/machine.h"
#include "host/base/paths.h"
#include "host/base/print.h"
#include "host/cli/options.h"
#include "host/cli/verbs.h"
#include "host/desktop/view_app.h"
#include "host/run/estimate.h"
#include "host/scene/domain.h"
#include "host/scene/new_scene.h"
#include "host/ui/dropped.h"
#include "host/ui/live_results.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

void parse_size(const std::string& text, int& width, int& height)
{
    const char *at = text.data(), *end = at + text.size();
    const auto first = std::from_chars(at, end, width);
    const bool cross = first.ec == std::errc() && first.ptr < end && *first.ptr == 'x';
    const auto second = cross ? std::from_chars(first.ptr + 1, end, height) : first;
    if (!cross || second.ec != std::errc() || second.ptr != end || width < 64 || height < 64 ||
        width > 16384 || height > 16384)
        throw UsageError("--size: expected WIDTHxHEIGHT of 64 to 16384 pixels, found \"" +
                         text.substr(0, 60) + "\"");
}

// Splats or a mesh in place of a scene, which begin as an object on an empty table; "": it is none.
std::string object_given(const std::string& file)
{
    if (file == new_scene_name || is_standard(file)) return "";
    const DroppedKind kind = dropped_kind(file);
    return kind == DroppedKind::splats || kind == DroppedKind::mesh ? file : "";
}

// Runs until the window is closed. Returns its errors, so that the results are still written.
std::exception_ptr run_window(ViewApp& desk, const ViewOptions& o)
{
    try {
        double before = wall_seconds();
        while (!desk.closed() && !interrupted() && (o.frames == 0 || desk.drawn() < o.frames)) {
            const double now = wall_seconds();
            const bool last = o.frames > 0 && desk.drawn() + 1 == o.frames;
            desk.frame(now - before, last ? o.screenshot : "");
            before = now;
        }
        desk.end();
    } catch (...) {
        return std::current_exception();
    }
    return nullptr;
}

Json report_of(const ViewOptions& o, const ViewApp& desk, const LiveResults& results)
{
    Json of{{"schema", "knead.view/1"},
            {"scene", results.commands.scene},
            {"settings", results.commands.settings}};
    of["window"] = {{"renderer", desk.renderer()},
                    {"size", o.size},
                    {"drawn", desk.drawn()},
                    {"gl_errors", desk.gl_errors()},
                    {"contexts_lost", desk.contexts_lost()}};
    add_simulation(of, results, !o.script.empty());
    return of;
}

}  // namespace

int view_verb(const ViewOptions& given)
{
    ViewOptions o = given;
    int width = 0, height = 0;
    parse_size(o.size, width, height);
    ViewAppOptions options;
    options.device = resolved(parse_device(o.device));
    options.scripted = !o.script.empty();
    if (options.scripted) options.script = InputScript::read(o.script);
    options.every_frame = o.frames > 0;
    options.paused = o.paused;
    options.session = session_given(o.scene, o.settings, o.cells);
    if (options.session.empty()) options.dropped = object_given(o.scene);
    if (!options.dropped.empty()) o.scene = new_scene_name;
    options.protects = !options.scripted || !options.session.empty();
    options.settings = o.settings, options.cells = o.cells;
    options.memory = std::size_t(o.max_memory * 0x1p20);
    if (!o.screenshot.empty() && !o.overwrite && fs::exists(o.screenshot))
        throw OutputError(o.screenshot + ": is there already; --overwrite replaces it");
    const LiveOutputs outputs{o.out, o.record, "view.json", o.overwrite};
    const FolderLock lock = prepare(outputs);
    std::shared_ptr<const LiveScene> scene;
    if (!options.session.empty()) scene = load_session_scene(o.scene, options.memory);
    std::unique_ptr<Window> window = Window::open("Knead", width, height);
    std::vector<std::string> settings = o.settings;
    if (o.cells > 0)
        settings.push_back(cells_setting(parse_json(scene_text(o.scene), o.scene), o.cells));
    if (!scene) scene = load_live_scene(o.scene, settings, options.memory);
    watch_interrupts();
    if (!o.quiet)
        std::fprintf(stderr, "knead: %s\n", cost_text(scene->scene, options.device).c_str());
    ViewApp desk(std::move(window), scene, options);
    desk.panel.ui.open = !o.bare;
    if (const std::string way = desk.sharing(); !o.quiet && !way.empty())
        std::fprintf(stderr, "knead: %s\n", way.c_str());
    const std::exception_ptr failure = run_window(desk, o);
    LiveResults results = desk.results();
    const bool written = write_results(outputs, results, report_of(o, desk, results));
    if (failure) std::rethrow_exception(failure);
    if (!o.quiet) print(desk.summary());
    if (interrupted()) return 128 + interrupted();
    if (desk.gl_errors() > 0) return exit_check;
    if (desk.ended()) return exit_numbers;
    return desk.output_refused() || !written ? exit_output : exit_ok;
}

}  // namespace knead
