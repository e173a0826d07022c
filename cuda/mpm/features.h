// What a scene uses, and for which of it kernels are compiled, so that a scene pays for nothing
// else. This is the only place that lists it: a new feature is an entry in Features, rows in
// `compiled`, and the stages' own files.
#pragma once
#include <cstddef>

namespace knead {

// neo-Hookean without and with von Mises; everything. Each has all that the one before it has.
enum class PlasticityClass { elastic, plastic, any };

struct Features {
    bool tools = false;
    bool fixed_point = false;  // sums that do not depend on their order
    bool blades = false;       // three velocity fields: see cuda/contact/cut.h
    bool rests = false;        // clay may be still
    bool mixed = false;        // not one object's clay alone
    PlasticityClass plasticity = PlasticityClass::elastic;
    bool mean_pressure = false;  // some clay shares its cell's: see mean_pressure.h
    bool splats = false;  // Gaussians follow the clay: the stage deform runs, others do not change
    bool operator==(const Features&) const = default;

    // Whether kernels that are compiled for this serve a scene that uses `other`. Of splats none
    // asks: their stage runs or does not.
    constexpr bool include(const Features& other) const
    {
        return tools >= other.tools && fixed_point >= other.fixed_point && blades >= other.blades &&
               rests >= other.rests && mixed >= other.mixed && plasticity >= other.plasticity &&
               mean_pressure >= other.mean_pressure;
    }
};

// Particles that a thread block takes at a time: three fields fill shared memory sooner.
constexpr int run_length(const Features& features) { return features.blades ? 64 : 128; }

// All combinations that kernels are compiled for, each with and without fixed_point. The first that
// includes what a scene uses serves it. Scenes with blades, or in which clay may be still, have
// tools or run as if they had. One object alone is told apart where that was measured to pay: of
// clay, near tools. Without tools a kernel for it would spill.
inline constexpr Features compiled[] = {
    {.mixed = true, .plasticity = PlasticityClass::elastic},
    {.mixed = true, .plasticity = PlasticityClass::plastic},
    {.mixed = true, .plasticity = PlasticityClass::any},
    {.tools = true, .plasticity = PlasticityClass::elastic},
    {.tools = true, .plasticity = PlasticityClass::plastic},
    {.tools = true, .mixed = true, .plasticity = PlasticityClass::elastic},
    {.tools = true, .mixed = true, .plasticity = PlasticityClass::plastic},
    {.tools = true, .mixed = true, .plasticity = PlasticityClass::any},
    {.tools = true, .rests = true, .mixed = true, .plasticity = PlasticityClass::plastic},
    {.tools = true, .rests = true, .mixed = true, .plasticity = PlasticityClass::any},
    {.tools = true, .blades = true, .mixed = true, .plasticity = PlasticityClass::any},
    {.tools = true,
     .blades = true,
     .rests = true,
     .mixed = true,
     .plasticity = PlasticityClass::any},
    {.mixed = true, .plasticity = PlasticityClass::plastic, .mean_pressure = true},
    {.mixed = true, .plasticity = PlasticityClass::any, .mean_pressure = true},
    {.tools = true, .mixed = true, .plasticity = PlasticityClass::plastic, .mean_pressure = true},
    {.tools = true, .mixed = true, .plasticity = PlasticityClass::any, .mean_pressure = true},
    {.tools = true,
     .rests = true,
     .mixed = true,
     .plasticity = PlasticityClass::any,
     .mean_pressure = true},
    {.tools = true,
     .blades = true,
     .mixed = true,
     .plasticity = PlasticityClass::any,
     .mean_pressure = true},
    {.tools = true,
     .blades = true,
     .rests = true,
     .mixed = true,
     .plasticity = PlasticityClass::any,
     .mean_pressure = true},
};

constexpr std::size_t combinations = 2 * sizeof compiled / sizeof compiled[0];
constexpr Features combination(std::size_t k)
{
    Features f = compiled[k / 2];
    f.fixed_point = k % 2 == 1;
    return f;
}

// A combination as a type: nvcc (13.0) takes no structure for a kernel's template argument.
template <bool tools, bool fixed_point, bool blades, bool rests, bool mixed,
          PlasticityClass plasticity, bool mean_pressure>
struct Case {
    static constexpr Features features{tools, fixed_point, blades,       rests,
                                       mixed, plasticity,  mean_pressure};
};
template <Features f>
using CaseOf =
    Case<f.tools, f.fixed_point, f.blades, f.rests, f.mixed, f.plasticity, f.mean_pressure>;

// What kernel(Case) answers for the first combination that serves. `relevant` leaves of Features
// what the stage depends on: the rest does not make it another kernel.
template <auto relevant, std::size_t k = 0, class Kernel>
auto dispatch(const Features& used, Kernel&& kernel)
{
    constexpr Features served = relevant(combination(k));
    if constexpr (k + 1 < combinations)
        if (!served.include(relevant(used))) return dispatch<relevant, k + 1>(used, kernel);
    return kernel(CaseOf<served>{});
}

}  // namespace knead
