// Guards that corrected a frame, by name. All are 0 in a sound run.
#pragma once
#include <utility>

#include "host/solver/simulator.h"

namespace knead {

constexpr std::pair<const char*, long FrameStats::*> frame_guards[] = {
    {"clipped", &FrameStats::clipped},
    {"confined", &FrameStats::confined},
    {"repaired", &FrameStats::repaired},
    {"abrupt", &FrameStats::abrupt},
    {"moved_far", &FrameStats::moved_far}};

inline long guards_of(const FrameStats& s)
{
    long sum = 0;
    for (const auto& [name, count] : frame_guards) sum += s.*count;
    return sum;
}
inline void add_guards(FrameStats& all, const FrameStats& s)
{
    for (const auto& [name, count] : frame_guards) all.*count += s.*count;
}

}  // namespace knead
