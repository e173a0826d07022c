// The suite "undo": what the history of a session costs, on the squeeze. Each 20 frames a command
// begins a step, which is captured 20 frames later.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "host/base/machine.h"
#include "host/bench/bench.h"
#include "host/run/run.h"
#include "host/scene/scene_hands.h"
#include "host/session/scene_history.h"
#include "host/solver/audit.h"

namespace knead {
namespace {

constexpr int frames_a_step = 20;

// A scene that runs with or without a history. Steps begin by commands.
class UndoCase {
  public:
    UndoCase(const Bench& bench, const Scene& of, bool keeps)
        : scene(of),
          hands(hands_of(scene), scene.hands),
          solver(make_solver(scene.setup, bench.device)),
          splats(scene, {}),
          loop(*solver, recorded_motion(&hands, scene.hands), loop_options(scene)),
          editor({scene, splats, loop, solver->editable(), [](const HandsOptions&) {}, {}},
                 std::make_shared<const Document>(document_of(scene)), ids)
    {
        if (solver->clay()) loop.launch_surfaces(true);
        if (!keeps) return;
        history = std::make_unique<SceneHistory>(
            SceneHistory::Parts{scene, splats, loop, solver->editable(), editor, past}, "");
    }

    // Wall time of the next frame, with what the history does after it [s].
    double frame()
    {
        const double start = wall_seconds();
        if (!loop.step()) throw std::runtime_error("the squeeze has ended");
        editor.after_frame(loop.last());
        if (history) follow([&] { history->after_frame(loop.last()); });
        return wall_seconds() - start;
    }
    // Calls the history, and keeps how long it took if it has captured a step.
    template <class Call>
    void follow(const Call& call)
    {
        const bool open = !past.current().captured;
        const double start = wall_seconds();
        call();
        if (open && past.current().captured) stalls.push_back(wall_seconds() - start);
    }
    void change(int round)
    {
        const Issued issued{SetGravity{{0, -9.81 - 1e-6 * (round % 2), 0}}, 0, Origin::script, 0};
        const auto refusal =
            history ? history->apply(issued).refusal : editor.apply(issued.command).refusal;
        if (refusal) throw std::runtime_error(refusal->text());
    }
    // Applies a command of the history and makes the surface, as a window would show it; time [s].
    double timed(const Command& command)
    {
        const double start = wall_seconds();
        if (const auto refusal = history->apply({command, 0, Origin::script, 0}).refusal)
            throw std::runtime_error(refusal->text());
        show();
        return wall_seconds() - start;
    }
    void show()
    {
        if (solver->clay())
            loop.device_mesh();
        else
            loop.meshes();
    }
    std::string hash() const
    {
        return hexadecimal(
            audit(solver->particles(), scene.setup.materials, scene.setup.lattice.dx).hash);
    }

