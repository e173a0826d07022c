// A live session on a clock that the test moves, of a solver that takes as long as the test says.
#pragma once
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <new>
#include <thread>

#include "host/bench/ball.h"
#include "host/live/live_session.h"
#include "host/scene/seed.h"

namespace knead {

// A solver whose substeps take a time on a clock of their own, and that keeps what moved it.
struct Slow : Simulator {
    explicit Slow(std::atomic<double>& on) : clock(on) {}
    FrameStats advance(const Motion& motion, double duration) override
    {
        motions.push_back(motion);
        FrameStats stats;
        if (++frames == fails_at) throw std::runtime_error("the device is gone");
        if (frames == memory_ends_at) throw std::bad_alloc();
        for (int i = 1; i <= count; ++i) {
            clock = clock + substep;
            stats.substeps = i;
            if (i < count && ends_here(duration * i / count, duration, stats)) break;
        }
        if (frames == breaks_at) stats[Count::repaired] = 1000000;
        return stats;
    }
    std::vector<Particle<double>> particles() const override { return {}; }
    std::vector<double> penetration() const override { return {}; }
    std::size_t memory() const override { return 1; }
    std::string name() const override { return "slow"; }

    std::atomic<double>& clock;
    double substep = 1e-3;  // [s]
    int count = 20;         // of them in a frame
    int frames = 0, fails_at = 0, memory_ends_at = 0, breaks_at = 0;
    std::vector<Motion> motions;
};

class Live : public testing::Test {
  protected:
    Live()
    {
        auto made = std::make_shared<LiveScene>();
        made->scene.setup = ball(16);
        made->scene.objects.resize(1);
        made->scene.frame_rate = 100;
        made->scene.surface.lattice = {{16, 16, 16}, 1.0f / 16};
        const HandTools tools = hand_tools(made->scene.hands);
        made->scene.setup.rig = tools.rig, made->scene.setup.tools = tools.tools;
        scene = made;
        options.clock = [this] { return clock.load(); };
        options.make_solver = [this](const auto&) {
            auto solver = std::make_unique<Slow>(clock);
            if (prepare) prepare(*solver);
            slow = solver.get();
            return solver;
        };
    }
    // Waits until the state is as it should be; the clock is not that of the wall.
    template <class Is>
    std::shared_ptr<const LiveState> once(LiveSession& session, Is is)
    {
        const auto begin = std::chrono::steady_clock::now();
        while (std::chrono::steady_clock::now() - begin < std::chrono::seconds(20)) {
            const auto state = session.state();
            if (is(*state)) return state;
            std::this_thread::yield();
        }
        throw std::runtime_error("it never came to be, at frame " +
                                 std::to_string(session.state()->frame.number) + ": " +
                                 session.state()->failure);
    }
    std::atomic<double> clock = 0;
    LiveOptions options;
    std::shared_ptr<const LiveScene> scene;
    std::function<void(Slow&)> prepare;
    Slow* slow = nullptr;
};

}  // namespace knead
