#include "profiling/micro/table.h"

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "host/base/outputs.h"

namespace knead::micro {
namespace {

// What the columns show beside the row itself; 0 where it cannot be told.
struct Figures {
    double nanoseconds, billions;      // each; a second
    double cycles;                     // of a multiprocessor, each
    double share;                      // of the row's limit
    double instructions, issue_share;  // of a warp, each; of what the card can issue
};

Figures figures(const Row& r, const Limits& l, const Instructions& counted)
{
    Figures f{};
    const auto found = counted.find(name_of(r));
    const double instructions = found == counted.end() ? 0 : found->second;
    f.instructions = instructions / r.count;
    if (r.seconds <= 0) return f;
    f.nanoseconds = 1e9 * r.seconds / r.count;
    f.billions = 1e-9 * r.count / r.seconds;
    f.cycles = r.seconds * l.clock * l.multiprocessors / r.count;
    f.issue_share = instructions / r.seconds / l.issue();
    f.share = r.max > 0 ? r.count / r.seconds / r.max : f.issue_share;
    return f;
}

std::string text(const char* format, double x)
{
    if (x == 0) return "-";
    char line[64];
    std::snprintf(line, sizeof line, format, x);
    return line;
}

}  // namespace

std::string name_of(const Row& row) { return row.question + "/" + row.what; }

Instructions instructions_from(const std::string& path)
{
    std::ifstream in(path);
    std::string line;
    if (!in || !std::getline(in, line) || line != "instructions,name")
        throw std::runtime_error(path + ": not a table of instructions (instructions,name)");
    Instructions counted;
    while (std::getline(in, line)) {
        std::istringstream words(line);
        double count = 0;
        char comma = 0;
        std::string name;
        if (!(words >> count >> comma) || comma != ',' || !std::getline(words, name) || count < 0)
            throw std::runtime_error(path + ": not a number and a name: " + line.substr(0, 80));
        counted[name] = count;
    }
    return counted;
}

void print(const std::vector<Row>& rows, const Limits& limits, const Instructions& counted)
{
    std::printf("%d multiprocessors at %.0f MHz, copy %.2f TB/s, %.1f G vector atomics/s\n",
                limits.multiprocessors, 1e-6 * limits.clock, 1e-12 * limits.copy,
                1e-9 * limits.adds);
    std::string question;
    for (const Row& r : rows) {
        if (r.question != question) {
            question = r.question;
            std::printf("\n%-58s %11s %8s %9s %7s %-8s %7s %6s\n", question.c_str(), "ns each",
                        "G/s", "cycles", "share", "of", "instr.", "issue");
        }
        const Figures f = figures(r, limits, counted);
        std::printf("  %-56s %11s %8s %9s %7s %-8s %7s %6s%s%s%s\n", r.what.c_str(),
                    text("%.5f", f.nanoseconds).c_str(), text("%.3f", f.billions).c_str(),
                    text("%.3f", f.cycles).c_str(), text("%.1f%%", 100 * f.share).c_str(),
                    r.limit.c_str(), text("%.2f", f.instructions).c_str(),
                    text("%.0f%%", 100 * f.issue_share).c_str(), r.note.empty() ? "" : "  ",
                    r.note.c_str(), r.right ? "" : "  WRONG");
    }
}

void write_csv(const std::string& path, const std::string& header, const std::vector<Row>& rows,
               const Limits& limits, const Instructions& counted)
{
    std::ostringstream out;
    out << "# " << header << "\n"
        << "question,what,unit,count,seconds,ns_each,G_per_s,cycles_each,limit,share,"
           "warp_instructions_each,share_of_issue,right,note\n";
    for (const Row& r : rows) {
        const Figures f = figures(r, limits, counted);
        out << r.question << ",\"" << r.what << "\"," << r.unit << ',' << r.count << ','
            << r.seconds << ',' << f.nanoseconds << ',' << f.billions << ',' << f.cycles << ','
            << r.limit << ',' << f.share << ',' << f.instructions << ',' << f.issue_share << ','
            << r.right << ",\"" << r.note << "\"\n";
    }
    write_whole(path, out.str());
}

void write_json(const std::string& path, const std::string& facts, const std::vector<Row>& rows,
                const Limits& limits, const Instructions& counted)
{
    using Json = nlohmann::ordered_json;
    Json table = Json::array();
    for (const Row& r : rows) {
        const Figures f = figures(r, limits, counted);
        table.push_back({{"question", r.question},
                         {"what", r.what},
                         {"unit", r.unit},
                         {"count", r.count},
                         {"seconds", r.seconds},
                         {"per_second", 1e9 * f.billions},
                         {"multiprocessor_cycles_each", f.cycles},
                         {"limit", r.limit},
                         {"share", f.share},
                         {"warp_instructions_each", f.instructions},
                         {"share_of_issue", f.issue_share},
                         {"right", r.right},
                         {"note", r.note}});
    }
    const Json all{{"context", Json::parse(facts)},
                   {"limits",
                    {{"multiprocessors", limits.multiprocessors},
                     {"clock_Hz", limits.clock},
                     {"copy_bytes_per_second", limits.copy},
                     {"vector_atomics_per_second", limits.adds},
                     {"warp_instructions_per_second", limits.issue()}}},
                   {"benchmarks", table}};
    write_whole(path, all.dump(1) + "\n");
}

}  // namespace knead::micro
