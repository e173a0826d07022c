#include "host/vr/headset_notices.h"

#include <fmt/format.h>

#include "host/ui/session_line.h"

namespace knead {

std::string short_refusal(const std::string& message)
{
    const std::size_t from = message.find(" at ("), to = message.find(") m", from);
    if (from == std::string::npos || to == std::string::npos) return message;
    return message.substr(0, from) + message.substr(to + 3);
}

void HeadsetNotices::tell(const std::string& message)
{
    if (message.empty()) return;
    notify(message);
    show(message);
}

void HeadsetNotices::follow(const LiveState& state, double now)
{
    const bool saved = std::exchange(unsaved, state.unsaved) && !state.unsaved;
    if (saved && state.log.trouble.empty()) tell(session_line(state));
    if (state.refused == refused) return;
    refused = state.refused;
    const std::string words = short_refusal(state.refusal);
    constexpr double repeated = 5;  // a refusal of less than so long ago is not reported again [s]
    if (words != last_refusal || now > refused_at + repeated) notify("refused: " + state.refusal);
    last_refusal = words, refused_at = now;
    show(words);
}

void HeadsetNotices::follow(const HeadsetHands& hands, double now)
{
    tracking.frame(now, hands.slow_restarts());
    const bool was = std::exchange(too_slow, tracking.too_slow());
    if (!too_slow || was) return;
    const std::string words =
        fmt::format("tracking is too slow to shape: {:.1f} Hz", tracking.rate());
    notify(words + "; fast hands pass through the clay");
    show(words);
}

}  // namespace knead
