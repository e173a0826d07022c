// A live session whose disk is full, read-only, slow or gone: frames are not delayed, the state
// says what is wrong, and protection goes on when the disk does.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>

#include "host/base/errors.h"
#include "host/base/machine.h"
#include "host/hands/gesture.h"
#include "host/live/live_session.h"
#include "host/session/session_file.h"
#include "tests/faulty_disk.h"
#include "tests/folder.h"
#include "tests/sanitized.h"
#include "tests/small_disk.h"

namespace knead {
namespace {
namespace fs = std::filesystem;
using namespace std::chrono_literals;

class SessionDisk : public InFolder {
  protected:
    SessionDisk()
    {
        if (const char* state = std::getenv("XDG_STATE_HOME")) state_before = state;
        setenv("XDG_STATE_HOME", (folder / "state").c_str(), 1);
        std::ofstream(path("ball.json")) << R"({"schema": "knead.scene/1",
            "domain": {"edge": 0.32, "cells": 16}, "frame_rate": 90, "surface": {"nodes": 16},
            "objects": [{"name": "ball", "shape": "sphere", "centre": [0.16, 0.07, 0.16],
                         "diameter": 0.09, "material": {"preset": "clay", "young": 1e5}}]})";
    }
    ~SessionDisk() override
    {
        session.reset();
        disk.reset();
        if (state_before.empty())
            unsetenv("XDG_STATE_HOME");
        else
            setenv("XDG_STATE_HOME", state_before.c_str(), 1);
    }

    void begin()
    {
        LiveOptions by;
        by.make_solver = [](const auto& setup) { return cpu_solver(setup); };
        by.recorded = false, by.protects = true;
        by.published = [this] { see_frame(); };
        session = std::make_unique<LiveSession>(load_live_scene(path("ball.json")), by);
        session->wait_for_commands();
        log = session->state()->log.file;
        ASSERT_FALSE(log.empty()) << session->state()->refusal;
    }
    // Called on the simulation's thread.
    void see_frame()
    {
        const double now = wall_seconds();
        if (last_seen > 0) longest = std::max<double>(longest, now - last_seen);
        last_seen = now;
    }
    std::shared_ptr<const LiveState> state() const { return session->state(); }

    // Gives hands and changes gravity, which makes steps. Returns the longest time between states.
    double works(double seconds)
    {
        longest = 0;
        const double until = wall_seconds() + seconds;
        for (int i = 0; wall_seconds() < until; ++i) {
            HandFrame hands;
            hands.time = session->now();
            hands.hand[left] = open_hand(left), hands.hand[right] = open_hand(right);
            session->push(hands), ++pushed;
            if (i % 20 == 0) session->send(SetGravity{{0, -1 - 1e-3 * double(++commands), 0}});
            std::this_thread::sleep_for(10ms);
        }
        EXPECT_EQ(state()->failure, "");
        return longest;
    }
    template <class Condition>
    bool comes(const Condition& condition)
    {
        for (int i = 0; i < 30000 && !condition(); ++i) std::this_thread::sleep_for(1ms);
        return condition();
    }
    bool is_troubled() const { return !state()->log.trouble.empty(); }
    bool is_written() const
    {
        const auto now = state();
        return now->log.trouble.empty() && now->log.dropped == 0;
    }
    // Saves and waits; returns the refusal.
    std::string saved(const std::string& to)
    {
        const int before = state()->refused;
        session->send(Save{to, {}});
        EXPECT_TRUE(comes([&] { return state()->refused > before || state()->saved_as == to; }));
        return state()->refused > before ? state()->refusal : "";
    }
    // All that was given is in the log after the session.
    void expect_complete()
    {
        session->send(Pause{true});
        session->wait_for_commands();
        const auto last = state();
        session.reset();
        const SessionFile file(log);
        verify_session(file);
        History all(std::size_t(1) << 40);
        file.read_history(all, file.current());
        for (const StepInfo& step : *last->steps) EXPECT_TRUE(all.find(step.id)) << step.id;
        EXPECT_EQ(file.frames(), last->frame.number);
        const auto hands = file.hands();
        ASSERT_GE(hands.size(), 2u);
        EXPECT_GE(long(hands.size()), pushed - 2);
    }

    std::unique_ptr<LiveSession> session;
    std::string log;
    long pushed = 0, commands = 0;
    std::atomic<double> longest = 0;  // between states [s]

  private:
    std::string state_before;
    double last_seen = 0;
};

constexpr double much = sanitized ? 5 : 0.3;  // longer than all else that delays a frame [s]

