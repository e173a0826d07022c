// Reports of a verification: lines, Markdown page, CSV, JSON.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/base/machine.h"
#include "host/verify/verify.h"

namespace knead {
namespace {

using Json = nlohmann::json;

const char* verdict_name(Verdict v) { return v == Verdict::passed ? "passed" : "FAILED"; }

const char* sense_name(Sense s)
{
    return s == Sense::near ? "near" : s == Sense::at_most ? "at most" : "at least";
}

std::string bound_text(const Check& c)
{
    if (c.sense == Sense::near) return fmt::format("{:.4g} +- {:.2g}", c.expected, c.bound);
    return fmt::format("{} {:.3g}", c.sense == Sense::at_most ? "<=" : ">=", c.bound);
}

long failures(const Verification& v)
{
    return std::count_if(v.checks.begin(), v.checks.end(),
                         [](const Check& c) { return c.verdict == Verdict::failed; });
}

Json number(double x) { return std::isfinite(x) ? Json(x) : Json(); }

Json check_json(const Check& c)
{
    return {{"suite", c.suite},
            {"name", c.name},
            {"measured", number(c.measured)},
            {"expected", c.sense == Sense::near ? number(c.expected) : Json()},
            {"bound", number(c.bound)},
            {"sense", sense_name(c.sense)},
            {"unit", c.unit},
            {"verdict", verdict_name(c.verdict)},
            {"seconds", c.seconds},
            {"note", c.note},
            {"why", c.verdict == Verdict::passed ? Json("")
                    : c.why.empty()              ? Json()
                                                 : Json(c.why)},
            {"known", known_name(c)},
            {"advice", c.verdict == Verdict::failed ? c.advice : ""}};
}

std::string quoted(std::string text)
{
    for (std::size_t at = 0; (at = text.find('"', at)) != text.npos; at += 2)
        text.insert(at, 1, '"');
    return '"' + text + '"';
}

std::string table_page(const Verification& v, const std::string& table)
{
    std::string head, text;
    for (const VerifyRow& r : v.rows) {
        if (r.table != table) continue;
        std::string names = "| case | outcome |", line = "|---|---|";
        for (const auto& [name, value] : r.numbers) names += " " + name + " |", line += "---|";
        if (names != head) text += "\n" + names + "\n" + line + "\n";
        head = names;
        text += fmt::format("| {} | {} |", r.name, r.outcome);
        for (const auto& [name, value] : r.numbers) text += fmt::format(" {:.4g} |", value);
        text += "\n";
    }
    return "\n## " + table + "\n" + text;
}

}  // namespace

std::string measured_text(const Check& c)
{
    return fmt::format("{:.4g}{}{}, expected {}", c.measured, c.unit.empty() ? "" : " ", c.unit,
                       bound_text(c));
}

std::string verify_text(const Check& c)
{
    std::string text =
        fmt::format("{:<12} {:<58} {:>11.4g}  {:<20} {:<8} {} {:>6.1f} s\n", c.suite, c.name,
                    c.measured, bound_text(c), c.unit, verdict_name(c.verdict), c.seconds);
    if (!c.note.empty()) text += "             " + c.note + "\n";
    if (c.verdict == Verdict::failed && !c.advice.empty())
        text += "             what to do: " + c.advice + "\n";
    return text;
}

std::string verify_summary(const Verification& v)
{
    double seconds = 0;
    for (const Check& c : v.checks) seconds += c.seconds;
    const long unknown = std::count_if(v.checks.begin(), v.checks.end(), [](const Check& c) {
        return c.verdict == Verdict::failed && c.why.empty();
    });
    const std::string of_them =
        unknown > 0 ? fmt::format(", {} of them for no known reason", unknown) : "";
    return fmt::format("{} checks, {} FAILED{}, {:.1f} s\n", v.checks.size(), failures(v), of_them,
                       seconds);
}

Json verify_json(const Verification& v)
{
    Json context = machine_facts(v.device.kind == DeviceKind::cuda);
    context.update({{"executable", "knead verify"},
                    {"suites", v.options.suites},
                    {"quick", v.options.quick},
                    {"device_asked", v.options.device},
                    {"threads_asked", v.options.threads}});
    Json checks = Json::array(), rows = Json::array();
    for (const Check& c : v.checks) checks.push_back(check_json(c));
    for (const VerifyRow& r : v.rows) {
        Json numbers = Json::object();
        for (const auto& [name, value] : r.numbers) numbers[name] = number(value);
        rows.push_back(
            {{"table", r.table}, {"name", r.name}, {"outcome", r.outcome}, {"numbers", numbers}});
    }
    return {{"schema", "knead.verify/1"},
            {"context", context},
            {"checks", checks},
            {"rows", rows},
            {"failed", failures(v)}};
}

std::string verify_csv(const Verification& v)
{
    std::string out = "suite,name,measured,sense,expected,bound,unit,verdict,seconds,known\n";
    for (const Check& c : v.checks)
        out += fmt::format("{},{},{:.9g},{},{},{:.6g},{},{},{:.3f},{}\n", c.suite, quoted(c.name),
                           c.measured, sense_name(c.sense),
                           c.sense == Sense::near ? fmt::format("{:.9g}", c.expected) : "", c.bound,
                           quoted(c.unit), verdict_name(c.verdict), c.seconds, known_name(c));
    for (const VerifyRow& r : v.rows)
        for (const auto& [name, value] : r.numbers)
            out += fmt::format("{},{},{:.9g},,,,{},{},,\n", quoted(r.table), quoted(r.name), value,
                               quoted(name), quoted(r.outcome));
    return out;
}

std::string verify_page(const Verification& v, const std::vector<std::string>& drawings)
{
    std::string text = fmt::format("# Verification\n\n{}, {}; {}. {}", knead_version(),
                                   knead_commit(), cpu_name(), verify_summary(v));
    for (const std::string& name : drawings)
        text += fmt::format("\n![{}]({})\n", name.substr(0, name.find('.')), name);
    std::string suite;
    for (const Check& c : v.checks) {
        if (c.suite != suite)
            text += fmt::format(
                "\n## {}\n\n| check | measured | expected | unit | verdict | seconds "
                "|\n|---|---|---|---|---|---|\n",
                c.suite);
        suite = c.suite;
        text += fmt::format("| {} | {:.4g} | {} | {} | {} | {:.1f} |\n", c.name, c.measured,
                            bound_text(c), c.unit, verdict_name(c.verdict), c.seconds);
    }
    text += failed_page(v.checks);
    std::vector<std::string> tables;
    for (const VerifyRow& r : v.rows)
        if (std::find(tables.begin(), tables.end(), r.table) == tables.end())
            tables.push_back(r.table);
    for (const std::string& table : tables) text += table_page(v, table);
    return text;
}

}  // namespace knead
