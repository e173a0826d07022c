// The table of a frame's statistics: whatever it names is summed, merged and reported.
#include "host/solver/frame_stats.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "host/bench/ball.h"
#include "host/run/report.h"
#include "host/scene/scene.h"
#include "host/solver/cpu/solver.h"
#include "tests/solver/followers.h"

namespace knead {
namespace {

// Statistics of which each number is another: first, first + 1, ...
FrameStats numbered(int first)
{
    FrameStats stats;
    each_statistic([&](const auto& row) {
        auto& value = stats[row.member];
        using Value = std::remove_reference_t<decltype(value)>;
        if constexpr (std::is_array_v<Value>)
            for (auto& number : value) number = first++;
        else
            value = Value(first++);
    });
    return stats;
}

TEST(FrameStats, EachHasANameOfItsOwn)
{
    std::set<std::string> names;
    each_statistic([&](const auto& row) {
        EXPECT_TRUE(names.insert(row.name).second) << row.name;
        EXPECT_FALSE(row.stored() && std::string(row.unit).empty()) << row.name;
    });
}

TEST(FrameStats, OfSeveralFramesAreCombinedAsTheirRowsSay)
{
    const FrameStats one = numbered(100), two = numbered(10);
    FrameStats all;
    add_to(all, one), add_to(all, two);
    for (int c = 0; c < int(Count::count); ++c)
        EXPECT_EQ(all[Count(c)], one[Count(c)] + two[Count(c)]) << c;
    EXPECT_EQ(all.substeps, one.substeps + two.substeps);
    for (int l = 0; l < int(Limit::count); ++l)
        EXPECT_EQ(all.limits[l], one.limits[l] + two.limits[l]);
    EXPECT_EQ(all.dt_min, two.dt_min);
    EXPECT_EQ(all.dt_max, one.dt_max);
    EXPECT_EQ(all.found_depth, one.found_depth);
    EXPECT_EQ(all.active_blocks, two.active_blocks);
    EXPECT_EQ(all.touched, one.touched | two.touched);
    EXPECT_TRUE(all.cut);
    EXPECT_EQ(all.reached, two.reached);
    EXPECT_EQ(all.fastest, two.fastest);
    add_to(all, FrameStats{});
    EXPECT_EQ(all.dt_min, two.dt_min) << "a frame without substeps has no shortest one";
}

TEST(FrameStats, TheCpuMergesEachCountOfItsThreads)
{
    ThreadStats threads[3], all;
    int next = 1;
    for (ThreadStats& thread : threads)
        for (int c = 0; c < int(Count::count); ++c) thread[Count(c)] = next *= 2, next %= 1000003;
    for (const ThreadStats& thread : threads) all.add(thread);
    FrameStats stats;
    all.put_into(stats, 0);
    for (int c = 0; c < int(Count::count); ++c) {
        const Count count = Count(c);
        EXPECT_EQ(stats[count], threads[0][count] + threads[1][count] + threads[2][count]) << c;
    }
}

std::vector<std::string> split(const std::string& line)
{
    std::vector<std::string> words;
    std::istringstream in(line);
    for (std::string word; std::getline(in, word, ',');) words.push_back(word);
    return words;
}

TEST(FrameStats, FramesCsvHasEachInItsColumn)
{
    RunRecord record;
    record.rows.resize(1);
    const FrameStats& stats = record.rows[0].stats = numbered(1);
    std::istringstream lines(frames_csv(record));
    std::string head, frame;
    std::getline(lines, head), std::getline(lines, frame);
    EXPECT_EQ(head,
              "frame,simulated_s,hand_s,hands,solver_ms,surface_ms,substeps,dt_min_s,dt_max_s,"
              "active_blocks,moved,woken,yielded,projected,found_depth_mm,clipped,confined,"
              "repaired,abrupt,moved_far,trimmed,kinetic_J,elastic_J,volume_m3,fastest_m_per_s,"
              "left_mean_mm,left_p99_mm,left_max_mm,mesh_m3,triangles,hash");
    const std::vector<std::string> names = split(head), values = split(frame);
    each_statistic([&](const auto& row) {
        if (row.column == 0) return;
        const std::size_t at = 5 + std::size_t(row.column);
        EXPECT_EQ(names.at(at), row.name);
        if constexpr (!std::is_array_v<std::remove_cvref_t<decltype(stats[row.member])>>) {
            EXPECT_EQ(std::stod(values.at(at)), row.scale * double(stats[row.member])) << row.name;
        }
    });
}

TEST(FrameStats, TheReportHasEachWhereItsRowSays)
{
    RunRecord record;
    record.rows.resize(2);
    record.rows[0].stats = numbered(1000), record.rows[1].stats = numbered(1);
    record.particles = 1;
    FrameStats all;
    for (const FrameRow& row : record.rows) add_to(all, row.stats);
    RunInfo facts;
    facts.splats = 1;
    const nlohmann::json knead = report(Scene{}, record, facts)["knead"];
    const auto at = [&](const char* pointer) {
        return knead.at(nlohmann::json::json_pointer(pointer)).get<double>();
    };
    EXPECT_EQ(at("/time/substeps"), all.substeps);
    EXPECT_EQ(at("/time/dt_min_s"), all.dt_min);
    EXPECT_EQ(at("/time/dt_max_s"), all.dt_max);
    EXPECT_EQ(at("/time/limited_by/speed"), double(all.limits[int(Limit::speed)]));
    EXPECT_EQ(at("/penetration/projected"), double(all[Count::projected]));
    EXPECT_EQ(at("/penetration/found_max_mm"), 1e3 * all.found_depth);
    EXPECT_EQ(at("/rest/woken_blocks"), double(all[Count::woken]));
    EXPECT_EQ(at("/trimmed"), double(all[Count::clipped_negligible]));
    EXPECT_EQ(at("/splats/projected"), double(all[Count::splats_projected]));
    EXPECT_EQ(at("/splats/stranded"), double(all[Count::stranded]));
    EXPECT_EQ(at("/splats/repaired"), double(all[Count::splats_repaired]));
    EXPECT_EQ(knead["guards"].size(), frame_guards.size() + 1);  // and crowded
    for (const auto& [name, count] : frame_guards)
        EXPECT_EQ(knead["guards"][name], all[count]) << name;
    each_statistic([&](const auto& row) {
        EXPECT_TRUE(knead.contains(nlohmann::json::json_pointer(row.report))) << row.name;
    });
}

class FastestParticle : public Following {
  protected:
    static double largest_speed(const Simulator& solver)
    {
        double most = 0;
        for (const Particle<double>& p : solver.particles()) most = std::fmax(most, length(p.v));
        return most;
    }
};
INSTANTIATE_TEST_SUITE_P(Solver, FastestParticle,
                         testing::Values(follower_float, follower_reference, follower_cuda),
                         name_of);

TEST_P(FastestParticle, HasTheLargestSpeedAtTheEndOfEachFrame)
{
    const auto solver = make(ball(16));
    for (int f = 0; f < 4; ++f) {
        const double fastest = solver->advance(no_motion(), 1.0 / 90).fastest;
        const double most = largest_speed(*solver);
        EXPECT_GT(most, 0);
        EXPECT_NEAR(fastest, most, 1e-6 * most) << f;
        EXPECT_EQ(solver->advance(no_motion(), 0).fastest, fastest) << "a frame of no length";
    }
}

// Of clay that tools have just put out the speed does not count.
TEST_P(FastestParticle, IsNoneThatWasFoundInATool)
{
    knead::Setup s = ball(32);
    add_tools(s);
    const auto solver = make(s);
    for (int f = 0; f < 6; ++f) {
        const FrameStats stats = solver->advance(closing(f / 90.0, 1.0 / 90), 1.0 / 90);
        EXPECT_GT(stats.fastest, 0);
        EXPECT_LE(stats.fastest, largest_speed(*solver) * (1 + 1e-6)) << f;
    }
}

}  // namespace
}  // namespace knead
