// Clay as the quantised codec of the history keeps it: numbers that are multiples of steps.
#pragma once
#include <vector>

#include "cuda/history/quantise.h"
#include "host/solver/clay_rows.h"
#include "host/solver/setup.h"

namespace knead {

// The steps of a configuration's clay.
struct Quantisation {
    float x = 0;                // [m]
    Vec3<float> low{}, high{};  // between the walls: whole numbers of `x` steps
    std::vector<float> e;       // by object; powers of two [1]
    float of_object(std::int32_t object) const
    {
        return object >= 0 && std::size_t(object) < e.size() ? e[std::size_t(object)] : e_step;
    }
};
Quantisation quantisation_of(const SimulationConfig& config);

// Rows that the simulator accepts if it accepts these: no particle and no Gaussian leaves the
// walls. Objects and sides stay. quantised(quantised(rows)) = quantised(rows), to the bit.
ClayRows quantised(ClayRows rows, const Quantisation& steps);

}  // namespace knead
