// Loops shared out among threads: one pool for the whole process, whichever threads call it.
//
// A thread that waits spins for 0.2 ms at most and then sleeps, so that a second program, or a
// second loop of this one, gets the processor. The caller works on its loop as well and waits only
// for threads that have begun a part of it: where the others do not get a processor, it does all
// by itself. No result may depend on which thread gets which part.
#pragma once
#include <cstdint>
#include <mutex>
#include <type_traits>

namespace knead {

// Threads of a loop that names no number: what set_loop_threads() set, else OMP_NUM_THREADS of the
// environment, else cpu_count() (machine.h).
int loop_threads();
void set_loop_threads(int threads);  // 0: as at the start

struct LoopOptions {
    int threads = 0;         // at most; 0: loop_threads()
    std::int64_t chunk = 0;  // indices that a thread takes at a time; 0: an eighth of its share
};

// One thread's part of a loop: indices from `from` up to `to`. `thread` is below the number of
// threads, and no two that run at the same time have the same.
using LoopPart = void (*)(void* context, std::int64_t from, std::int64_t to, int thread);
// Runs all parts; a loop within a part runs on its thread alone. Rethrows the first exception.
void run_loop(std::int64_t count, LoopOptions options, LoopPart part, void* context);

// body(from, to, thread) for parts that together are [0, count).
template <class Body>
void parallel_parts(std::int64_t count, LoopOptions options, Body&& body)
{
    using Plain = std::remove_reference_t<Body>;
    const LoopPart part = [](void* context, std::int64_t from, std::int64_t to, int thread) {
        (*static_cast<Plain*>(context))(from, to, thread);
    };
    run_loop(count, options, part, const_cast<void*>(static_cast<const void*>(&body)));
}

// body(i), or body(i, thread), for every i in [0, count); i is of count's type.
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

// The sum of what body(i, own) adds to `own`, a Sum of its part. Parts are added (+=) in no fixed
// order: for whole numbers and extremes.
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
