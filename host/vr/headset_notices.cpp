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

void HeadsetNotices::tell(const std::string& message, double now)
{
    if (message.empty()) return;
    notify(message);
    notice.show(message, now);
}

void HeadsetNotices::follow(const LiveState& state, double now)
{
    const bool saved = std::exchange(unsaved, state.unsaved) && !state.unsaved;
    if (saved && state.log.trouble.empty()) tell(session_line(state), now);
    if (state.refused == refused) return;
    refused = state.refused;
    const std::string words = short_refusal(state.refusal);
    if (notice.at(now) != words) notify("refused: " + state.refusal);
    notice.show(words, now);
}

void HeadsetNotices::follow(const HeadsetHands& hands, double now)
{
    tracking.frame(now, hands.slow_restarts());
    const bool was = std::exchange(too_slow, tracking.too_slow());
    if (!too_slow) return;
    const std::string words =
        fmt::format("tracking is too slow to shape: {:.1f} Hz", tracking.rate());
    if (!was) notify(words + "; fast hands pass through the clay");
    if (notice.at(now).empty()) notice.show(words, now);
}

}  // namespace knead
