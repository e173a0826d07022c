// The walls of the box that the clay lives in.
#pragma once
#include "cuda/contact/contact.h"

namespace knead {

// The box the clay lives in: its six inner faces stand `margin` nodes inside the lattice.
template <class R>
struct Walls {
    int margin;  // nodes; at least 2, so that no stencil leaves the lattice
    ContactMode mode;
    R friction;  // Coulomb [1]
};

}  // namespace knead
