#include "host/session/panel_text.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "host/session/lettering.h"

namespace knead {
PanelCanvas::PanelCanvas(int width, int height, int by)
    : fine(by), wide(width * by), high(height * by), texels(std::size_t(4 * wide * high))
{
}

void PanelCanvas::fill(const PanelRect& rect, PanelColour colour)
{
    const auto bound = [&](float at, int most) {
        return std::clamp(int(std::lround(at * float(fine))), 0, most);
    };
    const int right = bound(rect.x + rect.width, wide), low = bound(rect.y + rect.height, high);
    for (int y = bound(rect.y, high); y < low; ++y)
        for (int x = bound(rect.x, wide); x < right; ++x) {
            std::uint8_t* at = &texels[std::size_t(4 * (y * wide + x))];
            at[0] = colour.r, at[1] = colour.g, at[2] = colour.b, at[3] = 255;
        }
}

void PanelCanvas::text(float x, float y, const std::string& words, PanelColour colour)
{
    constexpr double pen = 0.5;  // its radius [pixels]: a capital of six units is seven pixels high
    static_assert(letter_step == Lettering::step && letter_height == Lettering::capital + 2 * pen);
    for (const char name : words) {
        const Lettering one(std::string(1, char(std::toupper(static_cast<unsigned char>(name)))));
        const auto texel = [&](float at, int most) {
            return std::clamp(int(std::lround(at * float(fine))), 0, most);
        };
        for (int j = texel(y, high); j < texel(y + letter_height + 2, high); ++j)
            for (int i = texel(x, wide); i < texel(x + letter_step, wide); ++i) {
                const double away = one.distance((i + 0.5) / fine - double(x) - pen,
                                                 (j + 0.5) / fine - double(y) - pen);
                const double cover = std::clamp(fine * (pen - away) + 0.5, 0.0, 1.0);
                std::uint8_t* const at = &texels[std::size_t(4 * (j * wide + i))];
                const std::uint8_t ink[4] = {colour.r, colour.g, colour.b, 255};
                for (int k = 0; k < 4; ++k)
                    at[k] = std::uint8_t(std::lround((1 - cover) * at[k] + cover * ink[k]));
            }
        x += letter_step;
    }
}

}  // namespace knead
