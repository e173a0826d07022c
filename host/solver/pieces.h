// After a cut: which clay hangs together, and which labels it still needs.
#pragma once
#include <vector>

#include "cuda/contact/cut.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/particle.h"
#include "cuda/splats/deform.h"
#include "host/solver/cpu/tools.h"

namespace knead {

// Pieces of clay, by cells of the lattice: two cells hang together if they touch and do not carry
// opposite labels. Fills piece[i] for every particle, the largest piece first; returns their
// number.
template <class R>
int pieces(const std::vector<Particle<R>>& q, const Lattice<R>& lattice, std::vector<int>& piece);

// Gives whole pieces the labels they need: none where no other piece is within reach, opposite ones
// where two are; a piece that is cut but not through keeps its own.
template <class R>
void relabel(std::vector<Particle<R>>& q, const Lattice<R>& lattice);

// Before a new stroke: pieces that it touches forget what an old one told them, except along the
// faces with which they lie within reach of other pieces. height[i] is that of particle i over the
// blade [m], 0 where none is near; any particle may change its label to the other, all together.
template <class R>
void forget(std::vector<Particle<R>>& q, const Lattice<R>& lattice, const std::vector<R>& height);

// Gaussians take the label of the nearest particle within a cell or two: of those that had the same
// label as they before, where there are any. before[i] was that of particle i.
template <class R>
void follow_labels(std::vector<Gaussian<R>>& splats, const std::vector<Particle<R>>& q,
                   const std::vector<std::uint32_t>& before, const Lattice<R>& lattice);
// Those from splats[from] on are new: of particles of the same object, where there are any.
template <class R>
void take_labels(std::vector<Gaussian<R>>& splats, std::size_t from,
                 const std::vector<Particle<R>>& q, const Lattice<R>& lattice);

// At the end of a frame, in which a blade covered clay or not: a stroke that begins forgets old
// labels in its way, one that has ended leaves whole pieces. mask_at(x): the primitives that may
// matter at x. Gaussians follow. True if labels may have changed.
template <class R, class MaskAt>
bool relabel_pieces(std::vector<Particle<R>>& q, std::vector<Gaussian<R>>& splats,
                    const Lattice<R>& lattice, const Colliders<R>& tools, MaskAt&& mask_at,
                    bool covered, bool was_covered)
{
    if (covered == was_covered) return false;
    std::vector<std::uint32_t> before(splats.empty() ? 0 : q.size());
    for (std::size_t i = 0; i < before.size(); ++i) before[i] = q[i].label();
    if (covered) {
        std::vector<R> height(q.size(), 0);
        for (std::size_t i = 0; i < q.size(); ++i)
            for_each_blade(tools, mask_at(q[i].x), q[i].x, lattice.dx,
                           [&](const Seen<R>& b, const Tool<R>&) { height[i] = b.h; });
        forget(q, lattice, height);
    } else {
        relabel(q, lattice);
    }
    follow_labels(splats, q, before, lattice);
    return true;
}
template <class R>
bool relabel_pieces(std::vector<Particle<R>>& q, std::vector<Gaussian<R>>& splats,
                    const Lattice<R>& lattice, const PosedTools<R>& posed, bool covered,
                    bool was_covered)
{
    const auto mask_at = [&](Vec3<R> x) -> const Mask& { return posed.mask_at(lattice, x); };
    return relabel_pieces(q, splats, lattice, posed.colliders(), mask_at, covered, was_covered);
}

}  // namespace knead
