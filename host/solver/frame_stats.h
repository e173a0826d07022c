// Statistics of a frame and the table that describes them. Sums over frames, guards, checkpoints,
// frames.csv and report.json are made by the table: a new counter needs its name in Count
// (cuda/mpm/counts.h), its row here and the place that counts.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <utility>

#include "cuda/mpm/counts.h"
#include "cuda/mpm/time_step.h"

namespace knead {

extern const char* const limit_names[int(Limit::count)];

struct FrameStats {
    Counts<long> counts{};
    // 0: nothing was simulated. On a GPU so are frames without clay, and frames cut at their start;
    // on the CPU a frame has at least one.
    int substeps = 0;
    double dt_min = 0, dt_max = 0;        // [s]; 0 without substeps
    double found_depth = 0;               // largest penetration before projection [m]
    long active_blocks = 0;               // in the last substep
    long limits[int(Limit::count)] = {};  // substeps limited by each criterion
    std::uint32_t touched = 0;  // bits, tool_bit(): tools with particles inside or at a blade
    bool cut = false;           // ended early by the StopCheck or the bound
    double reached = 0;         // if cut: simulated part of the frame [s]
    // Largest particle speed at the frame's end, as it limits the next substep: without particles
    // that the last substep found in a tool (speed_that_counts() in project.h) [m/s].
    double fastest = 0;
    int welded_bodies = 0;  // pairs that are close and share a velocity field, see bodies.h

    // A statistic by the `member` of its row.
    long& operator[](Count c) { return counts[c]; }
    const long& operator[](Count c) const { return counts[c]; }
    template <class T>
    T& operator[](T FrameStats::*member)
    {
        return this->*member;
    }
    template <class T>
    const T& operator[](T FrameStats::*member) const
    {
        return this->*member;
    }
};

enum class StatKind {
    figure,
    guard,     // number of corrections, 0 in a sound run; in "guards" of reports by its name
    transient  // for the caller of advance() only: in no checkpoint and no table of a report
};

template <class Member, class Combine>
struct Statistic {
    Member member;     // a Count, or a pointer to a member of FrameStats
    const char* name;  // in reports
    const char* unit;  // in reports
    double scale;      // from SI units to `unit`, of real numbers
    StatKind kind;
    Combine combine;  // combine(all, frame) adds a later frame
    int column;       // in frames.csv, among the statistics, from 1; 0: none
    // JSON pointer in "knead" of report.json, written if the object around it exists; "": none
    const char* report;

