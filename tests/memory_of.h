// What an action takes of memory.
#pragma once
#include <cstddef>
#include <fstream>
#include <string>

namespace knead {

// Peak of memory that an action takes beyond what was taken before [bytes].
template <class Action>
std::size_t memory_of(const Action& action)
{
    const auto peak = [] {
        std::ifstream in("/proc/self/status");
        for (std::string key; in >> key;)
            if (std::size_t kib; key == "VmHWM:" && in >> kib) return kib * 1024;
        return std::size_t(0);
    };
    std::ofstream("/proc/self/clear_refs") << 5;  // the peak becomes what is taken now
    const std::size_t before = peak();
    action();
    return peak() - before;
}

}  // namespace knead
