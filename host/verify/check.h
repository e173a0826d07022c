// One line of knead verify: a measured number, what it should be, and how far off it may be.
#pragma once
#include <cmath>
#include <string>
#include <utility>

namespace knead {

enum class Verdict { passed, failed };
enum class Sense { near, at_most, at_least };

struct Check {
    std::string suite, name;
    double measured = 0;
    double expected = 0;  // by the reference; Sense::near alone
    double bound = 0;     // near: of |measured - expected|; else of what is measured
    Sense sense = Sense::near;
    std::string unit;
    Verdict verdict = Verdict::failed;
    double seconds = 0;
    std::string note;    // what else was seen
    std::string advice;  // what a user should do where it failed
    std::string why;     // it is known to fail, by known.json; "": not known to
};

// A number that is none passes nothing.
inline Verdict verdict_of(Sense sense, double measured, double expected, double bound)
{
    const bool held = sense == Sense::near      ? std::fabs(measured - expected) <= bound
                      : sense == Sense::at_most ? measured <= bound
                                                : measured >= bound;
    return held && std::isfinite(measured) ? Verdict::passed : Verdict::failed;
}

// For what has no more to say. All bounds are in the unit.
inline Check checked(Sense sense, std::string name, double measured, double expected, double bound,
                     std::string unit, std::string advice)
{
    Check c{};
    c.name = std::move(name), c.unit = std::move(unit), c.advice = std::move(advice);
    c.measured = measured, c.expected = expected, c.bound = bound, c.sense = sense;
    c.verdict = verdict_of(sense, measured, expected, bound);
    return c;
}
inline Check near(std::string name, double measured, double expected, double bound,
                  std::string unit, std::string advice = "")
{
    return checked(Sense::near, std::move(name), measured, expected, bound, std::move(unit),
                   std::move(advice));
}
inline Check at_most(std::string name, double measured, double bound, std::string unit,
                     std::string advice = "")
{
    return checked(Sense::at_most, std::move(name), measured, 0, bound, std::move(unit),
                   std::move(advice));
}
inline Check at_least(std::string name, double measured, double bound, std::string unit,
                      std::string advice = "")
{
    return checked(Sense::at_least, std::move(name), measured, 0, bound, std::move(unit),
                   std::move(advice));
}

// What was measured and what was allowed, with the unit.
std::string measured_text(const Check& check);

}  // namespace knead
