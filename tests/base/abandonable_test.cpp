#include "host/base/abandonable.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <thread>

#include "host/base/quiet_stderr.h"
#include "tests/folder.h"

namespace knead {
namespace {

// A foreign call that returns when it is let.
struct ForeignCall {
    std::atomic<bool> under_way = false, may_return = false;
    void operator()()
    {
        under_way = true;
        while (!may_return) std::this_thread::yield();
    }
};

TEST(CallGate, lets_others_in_during_a_call_and_the_worker_on_when_they_have_left)
{
    CallGate gate;
    ForeignCall call;
    int owned = 0;  // by the worker
    std::atomic<bool> began = false, may_call = false, ended = false;
    std::thread worker([&] {
        gate.begin();
        owned = 1;
        began = true;
        while (!may_call) std::this_thread::yield();
        gate.call_unlocked(true, [&] { call(); });
        owned = 3;
        ended = true;
        gate.end();
    });
    while (!began) std::this_thread::yield();
    EXPECT_FALSE(gate.enter(0.01)) << "the worker works";
    EXPECT_EQ(gate.blocked(), 0);
    may_call = true;
    while (!call.under_way) std::this_thread::yield();
    ASSERT_TRUE(gate.enter(10));
    EXPECT_EQ(owned, 1);
    owned = 2;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_GT(gate.blocked(), 0.01);
    call.may_return = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    EXPECT_FALSE(ended) << "the worker waits at the gate";
    EXPECT_EQ(owned, 2);
    gate.leave();
    worker.join();
    EXPECT_EQ(owned, 3);
}

TEST(CallGate, is_the_workers_again_after_a_call_that_throws)
{
    CallGate gate;
    gate.begin();
    EXPECT_THROW(gate.call_unlocked(true, [] { throw std::runtime_error("lost"); }),
                 std::runtime_error);
    bool entered = true;
    std::thread([&] { entered = gate.enter(0); }).join();
    EXPECT_FALSE(entered);
    gate.end();
}

TEST(AbandonableThread, is_waited_for_as_long_as_one_wants)
{
    const auto call = std::make_shared<ForeignCall>();
    AbandonableThread thread([call] { (*call)(); });
    EXPECT_FALSE(thread.finished_within(0.02));
    call->may_return = true;
    EXPECT_TRUE(thread.finished_within(10));
}

class QuietError : public InFolder {};

TEST_F(QuietError, lets_nothing_through_until_it_is_lifted_or_ends)
{
    std::FILE* const file = std::fopen(path("said").c_str(), "w+");
    ASSERT_TRUE(file);
    const int real = ::dup(STDERR_FILENO);
    ::dup2(::fileno(file), STDERR_FILENO);
    {
        const QuietStderr quiet;
        std::fputs("one ", stderr);
        QuietStderr::lift();
        std::fputs("two ", stderr);
    }
    {
        const QuietStderr quiet;
        std::fputs("three ", stderr);
    }
    {
        const QuietStderr loud(false);
        std::fputs("four", stderr);
    }
    ::dup2(real, STDERR_FILENO);
    ::close(real);
    std::rewind(file);
    char said[64] = {};
    EXPECT_TRUE(std::fgets(said, sizeof said, file));
    std::fclose(file);
    EXPECT_STREQ(said, "two four");
}

}  // namespace
}  // namespace knead
