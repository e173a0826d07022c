// Which kernels of a frame may run at the same time. Off: a kernel starts when the one before it
// has ended. The result does not depend on it; see cuda/mpm/substep_sync.cuh.
#pragma once

namespace knead::overlap {

// Programmatic dependent launches: before the end of the previous kernel of the stream.
constexpr unsigned grid = 1 << 0;       // in every substep: before the end of g2p
constexpr unsigned g2p = 1 << 1;        // in every substep: before the end of grid or what follows
constexpr unsigned pressures = 1 << 2;  // clearing cell-averaged pressures: before the end of grid
constexpr unsigned masks = 1 << 3;      // once a frame: before the end of the sweep
constexpr unsigned line_up = 1 << 4;    // once a frame: before the end of the search for near runs
// Parallel streams, once a frame.
constexpr unsigned masks_stream = 1 << 5;    // masks beside begin, sort and p2g
constexpr unsigned pose_stream = 1 << 6;     // the first pose beside sort and p2g
constexpr unsigned sort_stream = 1 << 7;     // the sort beside p2g, if its target is other memory
constexpr unsigned line_up_stream = 1 << 8;  // beside p2g and the substeps
// What a kernel does before its wait; of use only if it is launched early.
constexpr unsigned contact_ahead = 1 << 9;  // grid: contact in first blocks of nodes near tools
constexpr unsigned pose_ahead = 1 << 10;    // g2p: posing; without: from the end of grid on
constexpr unsigned load_ahead = 1 << 11;    // g2p: loads the positions of its particles

constexpr unsigned none = 0;  // plain stream order
constexpr unsigned all = (1 << 12) - 1;

}  // namespace knead::overlap
