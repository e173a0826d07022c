// Runs: the loop, what it counts, what it writes, how it ends.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cuda/mpm/material.h"
#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/cli/verbs.h"
#include "host/files/mesh_reader.h"
#include "host/files/particle_file.h"
#include "host/hands/recording.h"
#include "host/run/report.h"
#include "host/scene/scene_hands.h"
#include "host/scene/seed.h"
#include "host/session/backend.h"
#include "tests/folder.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

const char* const small_ball = R"({
    "schema": "knead.scene/1", "name": "small",
    "domain": {"edge": 0.32, "cells": 32}, "gravity": [0, 0, 0],
    "objects": [{"centre": [0.16, 0.16, 0.16], "diameter": 0.1,
                 "material": {"preset": "clay", "young": 1e5}}]
})";

class RunFolder : public InFolder {
  protected:
    void SetUp() override
    {
        InFolder::SetUp();
        write_whole(path("scene.json"), small_ball);
    }
    void TearDown() override
    {
        fs::permissions(folder, fs::perms::owner_all, fs::perm_options::add);
        InFolder::TearDown();
    }
    RunOptions quick(const std::string& out) const
    {
        RunOptions o;
        o.scene = path("scene.json"), o.device = "cpu", o.frames = 2, o.quiet = true;
        if (!out.empty()) o.out = path(out);
        return o;
    }
    static int code(const std::function<int()>& verb)
    {
        testing::internal::CaptureStderr();
        const int result = run_and_report(verb);
        last_message() = testing::internal::GetCapturedStderr();
        return result;
    }
    static std::string& last_message()
    {
        static std::string text;
        return text;
    }
};

// A solver that plays back what a test wants to see.
class Played : public Simulator, private StageProfile {
  public:
    explicit Played(const Setup& setup) : state(setup.particles) {}
    FrameStats advance(const Motion& motion, double duration) override
    {
        ++frames;
        motions.push_back(motion);
        durations.push_back(duration);
        if (frames == lost_at) throw std::runtime_error("cuda: gone");
        if (frames == broken_at) state[0].v.x = std::nan("");
        FrameStats t;
        t.substeps = 1, t.dt_min = t.dt_max = duration, t.limits[0] = 1;
        t[Count::repaired] = frames == repaired_at ? long(state.size()) : 0;
        t[Count::moved] = frames == moved_at;
        if (t[Count::moved]) state.resize(state.size() / 2);
        return t;
    }
    std::vector<Particle<double>> particles() const override { return state; }
    std::vector<double> penetration() const override { return {0.001, 0.002, 0.003}; }
    const StageProfile* profile() const override { return this; }
    std::size_t memory() const override { return 1; }
    std::string name() const override { return "played"; }

    int frames = 0, broken_at = 0, lost_at = 0, repaired_at = 0, moved_at = 0;
    std::vector<Particle<double>> state;
    std::vector<Motion> motions;
    std::vector<double> durations;

  private:
    const std::vector<StageTime>& times() const override { return stages; }
    std::vector<StageTime> stages{{"stage", 0.25}};
};

Scene built(const std::string& file, const std::vector<std::string>& settings = {})
{
    Scene s = read_scene(file, settings);
    build(s, std::size_t(1) << 32);
    return s;
}

TEST_F(RunFolder, EveryFrameIsAdvancedByTheClock)
{
    const Scene wall = built(path("scene.json"));
    Played a(wall.setup), b(wall.setup);
    BatchRunOptions options;
    options.frames = 3;
    run_frames(wall, a, nullptr, options, {});
    EXPECT_EQ(a.durations, std::vector<double>(3, 1.0 / 90));
    const Scene paper = built(path("scene.json"), {"clock=paper"});
    run_frames(paper, b, nullptr, options, {});
    ASSERT_EQ(b.durations.size(), 3u);
    EXPECT_DOUBLE_EQ(b.durations[0], 5e-4);
}

TEST_F(RunFolder, MeshesStandWhileNothingMoves)
{
    const Scene scene = built(path("scene.json"));
    for (const int every : {1, 2}) {
        Played solver(scene.setup);
        solver.moved_at = 3;
        BatchRunOptions options;
        options.frames = 4, options.mesh_every = every;
        const RunRecord r = run_frames(scene, solver, nullptr, options, {});
        ASSERT_EQ(r.rows.size(), 4u);
        EXPECT_TRUE(r.rows[1].kept && !r.rows[2].kept);
        EXPECT_EQ(r.rows[1].mesh_volume, r.first_mesh_volume);
        EXPECT_EQ(r.rows[2].meshed, every == 1);
        EXPECT_EQ(r.rows[3].kept, every == 1);
        EXPECT_LT(r.rows[3].mesh_volume, 0.9 * r.first_mesh_volume);
        EXPECT_EQ(left_at_rest(r).back(),
                  every == 1 ? "surface: of 4 meshed frames in 3 nothing had moved"
                             : "surface: of 2 meshed frames in 1 nothing had moved");
    }
}

