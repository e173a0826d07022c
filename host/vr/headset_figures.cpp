#include "host/vr/headset_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/run/report.h"

namespace knead {
namespace {

constexpr std::size_t max_frames = 90 * 3600;

float percentile(std::vector<float> values, double share)
{
    if (values.empty()) return 0;
    const auto at = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

nlohmann::json spread_of(const std::vector<float>& values)
{
    return {{"median", percentile(values, 0.5)},
            {"p95", percentile(values, 0.95)},
            {"p99", percentile(values, 0.99)},
            {"max", percentile(values, 1)}};
}

nlohmann::json least_of(const std::vector<float>& shares)
{
    return {{"median", percentile(shares, 0.5)}, {"min", percentile(shares, 0)}};
}

}  // namespace

void FrameFigures::add(const FrameParts& frame)
{
    if (frame.work() > frame.period) ++late;
    if (!frame.within(2)) ++far_late;
    if (frame.period > 0 && frame.interval > 0)
        left_out += std::max(0L, std::lround(frame.interval / frame.period) - 1);
    if (!frame.within(1) && listed.size() < most_listed) listed.push_back({frames, frame});
    ++frames;
    last.push_back(frame);
    if (last.size() > kept) last.erase(last.begin());
    if (work.size() >= max_frames) return;
    work.push_back(float(1e3 * frame.work()));
    draw.push_back(float(1e3 * frame.draw));
    scale.push_back(frame.scale);
    if (frame.splats > 0) {
        splats.push_back(float(1e3 * frame.splats));
        splat_scale.push_back(frame.splat_scale);
    }
    if (frame.latency < 0) return;
    latency.push_back(float(1e3 * frame.latency));
    latency_frames.push_back(frame.period > 0 ? float(frame.latency / frame.period) : 0);
}

double FrameFigures::margin() const
{
    if (last.empty()) return 1;
    double sum = 0;
    for (const FrameParts& frame : last) sum += frame.margin();
    return sum / double(last.size());
}

nlohmann::json FrameFigures::figures() const
{
    nlohmann::json report = {{"frames", frames},
                             {"longer_than_a_period", late},
                             {"longer_than_two_periods", far_late},
                             {"left_out", left_out},
                             {"work_ms", spread_of(work)},
                             {"draw_ms", spread_of(draw)},
                             {"eye_scale", least_of(scale)}};
    if (!latency.empty()) {
        report["motion_to_dent_ms"] = spread_of(latency);
        report["motion_to_dent_frames"] = spread_of(latency_frames);
    }
    report["late_frames"] = nlohmann::json::array();
    for (const auto& [number, parts] : listed)
        report["late_frames"].push_back({{"frame", number},
                                         {"interval_ms", 1e3 * parts.interval},
                                         {"work_ms", 1e3 * parts.work()},
                                         {"locate_ms", 1e3 * parts.locate},
                                         {"simulate_ms", 1e3 * parts.simulate},
                                         {"draw_ms", 1e3 * parts.draw},
                                         {"submit_ms", 1e3 * parts.submit}});
    if (!splats.empty()) {
        report["splat_scale"] = least_of(splat_scale);
        report["splats_ms"] = spread_of(splats);
    }
    return report;
}

std::string FrameFigures::summary() const
{
    const auto least = [](const std::vector<float>& shares) {
        return fmt::format("{:.0f} %, {:.0f} % at least",
                           shares.empty() ? 100.f : 100 * percentile(shares, 0.5),
                           shares.empty() ? 100.f : 100 * percentile(shares, 0));
    };
    std::string report = fmt::format(
        "frames        {}, of which {} took longer than the display's\n"
        "work          {:.2f} ms median, {:.2f} ms p95, {:.2f} ms p99\n"
        "drawing       {:.2f} ms median, {:.2f} ms p99; eye resolution {}\n",
        frames, late, percentile(work, 0.5), percentile(work, 0.95), percentile(work, 0.99),
        percentile(draw, 0.5), percentile(draw, 0.99), least(scale));
    if (!latency.empty())
        report +=
            fmt::format("motion to dent {:.1f} ms median, {:.2f} display frames; p95 {:.2f}\n",
                        percentile(latency, 0.5), percentile(latency_frames, 0.5),
                        percentile(latency_frames, 0.95));
    if (!splats.empty())
        report +=
            fmt::format("splats        {:.2f} ms median, {:.2f} ms p99; relative resolution {}\n",
                        percentile(splats, 0.5), percentile(splats, 0.99), least(splat_scale));
    return report;
}

}  // namespace knead
