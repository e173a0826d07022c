// The features of a scene, and the combinations that kernels are compiled for, so that a scene does
// not pay for features it does not use. A new feature is an entry in Features, rows in `compiled`,
// and the stages' own files.
#pragma once
#include <cstddef>

namespace knead {

// elastic: neo-Hookean; plastic: also neo-Hookean with von Mises; any: all laws.
enum class PlasticityClass { elastic, plastic, any };

struct Features {
    bool tools = false;
    bool fixed_point = false;  // sums are independent of their order
    bool blades = false;       // three velocity fields: see cuda/contact/cut.h
    bool rests = false;        // sleep: clay may be still
    bool mixed = false;        // particles of more than one object
    PlasticityClass plasticity = PlasticityClass::elastic;
    bool mean_pressure = false;  // some materials use cell-averaged pressure: see mean_pressure.h
    bool bodies = false;         // a velocity field per colour: see body_contact.h
    int colours = 0;             // how many: only decides what memory is needed; with blades each
                                 // has labels_of_clay fields
    bool splats = false;  // Gaussians follow the clay: the stage deform runs, others do not change
    bool operator==(const Features&) const = default;

    // Whether kernels compiled for this set serve a scene that uses `other`. `splats` and `colours`
    // are ignored: they decide which stages run, and on how many fields.
    constexpr bool include(const Features& other) const
    {
        return tools >= other.tools && fixed_point >= other.fixed_point && blades >= other.blades &&
               rests >= other.rests && mixed >= other.mixed && plasticity >= other.plasticity &&
               mean_pressure >= other.mean_pressure && bodies >= other.bodies;
    }
};

// Velocity fields at each node.
constexpr int field_count(const Features& features)
{
    if (features.bodies) return 1 + features.colours * (features.blades ? 3 : 1);
    return features.blades ? 3 : 1;
}

// Whether a particle scatters to several fields: with blades, but without bodies, whose fields
// are disjoint.
constexpr bool shares_fields(const Features& features)
{
    return features.blades && !features.bodies;
}

// Particles per thread block at a time: sums for three fields fill shared memory sooner.
constexpr int run_length(const Features& features) { return shares_fields(features) ? 64 : 128; }

// All combinations that kernels are compiled for, each with and without fixed_point. A scene uses
// the first that includes its features. Scenes with blades or sleep use kernels with tools. Kernels
// for a single object exist only where that was measured to pay: near tools. Without tools they
// would spill.
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
    {.tools = true, .mixed = true, .plasticity = PlasticityClass::any, .bodies = true},
    {.tools = true,
     .rests = true,
     .mixed = true,
     .plasticity = PlasticityClass::any,
     .bodies = true},
    {.tools = true,
     .mixed = true,
     .plasticity = PlasticityClass::any,
     .mean_pressure = true,
     .bodies = true},
    {.tools = true,
     .rests = true,
     .mixed = true,
     .plasticity = PlasticityClass::any,
     .mean_pressure = true,
     .bodies = true},
    {.tools = true,
     .blades = true,
     .mixed = true,
     .plasticity = PlasticityClass::any,
     .bodies = true},
    {.tools = true,
     .blades = true,
     .mixed = true,
     .plasticity = PlasticityClass::any,
     .mean_pressure = true,
     .bodies = true},
    {.tools = true,
     .blades = true,
     .rests = true,
     .mixed = true,
     .plasticity = PlasticityClass::any,
     .bodies = true},
    {.tools = true,
     .blades = true,
     .rests = true,
     .mixed = true,
     .plasticity = PlasticityClass::any,
     .mean_pressure = true,
     .bodies = true},
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
          PlasticityClass plasticity, bool mean_pressure, bool bodies>
struct Case {
    static constexpr Features features{tools, fixed_point, blades,        rests,
                                       mixed, plasticity,  mean_pressure, bodies};
};
template <Features f>
using CaseOf = Case<f.tools, f.fixed_point, f.blades, f.rests, f.mixed, f.plasticity,
                    f.mean_pressure, f.bodies>;

// Returns kernel(Case) for the first combination that serves. `relevant` clears the features that
// the stage does not depend on, so that they do not multiply its kernels.
template <auto relevant, std::size_t k = 0, class Kernel>
auto dispatch(const Features& used, Kernel&& kernel)
{
    constexpr Features served = relevant(combination(k));
    if constexpr (k + 1 < combinations)
        if (!served.include(relevant(used))) return dispatch<relevant, k + 1>(used, kernel);
    return kernel(CaseOf<served>{});
}

}  // namespace knead
