// Material functions of a group: vectorised where possible, else per particle.
#pragma once
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"
#include "cuda/mpm/plasticity.h"
#include "host/solver/cpu/group.h"

namespace knead {
inline namespace KNEAD_CPU_LEVEL {

// Kirchhoff stress [Pa] of a group.
template <class R>
inline Sym3<Lanes<R>> stress(const Particle<Lanes<R>>& p, const Group<R>& group,
                             const Material<R>& m)
{
    using L = Lanes<R>;
    if (m.elasticity == Elasticity::neo_hookean && m.plasticity != Plasticity::fluid &&
        m.plasticity != Plasticity::clamp)
        return neo_hookean_stress(p.e, L(m.mu), L(m.lambda));
    Sym3<L> tau;
    for (int l = 0; l < L::count; ++l) {
        const Sym3<R> t = kirchhoff_stress(*group.of[l], m);
        tau.xx.v[l] = t.xx, tau.yy.v[l] = t.yy, tau.zz.v[l] = t.zz;
        tau.xy.v[l] = t.xy, tau.xz.v[l] = t.xz, tau.yz.v[l] = t.yz;
    }
    return tau;
}

// Bit mask of the lanes that need the return map: for neo-Hookean von Mises clay those near or
// beyond the yield stress, for other plastic materials all.
template <class R>
inline unsigned near_yield_mask(const Particle<Lanes<R>>& p, const Material<R>& m)
{
    using L = Lanes<R>;
    constexpr unsigned all = (1u << L::count) - 1;
    if (m.plasticity == Plasticity::none) return 0;
    if (m.plasticity != Plasticity::von_mises || m.elasticity != Elasticity::neo_hookean)
        return all;
    const auto calm = surely_elastic(m, p.e, p.k);
    unsigned lanes = 0;
    for (int l = 0; l < L::count; ++l) lanes |= unsigned(calm[l] == 0) << l;
    return lanes;
}

}  // namespace KNEAD_CPU_LEVEL
}  // namespace knead
