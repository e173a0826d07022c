#include "host/scene/glyphs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/base/font_file.h"

#ifdef KNEAD_HAS_STB
#define STBTT_STATIC
#define STB_TRUETYPE_IMPLEMENTATION
#include <stb_truetype.h>
#endif

namespace knead {
namespace {

// Characters of a text in UTF-8; bytes that are no UTF-8 become U+FFFD.
std::vector<int> characters(const std::string& text)
{
    std::vector<int> all;
    for (std::size_t i = 0; i < text.size();) {
        const auto first = static_cast<unsigned char>(text[i++]);
        const int more = first < 0x80   ? 0
                         : first < 0xc0 ? -1
                         : first < 0xe0 ? 1
                         : first < 0xf0 ? 2
                                        : 3;
        int one = more < 0 ? 0xfffd : more == 0 ? first : first & (0x3f >> more);
        for (int k = 0; k < more; ++k) {
            if (i == text.size() || (text[i] & 0xc0) != 0x80) {
                one = 0xfffd;
                break;
            }
            one = one << 6 | (text[i++] & 0x3f);
        }
        all.push_back(one);
    }
    return all;
}

}  // namespace

#ifdef KNEAD_HAS_STB
namespace {

constexpr double deviation = 2e-4;  // of chords from curves [capitals]

class Font {
  public:
    explicit Font(const std::string& path) : bytes_(font_bytes(path))
    {
        const auto* data = reinterpret_cast<const unsigned char*>(bytes_.data());
        if (bytes_.empty() || !stbtt_InitFont(&font_, data, 0)) return;
        int left = 0, low = 0, right = 0, high = 0;
        stbtt_GetCodepointBox(&font_, 'H', &left, &low, &right, &high);
        if (high > 0) scale_ = 1.0 / high;
    }
    bool valid() const { return scale_ > 0; }
    bool has(int character) const { return stbtt_FindGlyphIndex(&font_, character) != 0; }
    double line_height() const
    {
        int ascent = 0, descent = 0, gap = 0;
        stbtt_GetFontVMetrics(&font_, &ascent, &descent, &gap);
        return scale_ * (ascent - descent + gap);
    }
    double advance(int character) const
    {
        int width = 0, bearing = 0;
        stbtt_GetCodepointHMetrics(&font_, character, &width, &bearing);
        return scale_ * width;
    }
    double kerning(int before, int character) const
    {
        return scale_ * stbtt_GetCodepointKernAdvance(&font_, before, character);
    }
    void add(int character, Point2 at, std::vector<std::vector<Point2>>& to) const
    {
        stbtt_vertex* vertices = nullptr;
        const int count = stbtt_GetCodepointShape(&font_, character, &vertices);
        for (int i = 0; i < count; ++i) {
            const stbtt_vertex& v = vertices[i];
            const Point2 end = at + scale_ * Point2{double(v.x), double(v.y)},
                         c = at + scale_ * Point2{double(v.cx), double(v.cy)},
                         d = at + scale_ * Point2{double(v.cx1), double(v.cy1)};
            if (v.type == STBTT_vmove || to.empty()) {
                to.push_back({end});
                continue;
            }
            std::vector<Point2>& contour = to.back();
            const Point2 start = contour.back();
            if (v.type == STBTT_vcurve) {
                const int n = chords(start - 2 * c + end, 4);
                for (int k = 1; k < n; ++k) {
                    const double t = double(k) / n, u = 1 - t;
                    contour.push_back(u * u * start + 2 * u * t * c + t * t * end);
                }
            } else if (v.type == STBTT_vcubic) {
                const Point2 a = start - 2 * c + d, b = c - 2 * d + end;
                const int n = chords(dot(a, a) > dot(b, b) ? a : b, 4.0 / 3);
                for (int k = 1; k < n; ++k) {
                    const double t = double(k) / n, u = 1 - t;
                    contour.push_back(u * u * u * start + 3 * u * u * t * c + 3 * u * t * t * d +
                                      t * t * t * end);
                }
            }
            contour.push_back(end);
        }
        stbtt_FreeShape(&font_, vertices);
    }

  private:
    // The deviation of a chord over 1/n of a curve is |bend| / (divisor n^2).
    static int chords(Point2 bend, double divisor)
    {
        const double n = std::sqrt(std::sqrt(dot(bend, bend)) / (divisor * deviation));
        return std::clamp(int(std::ceil(n)), 1, 64);
    }

    std::string bytes_;
    stbtt_fontinfo font_{};
    double scale_ = 0;  // heights of a capital per unit of the font
};

bool is_blank(int character) { return character == ' ' || character == 0xa0; }

std::string lacking(const Font& font, const std::vector<int>& text)
{
    std::vector<int> lacks;
    for (const int one : text)
        if (one != '\n' && (one < ' ' || !font.has(one)) && std::ranges::count(lacks, one) == 0)
            lacks.push_back(one);
    std::string names;
    for (const int one : lacks) names += fmt::format("{}U+{:04X}", names.empty() ? "" : ", ", one);
    return names;
}

}  // namespace

GlyphOutlines glyph_outlines(const std::string& text, const std::string& path)
{
    const std::vector<int> all = characters(text);
    if (all.empty()) return {{}, "no text"};
    if (all.size() > std::size_t(most_letters))
        return {{}, fmt::format("{} characters, more than {}", all.size(), most_letters)};
    if (std::ranges::all_of(all, [](int one) { return one == '\n' || is_blank(one); }))
        return {{}, "blanks alone"};
    if (path.empty())
        return {{},
                "no font of the system: DejaVu Sans, Noto Sans or Liberation Sans in "
                "/usr/share/fonts"};
    const Font font(path);
    if (!font.valid()) return {{}, path + ", which is no TrueType font with capitals"};
    if (const std::string lacks = lacking(font, all); !lacks.empty())
        return {{}, fmt::format("characters that {} lacks: {}", path, lacks)};
    GlyphOutlines made;
    double y = 0;
    for (auto begin = all.begin(); begin != all.end();) {
        const auto end = std::find(begin, all.end(), '\n');
        std::vector<double> places;
        double x = 0;
        for (auto one = begin; one != end; ++one) {
            if (one != begin) x += font.kerning(*(one - 1), *one);
            places.push_back(x);
            x += font.advance(*one);
        }
        for (auto one = begin; one != end; ++one)
            font.add(*one, {places[std::size_t(one - begin)] - x / 2, y}, made.contours);
        y -= font.line_height();
        begin = end == all.end() ? end : end + 1;
    }
    if (made.contours.empty()) made.fault = "characters without an outline";
    return made;
}
#else
GlyphOutlines glyph_outlines(const std::string& text, const std::string&)
{
    return {{},
            fmt::format("{} characters and a build without stb_truetype, which reads fonts",
                        characters(text).size())};
}
#endif

}  // namespace knead
