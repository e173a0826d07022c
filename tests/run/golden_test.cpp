// The states that scenes/golden.csv holds, by their hashes: to the bit, where multiply-add is not
// contracted. That is so in a verify build (KNEAD_VERIFY), for all levels of x86-64, and in others
// for the lowest, which has no such instruction. tests/golden.sh writes the table.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "host/base/machine.h"
#include "host/run/run.h"
#include "host/scene/scene_hands.h"
#include "host/scene/seed.h"
#include "host/solver/cpu/levels.h"
#include "tests/sanitized.h"

namespace knead {
namespace {

struct GoldenRow {
    std::string scene, hands;
    std::vector<std::string> settings;
    int frames = 0;
    std::string cpu, gpu;  // hashes; empty: not measured yet
};

std::vector<std::string> parts(const std::string& text, char between)
{
    std::vector<std::string> all;
    std::istringstream in(text + between);
    for (std::string part; std::getline(in, part, between);) all.push_back(part);
    return all;
}

std::vector<GoldenRow> golden_rows()
{
    std::ifstream in("scenes/golden.csv");
    std::vector<GoldenRow> rows;
    std::string line;
    std::getline(in, line);
    EXPECT_EQ(line, "scene,hands,settings,frames,hash_cpu,hash_gpu");
    while (std::getline(in, line)) {
        const std::vector<std::string> cell = parts(line, ',');
        EXPECT_EQ(cell.size(), 6u) << line;
        if (cell.size() != 6) continue;
        GoldenRow row{cell[0], cell[1], {}, std::stoi(cell[3]), cell[4], cell[5]};
        if (!cell[2].empty()) row.settings = parts(cell[2], ' ');
        rows.push_back(row);
    }
    EXPECT_FALSE(rows.empty());
    return rows;
}

#if defined(KNEAD_VERIFY) || !defined(__FMA__)
constexpr bool as_written = true;
#else
constexpr bool as_written = false;
#endif
#ifdef KNEAD_VERIFY
constexpr bool verify_build = true;
#else
constexpr bool verify_build = false;
#endif

// By the level of x86-64; by a GPU, where there is none.
std::string hash_of(const GoldenRow& row, int threads, MakeSolver level)
{
    const bool on_gpu = !level;
    std::vector<std::string> settings = row.settings;
    if (on_gpu) settings.push_back("deterministic=true");
    Scene scene = read_scene("scenes/" + row.scene + ".json", settings);
    if (!row.hands.empty()) scene.hands.recording = "scenes/" + row.hands;
    scene.setup.threads = threads;
    build(scene, available_memory());
    const auto solver = on_gpu ? gpu_solver(scene.setup, 0) : level(scene.setup);
    std::unique_ptr<HandSource> hands;
    if (scene.has_hands) hands = std::make_unique<HandSource>(hands_of(scene), scene.hands);
    BatchRunOptions options;
    options.frames = row.frames, options.audit_every = row.frames;
    const RunRecord record = run_frames(scene, *solver, hands.get(), options, {});
    EXPECT_EQ(record.end, End::complete) << record.failure;
    return record.rows.empty() ? "" : hexadecimal(record.rows.back().state.hash);
}

constexpr const char* changed =
    "; if that is meant: tests/golden.sh --update BUILD, and say in the commit why";

TEST(Golden, EveryShippedSceneIsInTheTableWithAHash)
{
    const std::vector<GoldenRow> rows = golden_rows();
    for (const char* scene : {"cut", "demo", "flatten", "imprint", "knead", "materials", "pinch",
                              "poke", "roll", "squeeze"}) {
        const auto of_scene = [scene](const GoldenRow& row) { return row.scene == scene; };
        EXPECT_NE(std::find_if(rows.begin(), rows.end(), of_scene), rows.end()) << scene;
    }
    for (const GoldenRow& row : rows) EXPECT_EQ(row.cpu.size(), 16u) << row.scene;
}

// Where there is a program for it (knead_golden), it holds all levels of x86-64, and these tests.
#ifndef KNEAD_GOLDEN_APART
class GoldenCpu : public ::testing::TestWithParam<int> {};

TEST_P(GoldenCpu, ScenesEndInTheStatesOfTheTable)
{
    if (!as_written) GTEST_SKIP() << "contraction changes the bits: build with KNEAD_VERIFY";
    if (sanitized && GetParam() == 1) GTEST_SKIP() << "under sanitizers two threads are enough";
    std::vector<MakeSolver> levels = cpu_levels();
    if (!verify_build) levels.resize(1);
    const std::size_t first = GetParam() == 1 ? levels.size() - 1 : 0;  // two threads: all levels
    for (std::size_t level = first; level < levels.size(); ++level)
        for (const GoldenRow& row : golden_rows())
            EXPECT_EQ(hash_of(row, GetParam(), levels[level]), row.cpu)
                << row.scene << ", " << row.frames << " frames, level " << level << changed;
}

INSTANTIATE_TEST_SUITE_P(Threads, GoldenCpu, ::testing::Values(1, 2));
#endif

TEST(Golden, ScenesEndInTheStatesOfTheTableOnAGpuInItsDeterministicMode)
{
    if (!verify_build) GTEST_SKIP() << "contraction changes the bits: build with KNEAD_VERIFY";
    if (!gpu_present()) GTEST_SKIP() << "no GPU";
    for (const GoldenRow& row : golden_rows())
        EXPECT_EQ(hash_of(row, 0, nullptr), row.gpu)
            << row.scene << ", " << row.frames << " frames" << changed << " (... BUILD cuda)";
}

}  // namespace
}  // namespace knead
