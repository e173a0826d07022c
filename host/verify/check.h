// One line of knead verify: measured value, reference value and tolerance.
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
    double expected = 0;  // reference value; only for Sense::near
    double bound = 0;     // near: bound of |measured - expected|; else of the measured value
    Sense sense = Sense::near;
    std::string unit;
    Verdict verdict = Verdict::failed;
    double seconds = 0;
    std::string note;    // further observations
    std::string advice;  // advice to users if it fails
    std::string why;     // reason in known.json why it fails; "": none
};

// NaN and infinity always fail.
inline Verdict verdict_of(Sense sense, double measured, double expected, double bound)
{
    const bool held = sense == Sense::near      ? std::fabs(measured - expected) <= bound
                      : sense == Sense::at_most ? measured <= bound
                                                : measured >= bound;
    return held && std::isfinite(measured) ? Verdict::passed : Verdict::failed;
}

// A check without note. Bounds have the unit of the check.
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

// Measured value and tolerance with the unit, as text.
std::string measured_text(const Check& check);

}  // namespace knead
