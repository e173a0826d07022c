// Loops of the pool of threads: every index once, whoever calls; waiting threads sleep.
#include "host/base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <numeric>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "host/base/machine.h"

namespace knead {
namespace {

void sleep(int milliseconds)
{
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
}

TEST(Parallel, EveryIndexIsVisitedOnceForAnyNumberOfThreadsAndAnyChunk)
{
    for (const int threads : {0, 1, 2, 3, 8, 33})
        for (const int chunk : {0, 1, 7, 1000})
            for (const int count : {0, 1, 2, 31, 1000}) {
                std::vector<std::atomic<int>> visits(std::size_t(count) + 1);
                parallel_for(count, LoopOptions{threads, chunk},
                             [&](int i) { ++visits[std::size_t(i)]; });
                for (int i = 0; i < count; ++i)
                    ASSERT_EQ(visits[std::size_t(i)], 1) << i << " of " << count << ", " << threads;
                EXPECT_EQ(visits.back(), 0);
            }
    parallel_for(-3, [](int) { FAIL(); });
}

TEST(Parallel, ThreadsAtWorkAtTheSameTimeHaveNumbersOfTheirOwn)
{
    constexpr int threads = 5;
    std::vector<std::atomic<int>> at_work(threads);
    std::atomic<int> most = 0, now = 0;
    for (int round = 0; round < 20; ++round)
        parallel_for(100, LoopOptions{.threads = threads, .chunk = 1}, [&](int, int thread) {
            ASSERT_GE(thread, 0);
            ASSERT_LT(thread, threads);
            EXPECT_EQ(at_work[std::size_t(thread)]++, 0);
            int known = most;
            for (const int n = ++now; n > known && !most.compare_exchange_weak(known, n);) {
            }
            std::this_thread::yield();
            --now, --at_work[std::size_t(thread)];
        });
    EXPECT_LE(most, threads);
}

// Two parts that wait for each other end only where two threads work on them.
TEST(Parallel, SeveralThreadsWorkOnALoopEvenAfterARest)
{
    for (const int rest : {0, 0, 0, 5, 50}) {
        sleep(rest);  // the workers sleep by now
        std::atomic<int> arrived = 0;
        parallel_for(2, LoopOptions{.threads = 2, .chunk = 1}, [&](int) {
            ++arrived;
            for (int k = 0; k < 10000 && arrived < 2; ++k) sleep(1);
        });
        EXPECT_EQ(arrived, 2);
    }
}

TEST(Parallel, ALoopWithinALoopRunsOnItsOwnThread)
{
    std::atomic<int> sum = 0;
    parallel_for(8, LoopOptions{.threads = 4, .chunk = 1}, [&](int) {
        const auto self = std::this_thread::get_id();
        parallel_for(16, LoopOptions{.threads = 4, .chunk = 1}, [&](int, int thread) {
            EXPECT_EQ(std::this_thread::get_id(), self);
            EXPECT_EQ(thread, 0);
            ++sum;
        });
    });
    EXPECT_EQ(sum, 128);
}

TEST(Parallel, ManyThreadsMayCallAtTheSameTime)
{
    std::vector<std::thread> callers;
    std::vector<long> sums(40, 0);
    for (std::size_t c = 0; c < sums.size(); ++c)
        callers.emplace_back([&, c] {
            for (int round = 0; round < 50; ++round) {
                std::vector<long> squares(200);
                parallel_for(squares.size(), LoopOptions{.threads = 4, .chunk = 3},
                             [&](std::size_t i) { squares[i] = long(i * i); });
                sums[c] += std::accumulate(squares.begin(), squares.end(), 0L);
            }
        });
    for (std::thread& caller : callers) caller.join();
    for (const long sum : sums) EXPECT_EQ(sum, 50 * (199L * 200 * 399 / 6));
}

TEST(Parallel, WhatABodyThrowsArrivesAtTheCallerAndTheNextLoopIsWhole)
{
    for (int round = 0; round < 50; ++round) {
        try {
            parallel_for(1000, LoopOptions{.threads = 4, .chunk = 1}, [&](int i) {
                if (i % 100 == 37) throw std::runtime_error("at " + std::to_string(i));
            });
            FAIL() << "nothing was thrown";
        } catch (const std::runtime_error& e) {
            EXPECT_EQ(std::string(e.what()).substr(0, 3), "at ");
        }
        const long sum =
            parallel_sum<long>(1000, LoopOptions{.threads = 4}, [](int i, long& to) { to += i; });
        EXPECT_EQ(sum, 499500);
    }
}

// What a waiting thread does: it takes next to no processor time, from the caller of a loop whose
// last part takes long, or from the workers between two loops.
TEST(Parallel, ThreadsThatWaitSleep)
{
    constexpr double all = 0.5;  // for which they wait [s]
    for (const bool within : {true, false}) {
        const auto pause = [&] { std::this_thread::sleep_for(std::chrono::duration<double>(all)); };
        const double before = process_seconds();
        parallel_for(8, LoopOptions{.threads = 8, .chunk = 1}, [&](int i) {
            if (within && i == 0) pause();
        });
        if (!within) pause();
        EXPECT_LT(process_seconds() - before, 0.1 * all) << within;
    }
}

TEST(Parallel, TheNumberOfThreadsIsWhatWasSet)
{
    const int before = loop_threads();
    EXPECT_GE(before, 1);
    set_loop_threads(3);
    EXPECT_EQ(loop_threads(), 3);
    std::atomic<int> highest = 0;
    parallel_for(300, LoopOptions{.chunk = 1}, [&](int, int thread) {
        if (thread > highest) highest = thread;
    });
    EXPECT_LT(highest, 3);
    set_loop_threads(0);
    EXPECT_EQ(loop_threads(), before);
}

}  // namespace
}  // namespace knead
