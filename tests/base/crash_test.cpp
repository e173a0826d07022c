// Tests that crash say which one it was, and where, on standard error: shards that show failures
// alone tell neither.
#include <execinfo.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <string>

#include "tests/sanitized.h"

namespace knead {
namespace {

// The test under way, where it is found when a signal has stopped all else.
std::array<char, 512> running{"no test"};

extern "C" void tell_crash(int number)
{
    std::array<void*, 64> frames{};
    const char* const parts[] = {"\ncrashed in ", running.data(), ":\n"};
    for (const char* part : parts)
        if (write(STDERR_FILENO, part, std::strlen(part)) < 0) break;
    backtrace_symbols_fd(frames.data(), backtrace(frames.data(), int(frames.size())),
                         STDERR_FILENO);
    raise(number);  // when this has returned: what it does is the default again
}

class NamesTests : public testing::EmptyTestEventListener {
    void OnTestStart(const testing::TestInfo& test) override
    {
        note(std::string(test.test_suite_name()) + "." + test.name());
    }
    void OnTestEnd(const testing::TestInfo&) override { note("no test"); }
    static void note(const std::string& name)
    {
        std::strncpy(running.data(), name.c_str(), running.size() - 1);
    }
};

bool watch_crashes()
{
    testing::UnitTest::GetInstance()->listeners().Append(new NamesTests);
    void* frame = nullptr;
    backtrace(&frame, 1);  // loads now what it needs
    static std::array<char, 1 << 16> stack;
    const stack_t own{stack.data(), 0, stack.size()};  // or an overflow is not told
    sigaltstack(&own, nullptr);
    struct sigaction action {};
    action.sa_handler = tell_crash;
    action.sa_flags = int(SA_RESETHAND | SA_ONSTACK);
    for (const int number : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT})
        sigaction(number, &action, nullptr);
    return true;
}

// Sanitizers tell it themselves.
const bool watched = !sanitized && watch_crashes();

TEST(CrashDeathTest, IsToldWithTheTestsName)
{
    if (!watched) GTEST_SKIP() << "sanitizers tell it";
    EXPECT_EXIT(raise(SIGSEGV), testing::KilledBySignal(SIGSEGV),
                "crashed in CrashDeathTest.IsToldWithTheTestsName:\n.*\\[0x");
    EXPECT_EXIT(std::abort(), testing::KilledBySignal(SIGABRT), "crashed in CrashDeathTest");
}

}  // namespace
}  // namespace knead
