// When steps begin and end, as tables of frames.
#include "host/session/step_rule.h"

#include <gtest/gtest.h>

#include <string>

namespace knead {
namespace {

constexpr double frame = 0.125;  // [s]
constexpr StepRuleOptions by_rule{1.0, 0.25, 1.0, 1.5, 0.5};

// A session of frames, one letter each, between commands ('C'; 'D': of a drag) and restored steps
// ('R'):
//   t  a tool touches the clay     .  it rests     m  it moves by itself
// Returns for each frame what follows it, as a session would:
//   B  a step begins    S  the open step is captured    X  both: captured, then another begins
//   -  nothing, no step is open    +  nothing, a step is open
// and '*' for a command or a restored step, which capture an open step.
std::string played(const std::string& frames)
{
    StepRule rule(by_rule);
    bool open = false;
    std::string after;
    for (const char what : frames) {
        if (what == 'C' || what == 'D' || what == 'R') {
            what == 'R' ? rule.restored() : rule.command(what == 'D');
            open = what != 'R';
            after += '*';
            continue;
        }
        const StepRule::Decision d =
            rule.after_frame(what == 't', what == '.' ? 0.5 : 2.0, frame, open);
        const bool captures = d.captures && open;
        if (captures) open = false;
        const bool begins = d.begins && !open;
        if (begins) open = true;
        after += captures && begins ? 'X' : captures ? 'S' : begins ? 'B' : open ? '+' : '-';
    }
    return after;
}

struct Row {
    const char *what, *frames, *steps;
};

const Row rows[] = {
    {"clay at rest", "........", "--------"},
    {"clay that moves by itself", "mmmmmmmmmmmm", "------------"},
    {"a press, and clay that is calm at once", "..ttt.....", "--B+++S---"},
    {"a press, and clay that settles", "tttmmm....", "B+++++S---"},
    {"clay that rings: after a second", "ttmmmmmmmmmm", "B++++++++S--"},
    {"contact with a gap shorter than a pause", "ttmmmttt..", "B++++++++S"},
    {"a tool that loses the clay for a frame", "tt.tt.tt..", "B++++++++S"},
    {"contact after a pause: another step", "ttmmmmtt..", "B+++++X++S"},
    {"contact after the step was captured", "tt..tt..", "B++SB++S"},
    {"contact without a pause is cut, and the next begins", "ttttttttttttttt..",
     "B++++++++++SB+++S"},
    {"a gap counts as contact, if it is no pause", "tttttmmmttttttt..", "B++++++++++SB+++S"},
    {"contact that ends with the cut", "tttttttttttt....", "B++++++++++S----"},
    {"a command, and calm clay", "C....", "*+S--"},
    {"a command, and clay that falls", "Cmmm..", "*+++S-"},
    {"a command, and a liquid", "Cmmmmmmmmmm", "*+++++++S--"},
    {"a command changed again: from the last one on", "CmmmmCmmmmmmmmm", "*++++*+++++++S-"},
    {"a drag, and calm clay: after a second", "D..........", "*+++++++S--"},
    {"a command after a drag", "D...C....", "*+++*+S--"},
    {"contact after a drag", "D.t....", "*+X+S--"},
    {"contact after a command: another step", "Cmttt..", "*+X+++S"},
    {"a command during contact", "tttCtt..", "B++*+++S"},
    {"a command during contact, which is cut later", "tttCtttttttttttttt", "B++*+++++++++++SB+"},
    {"a step restored, and clay that moves by itself", "ttmRmmmmmmmmmm", "B++*----------"},
    {"a press after a step was restored", "ttRmtt..", "B+*-B++S"},
};

TEST(StepRule, StepsBeginAndEndAsInTheTable)
{
    for (const Row& row : rows) EXPECT_EQ(played(row.frames), row.steps) << row.what;
}

TEST(StepRule, ACaptureThatTheSessionPutsOffIsAskedForAgain)
{
    StepRule rule(by_rule);
    EXPECT_TRUE(rule.after_frame(true, 2, frame, false).begins);
    rule.after_frame(false, 0, frame, true);
    for (int i = 0; i < 5; ++i) EXPECT_TRUE(rule.after_frame(false, 0, frame, true).captures);
    EXPECT_FALSE(rule.after_frame(false, 0, frame, false).captures);
}

TEST(StepRule, FramesOfAnyDurationAreCountedInSeconds)
{
    for (const double seconds : {1.0 / 256, 1.0 / 64, 1.0 / 16}) {
        StepRule rule(by_rule);
        rule.after_frame(true, 2, seconds, false);
        double moved = 0;
        while (!rule.after_frame(false, 2, seconds, true).captures) moved += seconds;
        EXPECT_EQ(moved + seconds, by_rule.settles_within);
    }
}

}  // namespace
}  // namespace knead
