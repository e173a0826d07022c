#include "host/base/parallel.h"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include "host/base/machine.h"

namespace knead {
namespace {

constexpr int most_threads = 4096;

using Word = std::atomic<std::uint32_t>;  // for futex
static_assert(sizeof(Word) == 4 && Word::is_always_lock_free);

// Returns immediately if the word has another value; may wake spuriously.
void sleep_while(const Word& word, std::uint32_t value)
{
    ::syscall(SYS_futex, &word, FUTEX_WAIT_PRIVATE, value, nullptr, nullptr, 0);
}
void wake(const Word& word, int threads)
{
    ::syscall(SYS_futex, &word, FUTEX_WAKE_PRIVATE, threads, nullptr, nullptr, 0);
}

void pause_briefly()
{
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    asm volatile("yield");
#endif
}

// Adaptive spinning before a thread sleeps: waking it takes longer than most gaps between two
// loops. The spin time halves after each failure, as when other programs need the processor.
class Patience {
  public:
    // Spins; returns whether the condition became true.
    template <class Condition>
    bool until(Condition&& condition)
    {
        if (condition()) return true;
        const double end = wall_seconds() + seconds;
        do {
            for (int k = 0; k < 8; ++k) {
                pause_briefly();
                if (!condition()) continue;
                seconds = std::min(2 * seconds, most);
                return true;
            }
        } while (wall_seconds() < end);
        seconds = std::max(seconds / 2, least);
        return false;
    }

  private:
    static constexpr double least = 10e-6, most = 200e-6;
    double seconds = most;
};

// True on a thread that executes a loop.
thread_local bool within_loop = false;

class WithinLoop {
  public:
    WithinLoop() : before(within_loop) { within_loop = true; }
    WithinLoop(const WithinLoop&) = delete;
    ~WithinLoop() { within_loop = before; }

  private:
    const bool before;
};

// A loop in progress, or a free slot for one. A worker first increments `inside` and then takes a
// ticket; the caller first withdraws all tickets and then waits until `inside` is 0. A worker with
// a ticket is therefore always in the loop that issued it.
class alignas(64) Loop {
  public:
    bool reserve() { return !taken.exchange(true); }
    void release() { taken = false; }

    void begin(std::int64_t size, std::int64_t step, int workers, LoopPart body, void* with)
    {
        count = size, chunk = step, part = body, context = with;
        failure = nullptr, failed = false;
        next.store(0, std::memory_order_relaxed);
        tickets = workers;
    }

    // Works on the loop if a ticket is left; else returns false.
    bool join()
    {
        if (tickets.load(std::memory_order_relaxed) <= 0) return false;
        ++inside;
        int ticket = tickets;
        while (ticket > 0 && !tickets.compare_exchange_weak(ticket, ticket - 1)) {
        }
        if (ticket > 0) work(ticket);
        if (--inside == 0 && awaited) wake(inside, 1);
        return ticket > 0;
    }

    // Takes parts until none is left. The caller is thread 0; tickets number the others.
    void work(int thread)
    {
        try {
            for (;;) {
                const std::int64_t from = next.fetch_add(chunk, std::memory_order_relaxed);
                if (from >= count) break;
                part(context, from, std::min(count, from + chunk), thread);
            }
        } catch (...) {
            if (!failed.exchange(true)) failure = std::current_exception();
            next.store(count, std::memory_order_relaxed);
        }
        tickets = 0;
    }

    // Waits for all workers; returns the first exception.
    std::exception_ptr finish()
    {
        tickets = 0;
        thread_local Patience patience;
        if (!patience.until([&] { return inside == 0; })) {
            awaited = true;
            for (std::uint32_t n; (n = inside) != 0;) sleep_while(inside, n);
            awaited = false;
        }
        return std::exchange(failure, nullptr);
    }

  private:
    std::atomic<bool> taken{false};
    std::int64_t count = 0, chunk = 1;
    LoopPart part = nullptr;
    void* context = nullptr;
    std::exception_ptr failure;
    std::atomic<bool> failed{false}, awaited{false};
    alignas(64) std::atomic<std::int64_t> next{0};
    alignas(64) std::atomic<int> tickets{0};
    Word inside{0};
};

// The thread pool of the process. Never destroyed: its threads may outlive static objects.
class Pool {
  public:
    static Pool& of_process()
    {
        static Pool& pool = *new Pool;
        return pool;
    }

    // Slot for a loop; null if all are in use by concurrent loops.
    Loop* reserve()
    {
        for (Loop& loop : loops)
            if (loop.reserve()) return &loop;
        return nullptr;
    }

    // If the system refuses more threads, loops use fewer.
    void start_workers(int wanted)
    {
        if (started >= wanted) return;
        const std::lock_guard<std::mutex> lock(starting);
        while (started < wanted) try {
                std::thread([this] { run_worker(); }).detach();
                ++started;
            } catch (const std::system_error&) {
                return;
            }
    }

    // Wakes workers for a new loop.
    void announce(int workers)
    {
        ++announced;
        if (asleep > 0) wake(announced, workers);
    }

  private:
    void run_worker()
    {
        const WithinLoop within;
        Patience patience;
        for (;;) {
            const std::uint32_t seen = announced;
            bool any = false;
            for (Loop& loop : loops) any |= loop.join();
            if (any || patience.until([&] { return announced != seen; })) continue;
            ++asleep;
            sleep_while(announced, seen);
            --asleep;
        }
    }

    std::array<Loop, 16> loops;
    alignas(64) Word announced{0};
    alignas(64) std::atomic<int> asleep{0};
    std::mutex starting;
    std::atomic<int> started{0};
};

int threads_at_start()
{
    int threads = 0;
    if (const char* const named = std::getenv("OMP_NUM_THREADS"))
        std::from_chars(named, named + std::strlen(named), threads);
    return std::clamp(threads > 0 ? threads : cpu_count(), 1, most_threads);
}

std::atomic<int> threads_set{0};

}  // namespace

int loop_threads()
{
    static const int at_start = threads_at_start();
    const int set = threads_set;
    return set > 0 ? set : at_start;
}

void set_loop_threads(int threads) { threads_set = std::clamp(threads, 0, most_threads); }

void run_loop(std::int64_t count, LoopOptions options, LoopPart part, void* context)
{
    if (count <= 0) return;
    const int threads =
        std::min(options.threads > 0 ? options.threads : loop_threads(), most_threads);
    const std::int64_t chunk =
        options.chunk > 0 ? options.chunk : std::max(count / (8 * threads), std::int64_t(1));
    const std::int64_t parts = (count - 1) / chunk + 1;
    const int workers = int(std::min<std::int64_t>(threads, parts)) - 1;
    Pool& pool = Pool::of_process();
    Loop* const loop = workers > 0 && !within_loop ? pool.reserve() : nullptr;
    if (!loop) return part(context, 0, count, 0);
    pool.start_workers(workers);
    loop->begin(count, chunk, workers, part, context);
    pool.announce(workers);
    {
        const WithinLoop within;
        loop->work(0);
    }
    const std::exception_ptr failure = loop->finish();
    loop->release();
    if (failure) std::rethrow_exception(failure);
}

}  // namespace knead
