// What differs between two states of a simulator, or between the statistics of two frames.
#pragma once
#include <cstring>
#include <string>
#include <vector>

#include "host/solver/editable_simulator.h"

namespace knead {

// The first number that differs; "": none does.
class Difference {
  public:
    std::string first;

    template <class T>
    void plain(const std::string& name, const T& a, const T& b)
    {
        if (first.empty() && std::memcmp(&a, &b, sizeof(T)) != 0) first = name;
    }
    template <class T, class Each>
    void each(const std::string& name, const std::vector<T>& a, const std::vector<T>& b,
              Each&& compare)
    {
        if (!first.empty()) return;
        if (a.size() != b.size()) return (void)(first = "number of " + name);
        for (std::size_t i = 0; i < a.size() && first.empty(); ++i) {
            compare(a[i], b[i]);
            if (!first.empty()) first = name + " " + std::to_string(i) + ": " + first;
        }
    }
    void states(const SavedState& a, const SavedState& b)
    {
        const auto particle = [&](const Particle<double>& p, const Particle<double>& q) {
            plain("x", p.x, q.x), plain("v", p.v, q.v), plain("C", p.C, q.C);
            plain("e", p.e, q.e), plain("k", p.k, q.k), plain("object", p.object, q.object);
            plain("sides", p.sides, q.sides);
        };
        each("particle", a.contents.particles, b.contents.particles, particle);
        const auto gaussian = [&](const Gaussian<double>& g, const Gaussian<double>& h) {
            plain("x", g.x, h.x), plain("F", g.F, h.F), plain("object", g.object, h.object);
            plain("sides", g.sides, h.sides);
        };
        each("Gaussian", a.contents.gaussians, b.contents.gaussians, gaussian);
        const auto number = [&](int i, int j) { plain("number", i, j); };
        each("order", a.order, b.order, number);
        plain("speed_squared", a.speed_squared, b.speed_squared);
        plain("stiffness", a.stiffness, b.stiffness), plain("drift", a.drift, b.drift);
        plain("quiet_low", a.quiet_low, b.quiet_low);
        plain("quiet_stored", a.quiet_stored, b.quiet_stored);
        each("quiet", a.quiet, b.quiet, number), plain("covered", a.covered, b.covered);
        const auto node = [&](const SlidingNode& m, const SlidingNode& n) {
            plain("place", m.place, n.place), plain("force", m.force, n.force);
            plain("time", m.time, n.time);
            plain("impulse_deficit", m.impulse_deficit, n.impulse_deficit);
        };
        each("sliding", a.sliding, b.sliding, node);
    }
    void stats(const FrameStats& a, const FrameStats& b)
    {
        each_statistic([&](const auto& row) {
            plain(std::string("statistic ") + row.name, a[row.member], b[row.member]);
        });
    }
};

}  // namespace knead
