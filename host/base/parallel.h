// Parallel loops on one thread pool per process, callable from any thread.
//
// A waiting thread spins for at most 0.2 ms and then sleeps, which frees the processor for other
// programs and loops. The caller works on its loop and waits only for threads that have begun a
// part: if the others get no processor, it completes the loop alone. Results must not depend on
// which thread executes which part.
#pragma once
#include <cstdint>
#include <mutex>
#include <type_traits>

namespace knead {

// Default number of threads: that of set_loop_threads(), else OMP_NUM_THREADS of the environment,
// else cpu_count() (machine.h).
int loop_threads();
void set_loop_threads(int threads);  // 0: restores the default

struct LoopOptions {
    int threads = 0;         // maximum; 0: loop_threads()
    std::int64_t chunk = 0;  // indices per part; 0: an eighth of a thread's share
};

// One part of a loop: indices [from, to). `thread` is in [0, threads) and unique among parts that
// run concurrently.
using LoopPart = void (*)(void* context, std::int64_t from, std::int64_t to, int thread);
// Runs all parts; nested loops run serially on their thread. Rethrows the first exception.
void run_loop(std::int64_t count, LoopOptions options, LoopPart part, void* context);

// Calls body(from, to, thread) for parts that cover [0, count).
template <class Body>
void parallel_parts(std::int64_t count, LoopOptions options, Body&& body)
{
    using Plain = std::remove_reference_t<Body>;
    const LoopPart part = [](void* context, std::int64_t from, std::int64_t to, int thread) {
        (*static_cast<Plain*>(context))(from, to, thread);
    };
    run_loop(count, options, part, const_cast<void*>(static_cast<const void*>(&body)));
}

// Calls body(i) or body(i, thread) for every i in [0, count); i has the type of count.
template <class Index, class Body>
void parallel_for(Index count, LoopOptions options, Body&& body)
{
    parallel_parts(std::int64_t(count), options,
                   [&body](std::int64_t from, std::int64_t to, [[maybe_unused]] int thread) {
                       for (std::int64_t i = from; i < to; ++i) {
                           if constexpr (std::is_invocable_v<Body&, Index, int>)
                               body(Index(i), thread);
                           else
                               body(Index(i));
                       }
                   });
}

template <class Index, class Body>
void parallel_for(Index count, Body&& body)
{
    parallel_for(count, LoopOptions{}, body);
}

// Reduction: body(i, own) accumulates in a Sum per part; parts are added (+=) in unspecified order.
// For integers and extremes, whose sum does not depend on it.
template <class Sum, class Index, class Body>
Sum parallel_sum(Index count, LoopOptions options, Body&& body)
{
    Sum all{};
    std::mutex adding;
    parallel_parts(std::int64_t(count), options, [&](std::int64_t from, std::int64_t to, int) {
        Sum own{};
        for (std::int64_t i = from; i < to; ++i) body(Index(i), own);
        const std::lock_guard<std::mutex> lock(adding);
        all += own;
    });
    return all;
}

}  // namespace knead
