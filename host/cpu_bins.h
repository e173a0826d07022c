// Particles by block: a stable counting sort, the same for any number of threads.
#pragma once
#include <omp.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "cuda/state.h"

namespace knead {

struct Bins {
    std::vector<int> order;     // particle indices, block by block
    std::vector<int> first;     // occupied.size() + 1 offsets into order
    std::vector<int> occupied;  // blocks that hold the base node of a particle, rising
    std::vector<int> slot;      // per block: its index in occupied, or -1
    std::vector<int> touched;   // blocks that receive mass: the occupied and their upper neighbours

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

    // Bins by key(particle) in [0, blocks).
    template <class Particles, class Key>
    void fill(const Particles& q, int blocks, Key&& key, Int3 size, int threads)
    {
        sort(q, blocks, key, threads);
        occupied.clear(), first.clear(), touched.clear();
        slot.assign(std::size_t(blocks), -1);
        mark.assign(std::size_t(blocks), 0);
        for (int b = 0; b < blocks; ++b) {
            const int begin = start[std::size_t(b)], end = start[std::size_t(b) + 1];
            if (begin == end) continue;
            slot[std::size_t(b)] = int(occupied.size());
            occupied.push_back(b), first.push_back(begin);
            const Int3 at = {b % size.x, b / size.x % size.y, b / (size.x * size.y)};
            for (int n = 0; n < 8; ++n) {
                const Int3 to = at + Int3{n & 1, n >> 1 & 1, n >> 2};
                if (to.x < size.x && to.y < size.y && to.z < size.z)
                    mark[std::size_t((to.z * size.y + to.y) * size.x + to.x)] = 1;
            }
        }
        first.push_back(int(order.size()));
        for (int b = 0; b < blocks; ++b)
            if (mark[std::size_t(b)]) touched.push_back(b);
    }

    // Moves the particles, and their ids, into block order.
    template <class Particles, class Key>
    void reorder(Particles& q, std::vector<int>& ids, int blocks, Key&& key, int threads)
    {
        sort(q, blocks, key, threads);
        Particles sorted(q.size());
        std::vector<int> sorted_ids(q.size());
#pragma omp parallel for num_threads(threads)
        for (std::int64_t i = 0; i < std::int64_t(q.size()); ++i) {
            const auto from = std::size_t(order[std::size_t(i)]);
            sorted[std::size_t(i)] = q[from];
            sorted_ids[std::size_t(i)] = ids[from];
        }
        q.swap(sorted), ids.swap(sorted_ids);
    }

  private:
    template <class Particles, class Key>
    void sort(const Particles& q, int blocks, Key&& key, int threads)
    {
        const auto count = std::int64_t(q.size());
        keys.resize(q.size()), order.resize(q.size());
        start.assign(std::size_t(blocks) + 1, 0);
        const auto T = std::size_t(threads);
        per_thread.assign(T * std::size_t(blocks), 0);
        const auto begin = [&](std::size_t t) { return count * std::int64_t(t) / threads; };
#pragma omp parallel for num_threads(threads) schedule(static, 1)
        for (std::size_t t = 0; t < T; ++t)
            for (std::int64_t i = begin(t); i < begin(t + 1); ++i) {
                const int k = key(q[std::size_t(i)]);
                keys[std::size_t(i)] = k;
                ++per_thread[t * std::size_t(blocks) + std::size_t(k)];
            }
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
#pragma omp parallel for num_threads(threads) schedule(static, 1)
        for (std::size_t t = 0; t < T; ++t)
            for (std::int64_t i = begin(t); i < begin(t + 1); ++i)
                order[std::size_t(
                    per_thread[t * std::size_t(blocks) + std::size_t(keys[std::size_t(i)])]++)] =
                    int(i);
    }

    std::vector<int> keys, start, per_thread;
    std::vector<char> mark;
};

}  // namespace knead
