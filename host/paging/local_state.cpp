#include "host/paging/local_state.h"

#include <stdexcept>

namespace knead {

void check(const LocalState& s)
{
    const auto require = [](bool fact) {
        if (!fact) throw std::invalid_argument("the state of local clay is inconsistent");
    };
    const std::size_t count = s.cloud.count();
    require(s.active.size() == count && s.normal.size() == count && s.objects >= 0);
    std::vector<char> seen(count, 0);
    for (const int slot : s.slot_of) {
        require(slot >= -1 && slot < int(count));
        if (slot < 0) continue;
        require(s.active[std::size_t(slot)] && !seen[std::size_t(slot)]);
        seen[std::size_t(slot)] = 1;
    }
    for (std::size_t i = 0; i < count; ++i) require(!s.active[i] || seen[i]);
    for (const auto& [cube, object] : s.clay) require(object >= -1 && object < s.objects);
}

}  // namespace knead
