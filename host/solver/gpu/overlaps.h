// Switches off overlaps of kernels (cuda/mpm/overlap.h): for tests, and for measuring what each
// gains.
#pragma once
#include <atomic>

#include "cuda/mpm/overlap.h"

namespace knead::gpu {

// Of GPU solvers from their construction on.
inline std::atomic<unsigned> allowed_overlaps = overlap::all;

// Solvers constructed during the object's lifetime use only these overlaps.
class WithOverlaps {
  public:
    explicit WithOverlaps(unsigned allowed) : before(allowed_overlaps.exchange(allowed)) {}
    ~WithOverlaps() { allowed_overlaps = before; }
    WithOverlaps(const WithOverlaps&) = delete;
    WithOverlaps& operator=(const WithOverlaps&) = delete;

  private:
    const unsigned before;
};

}  // namespace knead::gpu
