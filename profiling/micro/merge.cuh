// The forms of a scatter over one clay.
#pragma once
#include "cuda/mpm/p2g.h"
#include "profiling/micro/atomics.cuh"
#include "profiling/micro/clay.cuh"

namespace knead::micro {

struct Scatters {
    Bench& bench;
    Clay& clay;
    std::string question, of;   // what the clay is, at the end of a row's name
    std::vector<float4> first;  // nodes that the first form left

    static constexpr double bytes_of_particle = 96;

    void all();
    void unmerged();
    void walked();
    void shipped();

  private:
    // `adds`: vector atomics a particle; 0: copying the particles' rows is the limit.
    void run(const char* what, void (*kernel)(gpu::Views, int, float), double adds);
    void time(const std::string& what, const std::function<void()>& run, double adds);
    bool right();
};

}  // namespace knead::micro