    const Scene& scene;
    HandSource hands;
    std::unique_ptr<Simulator> solver;
    SceneSplats splats;
    SessionLoop loop;
    IdSource ids;
    SceneEditor editor;
    History past;
    std::unique_ptr<SceneHistory> history;
    std::vector<double> stalls;  // of captures [s]
};

void add_row(Bench& bench, const UndoCase& of, const std::string& what, std::vector<double> times,
             const std::string& note)
{
    BenchRow row;
    row.suite = "undo", row.at = double(of.scene.setup.particles.size());
    row.name = fmt::format("undo: {:.3g} particles, {}", row.at, what);
    row.particles = of.scene.setup.particles.size(), row.nodes = of.scene.setup.lattice.size;
    row.frames = row.repeats = int(times.size());
    row.frame = spread(std::move(times));
    row.note = note;
    bench.add(row);
}

double quantile(std::vector<double> values, double share)
{
    std::ranges::sort(values);
    return values[std::size_t(share * double(values.size() - 1))];
}

void undo_case(Bench& bench, int cells, int steps)
{
    const Scene scene = bench.scene(squeeze_on(cells));
    bench.say(fmt::format("undo: {} particles", scene.setup.particles.size()));
    std::vector<double> plain, with, undone, redone;
    {
        UndoCase without(bench, scene, false);
        for (int step = 0; step < steps && !bench.stopped(); ++step)
            for (int k = 0; k < frames_a_step; ++k) {
                if (k == 0) without.change(step);
                const double took = without.frame();
                if (step > 0 && k > 1) plain.push_back(took);
            }
    }
    UndoCase kept(bench, scene, true);
    for (int step = 0; step < steps && !bench.stopped(); ++step)
        for (int k = 0; k < frames_a_step; ++k) {
            if (k == 0) {
                kept.follow([&] { kept.history->close(); });
                kept.change(step);
            }
            const double took = kept.frame();
            if (step > 0 && k > 1) with.push_back(took);
        }
    if (bench.stopped()) return;
    kept.past.resident();
    kept.past.evict();
    const double each = double(kept.past.bytes()) / double(kept.past.count() - 1);
    const double base = spread(plain).median, now = spread(with).median;
    add_row(bench, kept, "frame with history", with,
            fmt::format("without {:.3f} ms: {:+.1f} %", 1e3 * base, 100 * (now / base - 1)));
    const std::vector<double> stalls = kept.stalls;
    add_row(bench, kept, "stall of a capture", stalls,
            fmt::format("first {:.3f}, p99 {:.3f}, most {:.3f} ms", 1e3 * stalls.front(),
                        1e3 * quantile(stalls, 0.99), 1e3 * std::ranges::max(stalls)));
    for (int k = 0; k < (bench.options.quick ? 3 : 12) && !bench.stopped(); ++k) {
        kept.change(k);
        for (int j = 0; j < 5; ++j) kept.frame();
        undone.push_back(kept.timed(Undo{}));
        redone.push_back(kept.timed(Redo{}));
    }
    if (undone.empty()) return;
    add_row(
        bench, kept, "undo, with its surface", undone,
        fmt::format("most {:.1f} ms; redo {:.1f}, most {:.1f} ms", 1e3 * std::ranges::max(undone),
                    1e3 * spread(redone).median, 1e3 * std::ranges::max(redone)));
    bench.result.rows.back().bytes = std::size_t(each);
    bench.result.rows.back().note +=
        fmt::format("; {:.1f} B a particle and step, {:.0f} steps in 256 MiB",
                    each / double(scene.setup.particles.size()), 0x1p28 / each);
}

// What a step costs on the thread that captures it, by each codec: reading the snapshot, encoding,
// hashes. Memory by the mean of all steps.
void codec_case(Bench& bench, int cells, int steps)
{
    const Scene scene = bench.scene(squeeze_on(cells));
    UndoCase of(bench, scene, false);
    EditableSimulator& simulator = *of.solver->editable();
    const auto by = std::make_shared<const Quantisation>(quantisation_of(simulator.config()));
    struct ByCodec {
        const char* name;
        std::shared_ptr<const Quantisation> steps;
        std::shared_ptr<const ClayRows> last{};
        std::vector<double> times{};
        double bytes = 0;  // of a step
    } codecs[] = {{"lossless", nullptr}, {"quantised", by}};
    for (int step = 0; step <= steps && !bench.stopped(); ++step) {
        of.change(step);
        for (int k = 0; k < frames_a_step; ++k) of.frame();
        const std::shared_ptr<const Snapshot> now = simulator.snapshot();
        for (ByCodec& codec : codecs) {
            const double start = wall_seconds();
            ClayRows rows = simulator.rows(*now);
            if (codec.steps) rows = quantised(std::move(rows), *codec.steps);
            auto known = std::make_shared<const ClayRows>(std::move(rows));
            if (step > 0) {
                const Capture made = capture_of(*codec.last, known, codec.steps);
                codec.times.push_back(wall_seconds() - start);
                codec.bytes += double(made.bytes()) / steps;
            }
            codec.last = std::move(known);
        }
    }
    if (bench.stopped()) return;
    const double particles = double(scene.setup.particles.size());
    for (ByCodec& codec : codecs) {
        const double median = spread(codec.times).median;
        add_row(
            bench, of, fmt::format("capture, {}", codec.name), std::move(codec.times),
            fmt::format("{:.2f} B a particle and step, {:.0f} steps in 256 MiB; {:.1f} ns a "
                        "particle",
                        codec.bytes / particles, 0x1p28 / codec.bytes, 1e9 * median / particles));
        bench.result.rows.back().bytes = std::size_t(codec.bytes);
    }
}

// Whether a history changes the bits of a run.
void same_bits_case(Bench& bench, int cells)
{
    Scene scene = bench.scene(squeeze_on(cells));
    scene.setup.deterministic = true;
    std::string hashes[2];
    std::vector<double> times;
    for (const bool keeps : {false, true}) {
        UndoCase one(bench, scene, keeps);
        for (int k = 0; k < 60 && !bench.stopped(); ++k) {
            if (k % frames_a_step == 0) one.change(k / frames_a_step);
            times.push_back(one.frame());
        }
        hashes[keeps] = one.hash();
        if (!keeps) continue;
        add_row(bench, one, "deterministic", times,
                hashes[0] == hashes[1] ? "with history the same bits" : "OTHER BITS with history");
        bench.result.rows.back().hash = hashes[1];
    }
}

}  // namespace

void undo_suite(Bench& bench)
{
    const bool gpu = bench.device.kind == DeviceKind::cuda;
    const bool quick = bench.options.quick;
    // About 100 k and 1 M particles.
    for (int cells : quick ? std::vector<int>{24}
                     : gpu ? std::vector<int>{60, 124}
                           : std::vector<int>{32, 60}) {
        if (!bench.stopped()) undo_case(bench, cells, quick ? 4 : gpu ? 110 : 9);
        if (!bench.stopped()) codec_case(bench, cells, quick ? 3 : 9);
    }
    if (!bench.stopped()) same_bits_case(bench, quick ? 16 : 32);
}

}  // namespace knead