TEST_F(RunFolder, EachFrameOfHandsBeginsWhereTheLastEnded)
{
    const Scene scene = built(path("scene.json"), {"hands.recording=squeeze", "hands.zoom=0.5"});
    const HandSource hands(hands_of(scene), scene.hands);
    Played solver(scene.setup);
    BatchRunOptions options;
    options.frames = 60;
    const RunRecord record = run_frames(scene, solver, &hands, options, {});
    bool active = false, moved = false;
    for (std::size_t f = 1; f < solver.motions.size(); ++f) {
        ASSERT_EQ(solver.motions[f].from.size(), std::size_t(2 * joint_count));
        EXPECT_EQ(solver.motions[f].from[wrist].p.x, solver.motions[f - 1].to[wrist].p.x);
        active = active || solver.motions[f].active == std::vector<char>{1, 1};
        moved = moved || solver.motions[f].from[wrist].p.x != solver.motions[f].to[wrist].p.x;
        EXPECT_EQ(record.rows[f].hands, solver.motions[f].active != (std::vector<char>{0, 0}));
    }
    EXPECT_TRUE(active);
    EXPECT_TRUE(moved);
}

TEST_F(RunFolder, ABrokenNumberEndsTheRunWithTheLastGoodState)
{
    const Scene scene = built(path("scene.json"));
    Played solver(scene.setup);
    solver.broken_at = 2;
    BatchRunOptions options;
    options.frames = 5;
    const RunRecord record = run_frames(scene, solver, nullptr, options, {});
    EXPECT_EQ(record.end, End::numerical_failure);
    EXPECT_EQ(record.rows.size(), 2u);
    ASSERT_FALSE(record.last_good->empty());
    EXPECT_TRUE(std::isfinite((*record.last_good)[0].v.x));
    EXPECT_NE(record.failure.find("frame 2"), std::string::npos);
}

TEST_F(RunFolder, GuardsThatRepairTooMuchAreAFailure)
{
    const Scene scene = built(path("scene.json"));
    Played solver(scene.setup);
    solver.repaired_at = 1;
    BatchRunOptions options;
    options.frames = 5;
    EXPECT_EQ(run_frames(scene, solver, nullptr, options, {}).end, End::numerical_failure);
}

TEST_F(RunFolder, ALostDeviceKeepsTheFramesBeforeIt)
{
    const Scene scene = built(path("scene.json"));
    Played solver(scene.setup);
    solver.lost_at = 3;
    BatchRunOptions options;
    options.frames = 5;
    const RunRecord record = run_frames(scene, solver, nullptr, options, {});
    EXPECT_EQ(record.end, End::device);
    EXPECT_EQ(record.rows.size(), 2u);
    const Json all = report(scene, record, {});
    EXPECT_EQ(all["knead"]["end"], "device lost");
}

TEST_F(RunFolder, AnInterruptEndsAfterTheFrameAndIsAudited)
{
    const Scene scene = built(path("scene.json"));
    Played solver(scene.setup);
    BatchRunOptions options;
    options.frames = 50, options.audit_every = 100;
    RunObserver watch;
    watch.stop = [&] { return solver.frames == 4; };
    const RunRecord record = run_frames(scene, solver, nullptr, options, watch);
    EXPECT_EQ(record.end, End::interrupted);
    ASSERT_EQ(record.rows.size(), 4u);
    EXPECT_TRUE(record.rows.back().audited);
    EXPECT_FALSE(record.rows[1].audited);
    EXPECT_EQ(record.frames_wanted, 50);
}

