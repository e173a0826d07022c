// What a microbenchmark tells, and the table of it. Without CUDA, so that main.cpp needs none.
#pragma once
#include <map>
#include <string>
#include <vector>

namespace knead::micro {

// What bounds the card, measured in the same run.
struct Limits {
    int multiprocessors = 0;
    double clock = 0;  // of a multiprocessor under load [Hz]
    double copy = 0;   // bytes read and written by a plain copy [1/s]
    double adds = 0;   // vector atomics to the cache of level 2, spread over it [1/s]
    // Warp instructions per second.
    double issue() const { return 4.0 * multiprocessors * clock; }
};

// One form of one piece of work.
struct Row {
    std::string question, what;
    std::string unit;    // what is counted
    double count = 0;    // of these in one run
    double seconds = 0;  // a run, median; 0 where runs are only counted
    double max = 0;      // of these per second by the limit that matters; 0: by issue alone
    std::string limit;   // its name
    bool right = false;  // the result was what it must be
    std::string note;    // "", or a figure that belongs to the form
};

struct Settings {
    std::string only;  // questions whose name holds this
    int repeats = 15;  // timed runs of a form
    std::string once;  // run each form once, in a profiler range, and write their names here
};

// Warp instructions of one run by "question/what", as instructions.py writes them.
using Instructions = std::map<std::string, double>;
// Throws std::runtime_error if it is no such table.
Instructions instructions_from(const std::string& path);

std::string name_of(const Row& row);
void print(const std::vector<Row>& rows, const Limits& limits, const Instructions& counted);
// `header` is a line of what the results depend on. Throws std::runtime_error.
void write_csv(const std::string& path, const std::string& header, const std::vector<Row>& rows,
               const Limits& limits, const Instructions& counted);
void write_json(const std::string& path, const std::string& facts, const std::vector<Row>& rows,
                const Limits& limits, const Instructions& counted);

// All benchmarks, in order. Throws std::runtime_error where the device fails.
std::vector<Row> measured(const Settings& settings, Limits& limits);

}  // namespace knead::micro
