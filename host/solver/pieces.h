// After a cut: the connected pieces of clay, and the labels that they still need.
#pragma once
#include <vector>

#include "cuda/contact/cut.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/particle.h"
#include "cuda/splats/deform.h"
#include "host/solver/bodies.h"
#include "host/solver/cpu/tools.h"

namespace knead {

// Connected pieces of clay, by cells of the lattice: two cells are connected if they touch and do
// not carry opposite labels. Fills piece[i] for every particle, largest piece first; returns the
// number of pieces.
template <class R>
int pieces(const std::vector<Particle<R>>& q, const Lattice<R>& lattice, std::vector<int>& piece);

// Assigns labels to complete pieces: opposite labels to two pieces within reach of each other, none
// to a piece without another one in reach. A piece that is cut only partially keeps its labels.
template <class R>
void relabel(std::vector<Particle<R>>& q, const Lattice<R>& lattice);

// Before a new stroke: clears old labels of the pieces that it touches, except along faces within
// reach of other pieces. height[i]: signed height of particle i over the blade [m], 0 if no blade
// is near. May swap the two labels of all particles.
template <class R>
void forget(std::vector<Particle<R>>& q, const Lattice<R>& lattice, const std::vector<R>& height);

// Gaussians take the label of the nearest particle within a cell or two, preferably of a particle
// whose previous label equals the Gaussian's. before[i]: previous label of particle i.
template <class R>
void follow_labels(std::vector<Gaussian<R>>& splats, const std::vector<Particle<R>>& q,
                   const std::vector<std::uint32_t>& before, const Lattice<R>& lattice);
// Labels new Gaussians, splats[from] and following, by the nearest particle, preferably of the same
// object.
template <class R>
void take_labels(std::vector<Gaussian<R>>& splats, std::size_t from,
                 const std::vector<Particle<R>>& q, const Lattice<R>& lattice);

// Calls visit(clay, Gaussians, their indices in q) for the clay of each colour, by object, and
// stores their labels; for all clay if there are no colours. Labels part clay of one colour only,
// and clay of two colours is not connected.
template <class R, class Visit>
void for_each_colour(std::vector<Particle<R>>& q, std::vector<Gaussian<R>>& splats,
                     const std::vector<int>& colour, int colours, Visit&& visit)
{
    for (int c = 1; c <= colours; ++c) {
        std::vector<std::size_t> of_clay, of_splats;
        std::vector<Particle<R>> clay;
        std::vector<Gaussian<R>> followers;
        for (std::size_t i = 0; i < q.size(); ++i)
            if (colour[std::size_t(q[i].object)] == c) of_clay.push_back(i), clay.push_back(q[i]);
        for (std::size_t i = 0; i < splats.size(); ++i)
            if (colour[std::size_t(splats[i].object)] == c)
                of_splats.push_back(i), followers.push_back(splats[i]);
        visit(clay, followers, of_clay);
        for (std::size_t i = 0; i < clay.size(); ++i) q[of_clay[i]].sides = clay[i].sides;
        for (std::size_t i = 0; i < followers.size(); ++i)
            splats[of_splats[i]].sides = followers[i].sides;
    }
    if (colours > 0) return;
    std::vector<std::size_t> all(q.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
    visit(q, splats, all);
}

// At the end of a frame. `covered`: a blade was in the clay. The start of a stroke clears old
// labels near the blade; its end labels complete pieces, colour by colour. mask_at(x): candidate
// primitives at x. Gaussians follow. Returns true if labels may have changed.
template <class R, class MaskAt>
bool relabel_pieces(std::vector<Particle<R>>& q, std::vector<Gaussian<R>>& splats,
                    const Lattice<R>& lattice, const Bodies& bodies, const Colliders<R>& tools,
                    MaskAt&& mask_at, bool covered, bool was_covered)
{
    if (covered == was_covered) return false;
    std::vector<R> height(covered ? q.size() : 0, 0);
    for (std::size_t i = 0; i < height.size(); ++i)
        for_each_blade(tools, mask_at(q[i].x), q[i].x, lattice.dx,
                       [&](const Seen<R>& b, const Tool<R>&) { height[i] = b.h; });
    for_each_colour(q, splats, bodies.colour, bodies.colours,
                    [&](std::vector<Particle<R>>& clay, std::vector<Gaussian<R>>& followers,
                        const std::vector<std::size_t>& at) {
                        std::vector<std::uint32_t> before(followers.empty() ? 0 : clay.size());
                        for (std::size_t i = 0; i < before.size(); ++i) before[i] = clay[i].label();
                        if (covered) {
                            std::vector<R> heights;
                            for (const std::size_t i : at) heights.push_back(height[i]);
                            forget(clay, lattice, heights);
                        } else {
                            relabel(clay, lattice);
                        }
                        follow_labels(followers, clay, before, lattice);
                    });
    return true;
}
template <class R>
bool relabel_pieces(std::vector<Particle<R>>& q, std::vector<Gaussian<R>>& splats,
                    const Lattice<R>& lattice, const Bodies& bodies, const PosedTools<R>& posed,
                    bool covered, bool was_covered)
{
    const auto mask_at = [&](Vec3<R> x) -> const Mask& { return posed.mask_at(lattice, x); };
    return relabel_pieces(q, splats, lattice, bodies, posed.colliders(), mask_at, covered,
                          was_covered);
}

}  // namespace knead