TEST_F(RunFolder, TheReportHoldsWhatTheRunDid)
{
    const Scene scene = built(path("scene.json"));
    Played solver(scene.setup);
    BatchRunOptions options;
    options.frames = 4;
    const Json all = report(scene, run_frames(scene, solver, nullptr, options, {}), {});
    EXPECT_EQ(all["schema"], "knead.report/1");
    EXPECT_EQ(all["runs"][0]["name"], "small/frame");
    EXPECT_EQ(all["runs"][0]["time_unit"], "ms");
    const Json& k = all["knead"];
    EXPECT_EQ(k["frames"], 4);
    EXPECT_DOUBLE_EQ(k["stages"]["stage"]["median_ms"].get<double>(), 250);
    EXPECT_EQ(k["time"]["limited_by"]["sound"], 4);
    EXPECT_TRUE(k["mass"]["exact"].get<bool>());
    EXPECT_NEAR(k["penetration"]["left_mean_mm"].get<double>(), 2, 1e-9);
    EXPECT_NEAR(k["penetration"]["left_max_mm"].get<double>(), 3, 1e-9);
    EXPECT_EQ(k["penetration"]["left_count"], 12);
    EXPECT_NEAR(k["volume"]["drift"].get<double>(), 0, 1e-12);
    EXPECT_EQ(k["state_hash"].get<std::string>().size(), 16u);
}

TEST_F(RunFolder, AFreeBallKeepsItsMomentumMassAndVolume)
{
    Scene scene = built(path("scene.json"), {"objects.0.velocity=[0.5,0,0]"});
    const auto solver = cpu_solver(scene.setup);
    BatchRunOptions options;
    options.frames = 3;
    const RunRecord record = run_frames(scene, *solver, nullptr, options, {});
    const Audit &first = record.first, &last = record.rows.back().state;
    EXPECT_EQ(first.mass, last.mass);
    EXPECT_NEAR(last.momentum.x, first.mass * 0.5, 1e-4 * first.mass * 0.5);
    EXPECT_NEAR(last.volume, first.volume, 1e-4 * first.volume);
    EXPECT_NEAR(last.kinetic, first.kinetic, 1e-3 * first.kinetic);
}

TEST_F(RunFolder, WritesAReportACsvAMeshAndParticles)
{
    RunOptions o = quick("out");
    o.particles = true, o.mesh = "ply";
    ASSERT_EQ(code([&] { return run_verb(o); }), exit_ok) << last_message();
    const Json all = read_json(path("out/report.json"));
    EXPECT_EQ(all["knead"]["end"], "complete");
    std::ifstream csv(path("out/frames.csv"));
    int lines = 0;
    std::size_t commas = 0;
    for (std::string line; std::getline(csv, line); ++lines) {
        const auto here = std::size_t(std::count(line.begin(), line.end(), ','));
        EXPECT_EQ(here, lines ? commas : here) << line;
        commas = here;
    }
    EXPECT_EQ(lines, 3);
    const std::vector<Mesh> meshes = read_mesh(path("out/mesh.ply"));
    EXPECT_NEAR(volume(meshes[0]), 3.14159 / 6 * 1e-3, 0.1 * 5.2e-4);
    EXPECT_EQ(read_particles(path("out/particles.ply")).size(),
              all["knead"]["particles"].get<std::size_t>());
}

TEST_F(RunFolder, ClayAtRestIsToldAsLeftOut)
{
    RunOptions o = quick("out");
    o.frames = 12, o.settings = {"rest.mode=sleep"};  // it sleeps from the ninth frame on
    ASSERT_EQ(code([&] { return run_verb(o); }), exit_ok) << last_message();
    const Json k = read_json(path("out/report.json"))["knead"];
    EXPECT_EQ(k["rest"]["mode"], "sleep");
    EXPECT_DOUBLE_EQ(k["rest"]["moved_share"].get<double>(), 8.0 / 12);
    EXPECT_EQ(k["rest"]["woken_blocks"], 0);
    EXPECT_NE(k["left_out"].dump().find("clay at rest: 33.3 % of all"), std::string::npos);
    EXPECT_NE(summary(read_json(path("out/report.json"))).find("66.67 %"), std::string::npos);
    const auto named = left_out(built(path("scene.json")), {});
    EXPECT_EQ(std::count(named.begin(), named.end(), "sleep: not asked for (/rest/mode)"), 1);
}

TEST_F(RunFolder, ResultsThatAreThereAreKept)
{
    ASSERT_EQ(code([&] { return run_verb(quick("out")); }), exit_ok) << last_message();
    const std::string before = read_text(path("out/report.json"), 1 << 24);
    EXPECT_EQ(code([&] { return run_verb(quick("out")); }), exit_output);
    EXPECT_NE(last_message().find("--overwrite"), std::string::npos);
    EXPECT_EQ(read_text(path("out/report.json"), 1 << 24), before);
    RunOptions o = quick("out");
    o.overwrite = true;
    EXPECT_EQ(code([&] { return run_verb(o); }), exit_ok) << last_message();
}

