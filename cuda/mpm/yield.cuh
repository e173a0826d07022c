// Materials on the device, reduced to the laws that a kernel is compiled for.
#pragma once
#include "cuda/mpm/features.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/views.cuh"

namespace knead::gpu {

// The material restricted to its class, so that the compiler removes the other laws.
template <PlasticityClass plasticity>
__device__ Material<float> narrowed(Material<float> m)
{
    if constexpr (plasticity != PlasticityClass::any) m.elasticity = Elasticity::neo_hookean;
    if constexpr (plasticity == PlasticityClass::elastic) m.plasticity = Plasticity::none;
    if constexpr (plasticity == PlasticityClass::plastic)
        m.plasticity =
            m.plasticity == Plasticity::von_mises ? Plasticity::von_mises : Plasticity::none;
    return m;
}

// The material of an object. A single material is constant within the kernel.
template <Features f>
__device__ Material<float> material_of(const Materials& all, int object)
{
    return narrowed<f.plasticity>(f.mixed ? all[object] : all.first);
}
template <Features f>
__device__ float mass_of(const Materials& all, int object)
{
    return material_of<f>(all, object).mass;
}

}  // namespace knead::gpu