    constexpr bool stored() const { return kind != StatKind::transient; }
};

namespace frame_table {

// How the statistics of several frames are combined.
struct Sum {
    template <class T>
    void operator()(T& all, const T& frame) const
    {
        all += frame;
    }
    template <class T, std::size_t n>
    void operator()(T (&all)[n], const T (&frame)[n]) const
    {
        for (std::size_t i = 0; i < n; ++i) all[i] += frame[i];
    }
};
struct Smallest {  // of positive numbers; 0: none, as of a frame without substeps
    void operator()(double& all, double frame) const
    {
        if (frame > 0) all = all > 0 ? std::min(all, frame) : frame;
    }
};
struct Largest {
    void operator()(double& all, double frame) const { all = std::max(all, frame); }
    void operator()(int& all, int frame) const { all = std::max(all, frame); }
};
struct Last {
    template <class T>
    void operator()(T& all, const T& frame) const
    {
        all = frame;
    }
};
struct Any {
    void operator()(bool& all, bool frame) const { all = all || frame; }
    void operator()(std::uint32_t& all, std::uint32_t frame) const { all |= frame; }
};

template <class Member, class Combine>
constexpr Statistic<Member, Combine> figure(Member member, const char* name, const char* unit,
                                            Combine combine, int column, const char* report,
                                            double scale = 1)
{
    return {member, name, unit, scale, StatKind::figure, combine, column, report};
}
constexpr Statistic<Count, Sum> guard(Count count, const char* name, const char* unit, int column)
{
    return {count, name, unit, 1, StatKind::guard, Sum{}, column, ""};
}
template <class Member, class Combine>
constexpr Statistic<Member, Combine> transient(Member member, const char* name, const char* unit,
                                               Combine combine)
{
    return {member, name, unit, 1, StatKind::transient, combine, 0, ""};
}

// Checkpoints store the rows in this order: append new rows, and raise the version of the
// checkpoint if they are stored.
constexpr std::tuple rows{
    figure(&FrameStats::substeps, "substeps", "substeps", Sum{}, 1, "/time/substeps"),
    figure(&FrameStats::dt_min, "dt_min_s", "s", Smallest{}, 2, "/time/dt_min_s"),
    figure(&FrameStats::dt_max, "dt_max_s", "s", Largest{}, 3, "/time/dt_max_s"),
    figure(Count::yielded, "yielded", "particle-substeps", Sum{}, 7, ""),
    figure(Count::projected, "projected", "particle-substeps", Sum{}, 8, "/penetration/projected"),
    guard(Count::clipped, "clipped", "node-substeps", 10),
    guard(Count::confined, "confined", "particle-substeps", 11),
    guard(Count::repaired, "repaired", "particle-substeps", 12),
    guard(Count::abrupt, "abrupt", "particle-substeps", 13),
    guard(Count::moved_far, "moved_far", "particle-substeps", 14),
    figure(Count::clipped_negligible, "trimmed", "node-substeps", Sum{}, 15, "/trimmed"),
    figure(&FrameStats::found_depth, "found_depth_mm", "mm", Largest{}, 9,
           "/penetration/found_max_mm", 1e3),
    figure(&FrameStats::active_blocks, "active_blocks", "blocks", Last{}, 4, ""),
    figure(Count::moved, "moved", "particle-substeps", Sum{}, 5, ""),
    figure(Count::woken, "woken", "blocks", Sum{}, 6, "/rest/woken_blocks"),
    figure(Count::stranded, "stranded", "Gaussian-substeps", Sum{}, 0, "/splats/stranded"),
    figure(Count::splats_projected, "splats_projected", "Gaussian-substeps", Sum{}, 0,
           "/splats/projected"),
    figure(Count::splats_repaired, "splats_repaired", "Gaussian-substeps", Sum{}, 0,
           "/splats/repaired"),
    figure(&FrameStats::limits, "limited_by", "substeps", Sum{}, 0, "/time/limited_by"),
    transient(Count::covered, "covered", "particle-substeps", Sum{}),
    transient(&FrameStats::touched, "touched", "tools", Any{}),
    transient(&FrameStats::cut, "cut", "", Any{}),
    transient(&FrameStats::reached, "reached", "s", Last{}),
    transient(&FrameStats::fastest, "fastest", "m/s", Last{}),
    transient(&FrameStats::welded_bodies, "welded_bodies", "pairs", Largest{})};

}  // namespace frame_table

// Calls visit(row) for each statistic.
template <class Visit>
constexpr void each_statistic(Visit&& visit)
{
    std::apply([&](const auto&... row) { (visit(row), ...); }, frame_table::rows);
}

template <class Member>
constexpr bool is_count = std::is_same_v<Member, Count>;

namespace frame_table {

// Fails to compile if a member of FrameStats is missing here. All but `counts` have a row.
constexpr auto figures(const FrameStats& stats)
{
    const auto& [counts, substeps, dt_min, dt_max, found_depth, active_blocks, limits, touched, cut,
                 reached, fastest, welded_bodies] = stats;
    return std::tie(substeps, dt_min, dt_max, found_depth, active_blocks, limits, touched, cut,
                    reached, fastest, welded_bodies);
}
constexpr std::size_t figure_count =
    std::tuple_size_v<decltype(figures(std::declval<const FrameStats&>()))>;

// Whether there is one row per Count, and as many others as figures.
constexpr bool complete()
{
    int of[int(Count::count)] = {};
    std::size_t others = 0;
    each_statistic([&]<class Member, class Combine>(const Statistic<Member, Combine>& row) {
        if constexpr (is_count<Member>)
            ++of[int(row.member)];
        else
            ++others;
    });
    for (const int times : of)
        if (times != 1) return false;
    return others == figure_count;
}
static_assert(complete(), "each statistic needs exactly one row");

}  // namespace frame_table

constexpr int statistic_columns = [] {
    int last = 0;
    each_statistic([&](const auto& row) { last = std::max(last, row.column); });
    return last;
}();
static_assert(
    [] {
        std::array<int, std::size_t(statistic_columns) + 1> used{};
        each_statistic([&](const auto& row) { ++used[std::size_t(row.column)]; });
        return std::all_of(used.begin() + 1, used.end(), [](int rows) { return rows == 1; });
    }(),
    "each column of frames.csv needs exactly one row");

// Calls visit(number) for each number that a checkpoint stores, in the order of the file.
template <class Stats, class Visit>
void each_stored_number(Stats& stats, Visit&& visit)
{
    each_statistic([&](const auto& row) {
        if (!row.stored()) return;
        auto& value = stats[row.member];
        if constexpr (std::is_array_v<std::remove_reference_t<decltype(value)>>)
            for (auto& number : value) visit(number);
        else
            visit(value);
    });
}

// Adds a later frame to the statistics of earlier ones.
inline void add_to(FrameStats& all, const FrameStats& frame)
{
    each_statistic([&](const auto& row) { row.combine(all[row.member], frame[row.member]); });
}

struct FrameGuard {
    const char* name;
    Count count;
};

constexpr std::size_t guard_count = [] {
    std::size_t count = 0;
    each_statistic([&](const auto& row) { count += row.kind == StatKind::guard; });
    return count;
}();
constexpr std::array<FrameGuard, guard_count> frame_guards = [] {
    std::array<FrameGuard, guard_count> guards{};
    std::size_t at = 0;
    each_statistic([&]<class Member, class Combine>(const Statistic<Member, Combine>& row) {
        if constexpr (is_count<Member>)
            if (row.kind == StatKind::guard) guards[at++] = {row.name, row.member};
    });
    return guards;
}();

// Number of corrections by all guards.
inline long guards_of(const FrameStats& stats)
{
    long sum = 0;
    for (const FrameGuard& guard : frame_guards) sum += stats[guard.count];
    return sum;
}

}  // namespace knead
