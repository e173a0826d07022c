// The bar of a run, on a terminal and off one.
#include "host/cli/progress.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <functional>
#include <thread>

namespace knead {
namespace {

// What comes to a terminal that is stderr meanwhile.
std::string on_terminal(const std::function<void()>& work)
{
    const int master = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
    if (master < 0 || grantpt(master) != 0 || unlockpt(master) != 0) return "none";
    const int terminal = open(ptsname(master), O_RDWR | O_NOCTTY);
    if (terminal < 0) return "none";
    std::fflush(stderr);
    const int before = dup(STDERR_FILENO);
    dup2(terminal, STDERR_FILENO);
    work();
    std::fflush(stderr);
    dup2(before, STDERR_FILENO);
    std::string all;
    char part[4096];
    for (ssize_t n; (n = read(master, part, sizeof part)) > 0;) all.append(part, std::size_t(n));
    close(before), close(terminal), close(master);
    return all;
}

int count(const std::string& text, const std::string& part)
{
    int found = 0;
    for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; ++at) ++found;
    return found;
}

TEST(ProgressBar, IsDrawnTenTimesASecondAtMostAndGoes)
{
    const std::string said = on_terminal([] {
        Progress progress(5, false);
        for (int k = 0; k < 50; ++k) progress.show(1);  // at once
        std::this_thread::sleep_for(std::chrono::milliseconds(120));
        progress.show(2);
        progress.show(5);  // the last is drawn whenever it comes
    });
    if (said == "none") GTEST_SKIP() << "no terminal can be made here";
    EXPECT_LE(count(said, " 1/5"), 1) << said;
    EXPECT_EQ(count(said, " 2/5"), 1) << said;
    EXPECT_EQ(count(said, "[##############################] 5/5"), 1) << said;
    EXPECT_TRUE(said.ends_with("\r\x1b[K")) << said;
}

TEST(ProgressBar, ALongFrameShowsHowFarItIs)
{
    const std::string said = on_terminal([] {
        Progress progress(5, false);
        progress.show(1);
        progress.show(1, 0.25);  // not yet: it has just begun
        std::this_thread::sleep_for(std::chrono::milliseconds(1100));
        progress.show(1, 0.5);
    });
    if (said == "none") GTEST_SKIP() << "no terminal can be made here";
    EXPECT_EQ(count(said, "25 %"), 0) << said;
    EXPECT_EQ(count(said, " 1/5 + 50 %"), 1) << said;
}

TEST(ProgressBar, IsSilentWhereItIsAskedToBeOrNobodyLooks)
{
    const std::string said = on_terminal([] {
        Progress progress(1, true);
        std::this_thread::sleep_for(std::chrono::milliseconds(110));
        progress.show(1);
    });
    EXPECT_TRUE(said.empty() || said == "none") << said;
    testing::internal::CaptureStderr();
    {
        Progress progress(1, false);
        progress.show(1);
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(ProgressBar, SaysHowLongTheRestTakes)
{
    EXPECT_EQ(progress_line(0, 10, 5), "[..............................] 0/10");
    EXPECT_EQ(progress_line(5, 10, 10),
              "[###############...............] 5/10  0.5 frames/s  10 s left");
    EXPECT_EQ(progress_line(200, 100000, 1).substr(32), " 200/100000  200 frames/s  8 min left");
    EXPECT_EQ(progress_line(0, 0, 0), "[##############################] 0/0");
}

}  // namespace
}  // namespace knead
