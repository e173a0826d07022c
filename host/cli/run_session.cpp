#include "host/cli/run_session.h"

#include <algorithm>
#include <filesystem>
#include <future>

#include "host/assets/mesh_object.h"
#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/machine.h"
#include "host/base/paths.h"
#include "host/cli/run_options.h"
#include "host/scene/seed.h"
#include "host/session/scene_export.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

ClayRows rows_of(const InitialState& contents)
{
    ClayRows rows = empty_rows(contents.particles.size());
    for (std::size_t i = 0; i < rows.count; ++i)
        set_particle(rows, i, cast<float>(contents.particles[i]));
    for (const Gaussian<double>& g : contents.gaussians) rows.gaussians.push_back(cast<float>(g));
    return rows;
}

// What a step at the beginning of a scene needs: its clay, built as for a run.
struct Built {
    HistoryStep step;
    std::shared_ptr<const ClayRows> rows;
};
Built built(const Scene& base, const DocumentPtr& document, std::size_t memory)
{
    Scene scene = scene_of(base, *document);
    load_meshes(scene);
    const std::vector<SplatObject> objects = load_splats(scene, memory);
    build(scene, memory);
    Built made;
    auto numbers = std::make_shared<ObjectNumbers>();
    for (const auto& o : document->objects) {
        const int number = int(numbers->number.size());
        numbers->number[o->id] = {number};
    }
    numbers->materials = scene.setup.materials;
    made.step.document = document, made.step.objects = std::move(numbers);
    const SceneSplats splats(scene, objects);
    if (splats.state().count() > 0)
        made.step.splats = std::make_shared<const CarriedSplats>(splats.state());
    made.rows = std::make_shared<const ClayRows>(rows_of(scene.setup));
    if (has_velocity(*document))
        made.step.beginning = std::make_shared<const InitialState>(scene.setup);
    return made;
}

}  // namespace

RunSession::RunSession(const RunOptions& by, Scene of, Wants what)
    : options(by), base(std::move(of)), wants(what)
{
}

RunSession::~RunSession()
{
    history.reset();
    if (writer) writer->discard();  // the results of the run are in its folder
}

void RunSession::begin(SceneHistory::Parts parts, const Simulator& of,
                       const std::vector<Beginning>& before, const Recording* recording)
{
    simulator = parts.simulator, editor = &parts.editor, loop = &parts.loop;
    splats = &parts.splats, solver = &of, origin = parts.scene.origin;
    on_gpu = parts.simulator && parts.simulator->clay();
    if (parts.simulator && SceneHistory::why_none(parts.scene, *parts.simulator).empty())
        begin_past(parts, before);
    if (wants.file) begin_log(parts, recording);
    first_steps.clear();
    parts.events = [this](const SessionEvent& event) { record(event); };
    parts.captured = [this](const HistoryStep& step, const FutureCapture& made) {
        if (writer) writer->add_step(step, made);
    };
    history = std::make_unique<SceneHistory>(parts, "");
    history->state_loaded();
    hash_state();
}

// Of a log, and with commands before the first frame, which are steps, too. Their clay is built
// only if a command may go back to it.
void RunSession::begin_past(const SceneHistory::Parts& parts, const std::vector<Beginning>& before)
{
    if (before.size() < 2 && !wants.file) return;
    const std::size_t memory =
        options.max_memory > 0 ? std::size_t(options.max_memory * 0x1p20) : available_memory();
    const bool needed = wants.steps || wants.file;
    const auto now =
        std::make_shared<const ClayRows>(parts.simulator->rows(*parts.simulator->snapshot()));
    std::shared_ptr<const ClayRows> last;
    for (std::size_t i = 0; i < before.size(); ++i) {
        Built made;
        if (i + 1 == before.size() || !needed) {
            made.step.document = before[i].document;
            made.step.objects = std::make_shared<const ObjectNumbers>(parts.editor.numbers());
            if (parts.splats.state().count() > 0)
                made.step.splats = std::make_shared<const CarriedSplats>(parts.splats.state());
            made.rows = now;
            if (has_velocity(*before[i].document))
                made.step.beginning =
                    std::make_shared<const InitialState>(parts.simulator->save().contents);
        } else {
            made = built(base, before[i].document, memory);
        }
        made.step.id = StepId(i), made.step.parent = StepId(i > 0 ? i - 1 : 0);
        made.step.label = before[i].label, made.step.captured = true;
        if (i == 0) {
            first_steps.push_back({made.step, {}, made.rows});
            past.begin(std::move(made.step), made.rows);
        } else {
            const Capture from_last = capture_of(*last, made.rows);
            first_steps.push_back({made.step, from_last, made.rows});
            past.insert(std::move(made.step), from_last);
        }
        last = made.rows;
    }
    past.go_to(StepId(before.size() - 1), last);
}