TEST_F(RunFolder, OutputsThatCannotBeAreRefusedBeforeTheWork)
{
    EXPECT_EQ(code([&] { return run_verb(quick("scene.json")); }), exit_output);
    EXPECT_EQ(code([&] { return run_verb(quick("scene.json/below")); }), exit_output);
    RunOptions nowhere = quick("");
    nowhere.out = "/proc/knead";
    EXPECT_EQ(code([&] { return run_verb(nowhere); }), exit_output);
}

TEST_F(RunFolder, ExitCodesSayWhatIsWrong)
{
    RunOptions o = quick("");
    o.device = "gpu";
    EXPECT_EQ(code([&] { return run_verb(o); }), exit_usage);
    o.device = "cuda:4096";
    EXPECT_EQ(code([&] { return run_verb(o); }), exit_resource);
    o = quick("");
    o.settings = {"objects.0.diameter=-1"};
    EXPECT_EQ(code([&] { return run_verb(o); }), exit_input);
    o.settings = {"objects.0.per_cell=64"};
    o.max_memory = 1;
    EXPECT_EQ(code([&] { return run_verb(o); }), exit_resource);
    o = quick("");
    o.video = true;
    EXPECT_EQ(code([&] { return run_verb(o); }), exit_usage);
    o = quick("");
    o.hands = path("absent.hands");
    o.settings = {"hands.zoom=0.5"};
    EXPECT_EQ(code([&] { return run_verb(o); }), exit_input);
}

TEST_F(RunFolder, EqualRunsCompareEqualAndOthersDoNot)
{
    RunOptions first = quick("a"), second = quick("b"), third = quick("c");
    first.particles = second.particles = third.particles = true;
    first.threads = 1, second.threads = 2;
    third.settings = {"objects.0.velocity=[0.1,0,0]"};
    for (const RunOptions& o : {first, second, third})
        ASSERT_EQ(code([&] { return run_verb(o); }), exit_ok) << last_message();
    CompareOptions c;
    const auto compare = [&](const std::string& a, const std::string& b) {
        c.first = path(a), c.second = path(b);
        testing::internal::CaptureStdout();
        const int result = code([&] { return compare_verb(c); });
        testing::internal::GetCapturedStdout();
        return result;
    };
    EXPECT_EQ(compare("a/report.json", "b/report.json"), exit_ok);
    EXPECT_EQ(compare("a/particles.ply", "b/particles.ply"), exit_ok);
    EXPECT_EQ(compare("a/report.json", "c/report.json"), exit_check);
    EXPECT_EQ(compare("a/particles.ply", "c/particles.ply"), exit_check);
    EXPECT_EQ(compare("a/particles.ply", "c/report.json"), exit_input);
    c.tolerance = 0.01;
    EXPECT_EQ(compare("a/particles.ply", "c/particles.ply"), exit_ok);
}

TEST_F(RunFolder, RecordingsAreWrittenAndConverted)
{
    RecordOptions r;
    r.gesture = "poke", r.out = path("poke.hands"), r.quiet = true;
    ASSERT_EQ(code([&] { return record_verb(r); }), exit_ok) << last_message();
    EXPECT_EQ(code([&] { return record_verb(r); }), exit_output);
    ConvertOptions c{path("poke.hands"), path("poke.jsonl"), false, true};
    ASSERT_EQ(code([&] { return convert_verb(c); }), exit_ok) << last_message();
    EXPECT_EQ(read_recording(c.in).frames.size(), read_recording(c.out).frames.size());
    c.out = path("poke.glb");
    EXPECT_EQ(code([&] { return convert_verb(c); }), exit_usage);
    r.gesture = "juggle", r.out = path("juggle.hands");
    EXPECT_EQ(code([&] { return record_verb(r); }), exit_input);
}

TEST(Audit, EnergyIsWhatTheStressDoesWork)
{
    for (const std::string& name : preset_names()) {
        Material<double> m = preset(name);
        Particle<double> q{};
        // A uniform stretch s = exp(u): dW/du = tr tau.
        const auto at = [&](double u) {
            q.e = isotropic(std::expm1(2 * u));
            return stored_energy(q, m);
        };
        const double u = -0.004, h = 1e-5;
        const double slope = (at(u + h) - at(u - h)) / (2 * h);
        at(u);
        const double work = trace(kirchhoff_stress(q, m));
        EXPECT_NEAR(slope, work, 1e-4 * std::abs(work)) << name;
    }
}

}  // namespace
}  // namespace knead
