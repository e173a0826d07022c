// Particles by block: a stable parallel counting sort, with the same result for any number of
// threads.
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "cuda/mpm/lattice.h"
#include "host/base/parallel.h"
#include "host/solver/cpu/namespace.h"

namespace knead {
inline namespace KNEAD_CPU_LEVEL {

struct Bins {
    std::vector<int> key;       // per particle: its block, updated where the particle is moved
    std::vector<int> order;     // particle indices, sorted by block
    std::vector<int> first;     // occupied.size() + 1 offsets into order
    std::vector<int> occupied;  // blocks that contain base nodes of particles, ascending
    std::vector<int> slot;      // per block: its index in occupied, or -1
    std::vector<int> reached;   // blocks that receive mass: the occupied and their upper neighbours
    std::vector<int> home;      // block_count + 1: first particle of each block at the last
                                // reorder()

    struct Members {
        const int *from, *to;
        const int* begin() const { return from; }
        const int* end() const { return to; }
        std::size_t size() const { return std::size_t(to - from); }
    };
    Members members(int s) const
    {
        return {order.data() + first[std::size_t(s)], order.data() + first[std::size_t(s) + 1]};
    }

    // True if the block receives mass (is listed in `reached`).
    bool reaches(int block) const { return mark[std::size_t(block)] != 0; }

    // Restricts fill() to the particles that were in the listed blocks at the last reorder().
    void bin_only(const std::vector<char>& listed)
    {
        ranges.clear(), binned = 0;
        int end = -1;
        for (std::size_t b = 0; b + 1 < home.size(); ++b) {
            if (!listed[b] || home[b] == home[b + 1]) continue;
            if (home[b] != end) ranges.push_back({home[b], binned});
            end = home[b + 1], binned += end - home[b];
        }
    }

    // Bins the particles by `key`, in [0, blocks). Block order is that of the lattice, z first.
    void fill(int blocks, Int3 size, int threads)
    {
        if (home.empty()) ranges = {{0, 0}}, binned = int(key.size());
        sort(blocks, threads);
        occupied.clear(), first.clear(), reached.clear();
        slot.assign(std::size_t(blocks), -1);
        mark.assign(std::size_t(blocks), 0);
        for (int b = 0; b < blocks; ++b) {
            const int begin = start[std::size_t(b)], end = start[std::size_t(b) + 1];
            if (begin == end) continue;
            slot[std::size_t(b)] = int(occupied.size());
            occupied.push_back(b), first.push_back(begin);
            const Int3 at = {b / (size.y * size.z), b / size.z % size.y, b % size.z};
            for (int n = 0; n < 8; ++n) {
                const Int3 to = at + Int3{n & 1, n >> 1 & 1, n >> 2};
                if (to.x < size.x && to.y < size.y && to.z < size.z)
                    mark[std::size_t((to.x * size.y + to.y) * size.z + to.z)] = 1;
            }
        }
        first.push_back(binned);
        for (int b = 0; b < blocks; ++b)
            if (mark[std::size_t(b)]) reached.push_back(b);
    }

    // Sorts the particles and their ids by block and base node. node(particle): lattice index of
    // its base node.
    template <class Particles, class NodeOf>
    void reorder(Particles& q, std::vector<int>& ids, int blocks, NodeOf&& node, int threads)
    {
        const auto count = std::int64_t(q.size());
        key.resize(q.size());
        ranges = {{0, 0}}, binned = int(count);
        std::vector<int> nodes(q.size());
        parallel_for(count, LoopOptions{.threads = threads}, [&](std::int64_t i) {
            nodes[std::size_t(i)] = node(q[std::size_t(i)]);
            key[std::size_t(i)] = nodes[std::size_t(i)] / block_nodes;
        });
        sort(blocks, threads);
        home = start;
        Particles sorted(q.size());
        std::vector<int> sorted_ids(q.size());
        parallel_for(blocks, LoopOptions{.threads = threads, .chunk = 16}, [&](int b) {
            const int begin = start[std::size_t(b)], end = start[std::size_t(b) + 1];
            std::stable_sort(order.begin() + begin, order.begin() + end, [&](int i, int j) {
                return nodes[std::size_t(i)] < nodes[std::size_t(j)];
            });
            for (int i = begin; i < end; ++i) {
                const auto from = std::size_t(order[std::size_t(i)]);
                sorted[std::size_t(i)] = q[from];
                sorted_ids[std::size_t(i)] = ids[from];
                key[std::size_t(i)] = b;
            }
        });
        q.swap(sorted), ids.swap(sorted_ids);
    }

  private:
    // Particles from index `from` on; `before` particles are in earlier ranges.
    struct Range {
        int from, before;
    };

    // Calls visit(from, to) for every run of particles of one block in part t of `threads`.
    template <class Visit>
    void for_each_run(std::size_t t, int threads, Visit&& visit) const
    {
        const auto share = [&](std::size_t n) {
            return int(std::int64_t(binned) * std::int64_t(n) / threads);
        };
        const int end = share(t + 1);
        std::size_t range = 0;
        for (int i = share(t); i < end;) {
            const auto last = [&] { return range + 1 == ranges.size(); };
            while (!last() && ranges[range + 1].before <= i) ++range;
            const int shift = ranges[range].from - ranges[range].before;
            const int stop = std::min(end, last() ? binned : ranges[range + 1].before) + shift;
            for (int at = i + shift, from = at; at < stop; from = at) {
                const int block = key[std::size_t(from)];
                while (at < stop && key[std::size_t(at)] == block) ++at;
                visit(from, at);
            }
            i = stop - shift;
        }
    }

    // Counting sort of particle indices by block, stable.
    void sort(int blocks, int threads)
    {
        order.resize(key.size());
        start.resize(std::size_t(blocks) + 1);
        const auto T = std::size_t(threads);
        per_thread.assign(T * std::size_t(blocks), 0);
        const auto counted = [&](std::size_t t, int from) -> int& {
            return per_thread[t * std::size_t(blocks) + std::size_t(key[std::size_t(from)])];
        };
        const LoopOptions share_each{.threads = threads, .chunk = 1};
        parallel_for(T, share_each, [&](std::size_t t) {
            for_each_run(t, threads, [&](int from, int to) { counted(t, from) += to - from; });
        });
        int sum = 0;
        for (int b = 0; b < blocks; ++b) {
            start[std::size_t(b)] = sum;
            for (std::size_t t = 0; t < T; ++t) {
                int& c = per_thread[t * std::size_t(blocks) + std::size_t(b)];
                const int here = c;
                c = sum;
                sum += here;
            }
        }
        start[std::size_t(blocks)] = sum;
        parallel_for(T, share_each, [&](std::size_t t) {
            for_each_run(t, threads, [&](int from, int to) {
                int& at = counted(t, from);
                for (int i = from; i < to; ++i) order[std::size_t(at++)] = i;
            });
        });
    }

    std::vector<Range> ranges;  // binned particles, ascending
    int binned = 0;
    std::vector<int> start, per_thread;
    std::vector<char> mark;
};

}  // namespace KNEAD_CPU_LEVEL
}  // namespace knead