TEST_F(SessionDisk, ThatIsFullDelaysNoFrameAndTakesAllOnceThereIsRoom)
{
    begin();
    const double before = works(1);
    EXPECT_EQ(state()->log.trouble, "");
    double during = 0;
    {
        const SmallDisk full(rlim_t(fs::file_size(log)) + 100);
        during = works(2);
        EXPECT_TRUE(comes([&] { return is_troubled(); }));
        EXPECT_EQ(state()->log.trouble, log + ": cannot be written: File too large");
        EXPECT_GT(state()->log.waiting, 0u);
    }
    EXPECT_LT(during, before + much);
    EXPECT_TRUE(comes([&] { return is_written(); })) << state()->log.trouble;
    works(0.5);
    expect_complete();
    std::printf("longest between states: %.1f ms, on a full disk %.1f ms\n", 1e3 * before,
                1e3 * during);
}

TEST_F(SessionDisk, EachOfItsErrorsIsShownAndPasses)
{
    begin();
    works(0.3);
    for (const int error : {ENOSPC, EIO, EROFS, EDQUOT})
        for (std::atomic<int>* at : {&disk.write_error, &disk.sync_error}) {
            *at = error;
            const double during = works(0.2);
            EXPECT_TRUE(comes([&] { return is_troubled(); }));
            EXPECT_EQ(state()->log.trouble, log + ": cannot be written: " + std::strerror(error));
            EXPECT_LT(during, much);
            *at = 0;
            EXPECT_TRUE(comes([&] { return is_written(); })) << state()->log.trouble;
        }
    expect_complete();
}

TEST_F(SessionDisk, ThatStandsDelaysNoFrame)
{
    begin();
    const double before = works(0.5);
    disk.stands = true;
    const double during = works(2);
    EXPECT_GT(state()->log.waiting, 0u);
    EXPECT_EQ(state()->log.dropped, 0);
    disk.stands = false;
    EXPECT_LT(during, before + much);
    works(0.2);
    expect_complete();
    std::printf("longest between states: %.1f ms, on a disk that stands %.1f ms\n", 1e3 * before,
                1e3 * during);
}

TEST_F(SessionDisk, ThatIsFullRefusesASaveAndKeepsTheOldFile)
{
    const std::string file = path("saved.knead");
    begin();
    works(0.5);
    EXPECT_EQ(saved(file), "");
    const long steps = SessionFile(file).steps();
    works(0.5);
    {
        const SmallDisk full(1000);
        const std::string why = saved(path("other.knead"));
        EXPECT_EQ(why, "Save: " + path("other.knead") + ": cannot be written: File too large");
        EXPECT_FALSE(fs::exists(path("other.knead")));
        const int before = state()->refused;
        session->send(Save{file, {}});
        EXPECT_TRUE(comes([&] { return state()->refused > before; }));
        EXPECT_EQ(state()->saved_as, file);
        EXPECT_TRUE(state()->unsaved);
    }
    verify_session(SessionFile(file));
    EXPECT_EQ(SessionFile(file).steps(), steps);
    EXPECT_EQ(files(), 3);  // with the scene and the folder of logs
    EXPECT_TRUE(comes([&] { return is_written(); }));
    EXPECT_EQ(saved(path("other.knead")), "");
    EXPECT_GT(SessionFile(path("other.knead")).steps(), steps);
    verify_session(SessionFile(path("other.knead")));
}

TEST_F(SessionDisk, WhoseFolderIsRemovedStillLeavesTheSessionToBeSaved)
{
    begin();
    const double before = works(0.5);
    fs::remove_all(folder / "state");
    const double during = works(1);
    EXPECT_TRUE(comes([&] { return is_troubled(); }));
    EXPECT_EQ(state()->log.trouble, log + ": cannot be written: it was removed");
    EXPECT_LT(during, before + much);
    EXPECT_EQ(saved(path("saved.knead")), "");
    verify_session(SessionFile(path("saved.knead")));
    EXPECT_GT(SessionFile(path("saved.knead")).steps(), 2);
}

TEST_F(SessionDisk, ThatTakesNoLogLeavesTheSessionUnprotectedAndSaysSo)
{
    std::ofstream(path("state")) << "a file";
    LiveOptions by;
    by.make_solver = [](const auto& setup) { return cpu_solver(setup); };
    by.protects = true;
    session = std::make_unique<LiveSession>(load_live_scene(path("ball.json")), by);
    session->wait_for_commands();
    EXPECT_EQ(state()->failure, "");
    EXPECT_EQ(state()->refusal.find("the session is not protected: "), 0u) << state()->refusal;
    EXPECT_EQ(state()->log.file, "");
    EXPECT_NE(saved(path("saved.knead")), "");
}

}  // namespace
}  // namespace knead
