// Materials on the device: of each what a kernel is compiled for.
#pragma once
#include "cuda/mpm/features.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/views.cuh"

namespace knead::gpu {

// The material as those of its class are, so that the compiler leaves out the rest.
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

// The material of an object. Where there is one, its numbers are constants to the kernel.
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
