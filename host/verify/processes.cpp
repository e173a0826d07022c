// Runs cases in separate processes: a crash of one does not affect the others.
#include <fmt/format.h>
#include <string.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "host/base/child.h"
#include "host/base/errors.h"
#include "host/base/interrupt.h"
#include "host/base/machine.h"
#include "host/solver/frame_stats.h"
#include "host/verify/cases.h"

namespace knead {
namespace {

using Json = nlohmann::json;

constexpr double start = 30;  // startup allowance of a process [s]

constexpr std::pair<const char*, double Outcome::*> numbers[] = {
    {"energy", &Outcome::energy},       {"energy_gain", &Outcome::energy_gain},
    {"fastest", &Outcome::fastest},     {"volume", &Outcome::volume},
    {"simulated", &Outcome::simulated}, {"seconds", &Outcome::seconds},
    {"crowded", &Outcome::crowded},     {"densest", &Outcome::densest}};

std::vector<std::string> words_of(const Verification& v, const Case& c)
{
    std::vector<std::string> words{
        v.options.program, "verify",
        "--case",          c.name,
        "--device",        v.options.device,
        "--threads",       v.device.kind == DeviceKind::cuda ? "0" : "1"};
    if (v.quick()) words.push_back("--quick");
    return words;
}

std::string reason(int code, double limit)
{
    if (code == ended_late) return fmt::format("hung: ended after {:.0f} s", limit);
    if (code <= ended_by_signal) return fmt::format("ended with exit code {}", code);
    const int by = code - ended_by_signal;
    return fmt::format("ended by signal {} ({})", by, strsignal(by));
}

int at_a_time(const Verification& v)
{
    if (v.device.kind == DeviceKind::cuda) return 1;
    return v.options.threads > 0 ? v.options.threads : cpu_count();
}

}  // namespace

Json json_of(const Outcome& o)
{
    Json all{{"ending", ending_name(o.ending)},
             {"note", o.note},
             {"substeps", o.stats.substeps},
             {"dt_min", o.stats.dt_min}};
    for (const auto& [name, place] : numbers) all[name] = o.*place;  // NaN becomes null
    for (const auto& [name, count] : frame_guards) all[name] = o.stats[count];
    return all;
}

Outcome parse_outcome(const Json& all)
{
    Outcome o;
    const auto ending = all.at("ending").get<std::string>();
    for (const Ending e : {Ending::stable, Ending::guarded, Ending::slow, Ending::refused})
        if (ending == ending_name(e)) o.ending = e;  // default: failed
    o.note = all.at("note").get<std::string>();
    o.stats.substeps = all.at("substeps").get<int>();
    o.stats.dt_min = all.at("dt_min").get<double>();
    for (const auto& [name, place] : numbers)
        o.*place = all.at(name).is_null() ? std::nan("") : all.at(name).get<double>();
    for (const auto& [name, count] : frame_guards) o.stats[count] = all.at(name).get<long>();
    return o;
}

Outcome outcome_by(const std::vector<std::string>& words, double late)
{
    std::string said;
    const int code = output_of(words, said, late);
    Outcome o;
    try {
        if (code == exit_ok) return parse_outcome(Json::parse(said));
        o.note = reason(code, late);
    } catch (const Json::exception&) {
        o.note = "told no outcome";
    }
    return o;
}

double limit_of(const Verification& v, const Case& c)
{
    const double limit = c.limit > 0 ? c.limit : v.quick() ? 8 : 60;
    return v.options.device == "reference" ? 2 * limit : limit;
}

Outcome outcome_alone(const Verification& v, const Case& c)
{
    const double limit = limit_of(v, c);
    if (v.options.program.empty()) return outcome_of(v, c, limit);
    return outcome_by(words_of(v, c), 2 * limit + start);
}

void outcomes_of(const Verification& v, const std::vector<Case>& cases,
                 const std::function<void(const Case&, const Outcome&)>& report)
{
    std::vector<std::optional<Outcome>> all(cases.size());
    std::atomic<std::size_t> next = 0;
    std::mutex lock;
    std::condition_variable ready;
    const auto work = [&] {
        for (std::size_t i = next++; i < cases.size() && !interrupted(); i = next++) {
            Outcome o;
            try {
                o = outcome_alone(v, cases[i]);
            } catch (const std::exception& e) {
                o.note = e.what();
            }
            const std::lock_guard held(lock);
            all[i] = o;
            ready.notify_one();
        }
        const std::lock_guard held(lock);
        ready.notify_one();  // after an interrupt: no more outcomes
    };
    const int count = v.options.program.empty() ? 1 : at_a_time(v);
    std::vector<std::jthread> workers;
    workers.reserve(std::size_t(count));
    for (int i = 0; i < count; ++i) workers.emplace_back(work);
    for (std::size_t i = 0; i < cases.size(); ++i) {
        std::unique_lock held(lock);
        ready.wait(held, [&] { return all[i] || interrupted(); });
        if (!all[i]) break;
        held.unlock();
        report(cases[i], *all[i]);
    }
}

}  // namespace knead
