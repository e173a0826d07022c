// Particles by block: a stable counting sort, the same for any number of threads.
#pragma once
#include <omp.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include "cuda/state.h"

namespace knead {

struct Bins {
    std::vector<int> key;       // per particle: its block, written by whoever moves it
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

    // Bins the particles by their keys, each in [0, blocks).
    void fill(int blocks, Int3 size, int threads)
    {
        sort(blocks, threads);
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

    // Moves the particles, and their ids, into the order of their nodes: node(particle) is the
    // index of a particle's base node, in blocks as the lattice is.
    template <class Particles, class NodeOf>
    void reorder(Particles& q, std::vector<int>& ids, int blocks, NodeOf&& node, int threads)
    {
        const auto count = std::int64_t(q.size());
        key.resize(q.size());
        std::vector<int> nodes(q.size());
#pragma omp parallel for num_threads(threads)
        for (std::int64_t i = 0; i < count; ++i) {
            nodes[std::size_t(i)] = node(q[std::size_t(i)]);
            key[std::size_t(i)] = nodes[std::size_t(i)] / block_nodes;
        }
        sort(blocks, threads);
        Particles sorted(q.size());
        std::vector<int> sorted_ids(q.size());
#pragma omp parallel for num_threads(threads) schedule(dynamic, 16)
        for (int b = 0; b < blocks; ++b) {
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
        }
        q.swap(sorted), ids.swap(sorted_ids);
    }

  private:
    // Puts the particles of a block, in the order of their indices, where the block starts.
    void sort(int blocks, int threads)
    {
        const auto count = std::int64_t(key.size());
        order.resize(key.size());
        start.resize(std::size_t(blocks) + 1);
        const auto T = std::size_t(threads);
        per_thread.assign(T * std::size_t(blocks), 0);
        // Calls visit(its count of that block, from, to) for every run of one block.
        const auto for_each_run = [&](std::size_t t, auto&& visit) {
            const std::int64_t end = count * std::int64_t(t + 1) / threads;
            for (std::int64_t i = count * std::int64_t(t) / threads, from = i; i < end; from = i) {
                const int block = key[std::size_t(from)];
                while (i < end && key[std::size_t(i)] == block) ++i;
                visit(per_thread[t * std::size_t(blocks) + std::size_t(block)], int(from), int(i));
            }
        };
#pragma omp parallel for num_threads(threads) schedule(static, 1)
        for (std::size_t t = 0; t < T; ++t)
            for_each_run(t, [](int& at, int from, int to) { at += to - from; });
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
            for_each_run(t, [&](int& at, int from, int to) {
                std::iota(order.begin() + at, order.begin() + at + (to - from), from);
                at += to - from;
            });
    }

    std::vector<int> start, per_thread;
    std::vector<char> mark;
};

}  // namespace knead
