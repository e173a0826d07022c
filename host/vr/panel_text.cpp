#include "host/vr/panel_text.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "host/picture/lettering.h"

namespace knead {
PanelCanvas::PanelCanvas(int width, int height, int by)
    : fine(by), wide(width * by), high(height * by), texels(std::size_t(4 * wide * high))
{
}

int PanelCanvas::texel(float at) const { return int(std::lround(at * float(fine))); }

void PanelCanvas::fill(const PanelRect& rect, PanelColour colour)
{
    const int left = std::clamp(texel(rect.x), 0, wide),
              right = std::clamp(texel(rect.x + rect.width), left, wide);
    const int top = std::clamp(texel(rect.y), 0, high),
              low = std::clamp(texel(rect.y + rect.height), top, high);
    if (top == low) return;
    const auto row = [&](int y) { return texels.begin() + std::ptrdiff_t(4) * (y * wide + left); };
    auto at = row(top);
    for (int x = left; x < right; ++x)
        *at++ = colour.r, *at++ = colour.g, *at++ = colour.b, *at++ = 255;
    for (int y = top + 1; y < low; ++y) std::copy(row(top), at, row(y));
}

const std::vector<std::uint8_t>& PanelCanvas::ink_of(char name)
{
    std::vector<std::uint8_t>& ink = inks[name];
    if (!ink.empty()) return ink;
    constexpr double pen = 0.5;  // radius [pixels]: a capital of six units is seven pixels high
    static_assert(letter_step == Lettering::step && letter_height == Lettering::capital + 2 * pen);
    const Lettering one(std::string(1, name));
    for (int j = 0; j < (letter_height + 2) * fine; ++j)
        for (int i = 0; i < letter_step * fine; ++i) {
            const double away = one.distance((i + 0.5) / fine - pen, (j + 0.5) / fine - pen);
            const double cover = std::clamp(fine * (pen - away) + 0.5, 0.0, 1.0);
            ink.push_back(std::uint8_t(std::lround(255 * cover)));
        }
    return ink;
}

void PanelCanvas::text(float x, float y, const std::string& words, PanelColour colour)
{
    const int step = letter_step * fine, tall = (letter_height + 2) * fine, top = texel(y);
    const int first = std::max(0, -top), end = std::min(tall, high - top);
    int left = texel(x);
    for (const char name : words) {
        const std::vector<std::uint8_t>& ink =
            ink_of(char(std::toupper(static_cast<unsigned char>(name))));
        for (int j = first; j < end; ++j)
            for (int i = std::max(0, -left); i < std::min(step, wide - left); ++i) {
                const int cover = ink[std::size_t(j * step + i)];
                if (cover == 0) continue;
                std::uint8_t* const at = &texels[std::size_t(4 * ((top + j) * wide + left + i))];
                const int to[4] = {colour.r, colour.g, colour.b, 255};
                for (int k = 0; k < 4; ++k)
                    at[k] = std::uint8_t(((255 - cover) * at[k] + cover * to[k] + 127) / 255);
            }
        left += step;
    }
}

}  // namespace knead
