// Which kernels of a substep may run at the same time. Off: a kernel starts when the one before it
// has ended. The result does not depend on it; see cuda/mpm/substep_sync.cuh.
#pragma once

namespace knead::overlap {

// Programmatic dependent launches: before the end of the previous kernel of the stream.
constexpr unsigned grid = 1 << 0;  // before the end of g2p
constexpr unsigned g2p = 1 << 1;   // before the end of grid, or of a kernel between them
// What a kernel does before its wait; of use only if it is launched early.
constexpr unsigned contact_ahead = 1 << 2;  // grid: contact in first blocks of nodes near tools
constexpr unsigned pose_ahead = 1 << 3;     // g2p: posing; without: from the end of grid on

constexpr unsigned none = 0;  // plain stream order
constexpr unsigned all = (1 << 4) - 1;

}  // namespace knead::overlap