void RunSession::begin_log(const SceneHistory::Parts& parts, const Recording* recording)
{
    SessionMeta meta = new_session();
    meta.device = parts.simulator ? parts.simulator->name() : "cpu:double";
    meta.deterministic = !on_gpu || parts.scene.setup.deterministic;
    meta.stepped = true;
    const std::string path =
        is_standard(options.scene) ? options.scene : fs::absolute(options.scene).string();
    writer = std::make_unique<SessionWriter>(
        meta, SceneSource{path, read_text(options.scene, max_json_bytes), settings_of(options)});
    writer->add(RunBegun{0, parts.editor.document()});
    if (recording)
        for (const HandFrame& frame : recording->frames) writer->add_hands(frame);
    for (std::size_t i = 0; i < first_steps.size(); ++i) {
        const FirstStep& first = first_steps[i];
        if (i == 0) {
            writer->add_beginning(first.step, first.rows);
            continue;
        }
        std::promise<Capture> made;
        made.set_value(first.made);
        writer->add_step(first.step, made.get_future().share());
    }
    if (!first_steps.empty()) writer->add(StepRestored{first_steps.back().step.id});
}

void RunSession::record(const SessionEvent& event)
{
    frames += std::holds_alternative<FrameEvent>(event);
    if (writer) writer->add(event);
}

Motion RunSession::with_motion(Motion motion)
{
    if (history) history->release_tools(motion);
    given = motion;
    return motion;
}

void RunSession::after_frame(const FrameResult& frame)
{
    record(FrameEvent{frame.hand_time,
                      frame.stats.cut ? frame.stats.reached : loop->duration(),
                      frame.stats.cut ? frame.stats.substeps : 0,
                      {},
                      given});
    history->after_frame(frame);
    hash_state();
    if (writer) writer->poll();
}

// Each frame on a CPU, which computes for longer; each 60th on a GPU.
void RunSession::hash_state()
{
    if (!writer || !simulator || (on_gpu && frames % 60 != 0)) return;
    record(HashEvent{frames, hash(simulator->rows(*simulator->snapshot()))});
}

std::optional<Refusal> RunSession::apply(const Command& command)
{
    Situation situation = history->situation(false);
    if (writer) situation.no_save.clear();
    if (const std::string why = row_of(command).why_not(situation); !why.empty())
        return Refusal{why, ""};
    if (const Save* to = std::get_if<Save>(&command)) return save(*to);
    if (const Export* to = std::get_if<Export>(&command))
        if (auto refusal = export_now(*to)) return refusal;
    if (SceneHistory::takes(command))
        return history->apply({command, 0, Origin::script, 0}).refusal;
    record(CommandEvent{{command, 0, Origin::script, 0}});
    return {};
}

std::string RunSession::in_out(const std::string& file) const
{
    return (fs::path(options.out.empty() ? "." : options.out) / file).lexically_normal().string();
}

// Waits for the disk: a run is not in real time.
std::optional<Refusal> RunSession::save(const Save& command)
{
    if (auto why_not = refusal_of(command)) return why_not;
    const std::string to = in_out(command.file);
    history->close();
    StoredState now = editor->stored();
    now.frames = frames, now.time = loop->last().hand_time;
    now.state = simulator->save();
    std::promise<std::string> done;
    writer->save(
        to, command.input.value_or(true), past.count() > 0 ? past.current().id : 0,
        [now] { return now; }, [&done](const std::string& why) { done.set_value(why); });
    not_written = done.get_future().get();
    return {};
}

std::optional<Refusal> RunSession::export_now(const Export& command)
{
    if (auto refusal = editor->refusal_of(command)) return refusal;
    splats->refresh();
    ShownScene shown;
    shown.document = editor->document(), shown.origin = origin;
    shown.numbers = editor->numbers().number;
    shown.surface = [this] { return loop->meshes(); };
    shown.splats = splats->picture();
    shown.gaussians = [this] { return solver->gaussians(); };
    const auto plan = export_plan(*shown.document, command);
    try {
        write_export(fs::absolute(in_out(command.file)).string(), std::get<ExportPlan>(plan),
                     shown);
    } catch (const OutputError& e) {
        not_exported = e.what();
    } catch (const InputError& e) {
        return Refusal{e.what(), "file"};
    } catch (const std::invalid_argument& e) {
        return Refusal{e.what(), ""};
    }
    return {};
}

HistoryInfo RunSession::info() const
{
    if (past.count() == 0) return {};
    return {past.count(), past.bytes(), past.current().id};
}

}  // namespace knead
