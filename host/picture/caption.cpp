// Letters are rasterised by Dear ImGui's font atlas, which needs none of its contexts.
#include "host/picture/caption.h"

#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <vector>

#include "host/base/font_file.h"
#include "host/picture/font.h"

namespace knead {
namespace {

// Letters with capitals of at most this height are rasterised, and magnified for larger text: the
// texture of the letters stays small [pixels].
constexpr float largest_capital = 64;
constexpr std::size_t most_heights = 16, most_letters = 1024;  // kept; more: begun anew

using Letters = std::vector<ImWchar>;

Letters decoded(const std::string& text)
{
    Letters all;
    for (const char *at = text.data(), *const end = at + text.size(); at < end;) {
        unsigned letter = 0;
        at += std::max(1, ImTextCharFromUtf8(&letter, at, end));
        if (letter == 0 || letter > IM_UNICODE_CODEPOINT_MAX) letter = IM_UNICODE_CODEPOINT_INVALID;
        all.push_back(ImWchar(letter));
    }
    return all;
}

// A font with some of its letters as an image of their coverage.
struct Face {
    ImFontAtlas atlas;
    ImFont* font = nullptr;
    unsigned char* texels = nullptr;
    int width = 0, rows = 0;

    // `size`: of a line [pixels]. Only letters of `ranges` (first, last, ..., 0), which must stay;
    // all of Dear ImGui's own font.
    Face(float size, const ImWchar* ranges)
    {
        atlas.Flags = ImFontAtlasFlags_NoMouseCursors | ImFontAtlasFlags_NoBakedLines;
        ImFontConfig config;
        config.OversampleH = config.OversampleV = 1;  // letters begin at whole pixels
        config.PixelSnapH = true;
        if (const std::string file = font_file(); !file.empty())
            font = atlas.AddFontFromFileTTF(file.c_str(), size, &config, ranges);
        if (!font) {
            config.SizePixels = 13 * std::max(1.f, std::round(size / 13));  // pixels of a bitmap
            font = atlas.AddFontDefault(&config);
        }
        atlas.GetTexDataAsAlpha8(&texels, &width, &rows);  // builds it
    }

    // Of a glyph at a place in texels of its box, interpolated; texel (0, 0) is at 0.5, 0.5. 0
    // outside of the box, where other glyphs lie.
    double coverage(const ImFontGlyph& glyph, double u, double v) const
    {
        const int left = int(std::lround(glyph.U0 * float(width))),
                  top = int(std::lround(glyph.V0 * float(rows))),
                  wide = int(std::lround(glyph.X1 - glyph.X0)),
                  high = int(std::lround(glyph.Y1 - glyph.Y0));
        const auto texel = [&](int i, int j) {
            if (i < 0 || j < 0 || i >= wide || j >= high) return 0.0;
            return texels[std::size_t(top + j) * std::size_t(width) + std::size_t(left + i)] /
                   255.0;
        };
        const double i = std::floor(u - 0.5), j = std::floor(v - 0.5), s = u - 0.5 - i,
                     t = v - 0.5 - j;
        const auto along = [&](int row) {
            return (1 - s) * texel(int(i), row) + s * texel(int(i) + 1, row);
        };
        return (1 - t) * along(int(j)) + t * along(int(j) + 1);
    }
};

// Faces by the height of their capitals, each with the letters that were written in it.
class Faces {
  public:
    const Face& of(float capital, const Letters& text)
    {
        if (faces.size() >= most_heights && !faces.contains(capital)) faces.clear();
        Kept& kept = faces[capital];
        const auto known = [&](ImWchar letter) { return kept.letters.contains(letter); };
        if (kept.face && std::all_of(text.begin(), text.end(), known)) return *kept.face;
        if (kept.letters.size() > most_letters) kept.letters.clear();
        for (ImWchar letter = ' '; letter <= '~'; ++letter) kept.letters.insert(letter);
        kept.letters.insert(ImWchar(IM_UNICODE_CODEPOINT_INVALID));
        kept.letters.insert(text.begin(), text.end());
        std::vector<ImWchar> ranges;
        for (const ImWchar letter : kept.letters) ranges.insert(ranges.end(), {letter, letter});
        ranges.push_back(0);
        kept.face = std::make_unique<Face>(capital / capital_per_line(), ranges.data());
        return *kept.face;
    }

  private:
    // Measured on letters large enough that their rounding to pixels does not matter.
    static float capital_per_line()
    {
        constexpr float large = 208;  // a multiple of 13, see Face [pixels]
        constexpr ImWchar capitals[] = {'H', 'H', 0};
        static const float share = capital_of(*Face(large, capitals).font) / large;
        return std::max(share, 0.1f);
    }

    struct Kept {
        std::unique_ptr<Face> face;
        std::set<ImWchar> letters;
    };
    std::map<float, Kept> faces;
};

// The coverage of a line of text, in the part of a picture that it may touch.
struct Mask {
    int left = 0, top = 0, width = 0, height = 0;
    std::vector<double> cover;

    double at(int i, int j) const  // 0 outside
    {
        const bool inside = i >= left && j >= top && i < left + width && j < top + height;
        return inside ? cover[place(i, j)] : 0;
    }
    std::size_t place(int i, int j) const
    {
        return std::size_t(j - top) * std::size_t(width) + std::size_t(i - left);
    }
};

int clipped(double at, int most) { return int(std::clamp(at, 0.0, double(most))); }

constexpr int outline = 2;  // its reach beyond the letters, in whole pixels

// Of what is seen of a line, from its beginning [texels].
double middle_of(const Face& face, const Letters& text)
{
    double left = 1e300, right = -1e300, pen = 0;
    for (const ImWchar letter : text) {
        const ImFontGlyph& glyph = *face.font->FindGlyph(letter);
        if (glyph.Visible)
            left = std::min(left, pen + glyph.X0), right = std::max(right, pen + glyph.X1);
        pen += glyph.AdvanceX;
    }
    return left < right ? (left + right) / 2 : pen / 2;
}

// `left`, `middle`: of the line, in whole pixels; `scale`: pixels per texel.
Mask mask_of(const Image& image, const Face& face, const Letters& text, double left, double middle,
             double scale)
{
    const ImFontGlyph& capital = *face.font->FindGlyph('H');
    const double top = middle - std::round(scale * (capital.Y0 + capital.Y1) / 2);
    struct Box {
        double left, top, right, bottom;
    };
    std::vector<Box> boxes;
    Box all{1e300, 1e300, -1e300, -1e300};
    double pen = left;
    for (const ImWchar letter : text) {
        const ImFontGlyph& glyph = *face.font->FindGlyph(letter);
        boxes.push_back({pen + scale * glyph.X0, top + scale * glyph.Y0, pen + scale * glyph.X1,
                         top + scale * glyph.Y1});
        const Box& b = boxes.back();
        all = {std::min(all.left, b.left), std::min(all.top, b.top), std::max(all.right, b.right),
               std::max(all.bottom, b.bottom)};
        pen += scale * glyph.AdvanceX;
    }
    const double margin = outline + scale;
    Mask mask;
    mask.left = clipped(std::floor(all.left - margin), image.width);
    mask.top = clipped(std::floor(all.top - margin), image.height);
    mask.width = std::max(0, clipped(std::ceil(all.right + margin), image.width) - mask.left);
    mask.height = std::max(0, clipped(std::ceil(all.bottom + margin), image.height) - mask.top);
    mask.cover.resize(std::size_t(mask.width) * std::size_t(mask.height));
    for (std::size_t k = 0; k < text.size(); ++k) {
        const ImFontGlyph& glyph = *face.font->FindGlyph(text[k]);
        if (!glyph.Visible) continue;
        const Box& b = boxes[k];
        const int right = clipped(std::ceil(b.right + scale), mask.left + mask.width),
                  bottom = clipped(std::ceil(b.bottom + scale), mask.top + mask.height);
        for (int j = std::max(mask.top, clipped(b.top - scale, image.height)); j < bottom; ++j)
            for (int i = std::max(mask.left, clipped(b.left - scale, image.width)); i < right;
                 ++i) {
                double& cover = mask.cover[mask.place(i, j)];
                cover = std::max(cover, face.coverage(glyph, (i + 0.5 - b.left) / scale,
                                                      (j + 0.5 - b.top) / scale));
            }
    }
    return mask;
}

// Of a pixel by letters that are a pixel and a half thicker on each side. Those at the edge, which
// the letter covers in part, count more than their share: else edges between pixels are faint.
double outlined(const Mask& mask, int i, int j)
{
    double most = 0;
    for (int y = -outline; y <= outline; ++y)
        for (int x = -outline; x <= outline; ++x) {
            const double share = std::clamp(2 - std::hypot(x, y), 0.0, 1.0);
            if (share > 0)
                most = std::max(most, share * std::min(1.0, 1.5 * mask.at(i + x, j + y)));
        }
    return most;
}

void blend(std::uint8_t* rgb, double colour, double cover)
{
    for (int k = 0; k < 3; ++k)
        rgb[k] = std::uint8_t(std::lround((1 - cover) * rgb[k] + cover * colour));
}

}  // namespace

bool draws_text() { return true; }

void write_text(Image& image, const std::string& text, double x, double y, double height)
{
    static std::mutex one_at_a_time;
    static Faces faces;
    constexpr double far = 1e7;  // beyond any picture; integers are exact
    height = std::min(height, far);
    if (text.empty() || !(height > 0) || !(std::fabs(x) < far) || !(std::fabs(y) < far)) return;
    const Letters letters = decoded(text);
    const std::lock_guard held(one_at_a_time);
    const float capital = std::clamp(float(std::round(height)), 5.0f, largest_capital);
    const Face& face = faces.of(capital, letters);
    if (!face.texels) return;
    // Close to their own size letters keep their pixels, which are sharp.
    const double own = capital_of(*face.font),
                 scale = std::fabs(height - own) <= 1 ? 1 : height / own;
    const double left = x - scale * middle_of(face, letters);
    const Mask mask = mask_of(image, face, letters, std::round(left), std::round(y), scale);
    for (int j = mask.top; j < mask.top + mask.height; ++j)
        for (int i = mask.left; i < mask.left + mask.width; ++i) {
            std::uint8_t* const rgb =
                image.rgb.data() + 3 * (std::size_t(j) * std::size_t(image.width) + std::size_t(i));
            blend(rgb, 30, 0.8 * outlined(mask, i, j));
            blend(rgb, 255, mask.at(i, j));
        }
}

}  // namespace knead
