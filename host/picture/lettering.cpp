// Letters are strokes of a pen between points of a lattice, 5 wide and 9 high: capitals from 0 down
// to 6, small letters from 2, descenders to 8. A point is two digits, x and y; a stroke that ends
// where it begins is a dot.
#include "host/picture/lettering.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <vector>

namespace knead {
namespace {

constexpr std::string_view box = "0040460600";

// From ' ' to '~'; "": drawn as a box.
constexpr std::string_view glyphs[] = {
    " ", "2024;2626", "1012;3032", "", "", "4006;0101;4545", "", "2022", "30212536", "10212516", "",
    "2125;0343", "2617", "1333", "2626", "4006",
    // 0 to 9
    "100105163645413010;1531", "112026;1636", "01103041420646", "011030414233;13334445361605",
    "36300444", "400003334445361605", "30100105163645443303", "004016",
    "100102133342413010;1304051636454433", "43130201103041453616",
    // : ; < = > ? @
    "2323;2626", "2323;2617", "410345", "0242;0444", "014305", "01103041422324;2626", "",
    // A to Z
    "062046;1434", "0006;003041423303;3344453606", "4130100105163645", "0006;003041453606",
    "40000646;0333", "400006;0333", "41301001051636454323", "0006;4046;0343", "1030;2026;1636",
    "4045361605", "0006;4004;1346", "000646", "0600234046", "06004640", "100105163645413010",
    "0006;003041423303", "100105163645413010;2446", "0006;003041423303;2346",
    "413010010213334445361605", "0040;2026", "000516364540", "002640", "0016233640", "0046;4006",
    "002340;2326", "00400646",
    // [ \ ] ^ _ `
    "30101636", "0046", "10303616", "122032", "0646", "1021",
    // a to z
    "4332120305163645;4246", "0006;0312324345361605", "4332120305163645", "4046;4332120305163645",
    "04444332120305163645", "40302126;1242", "4332120305163645;4247381807", "0006;0312324346",
    "2226;2020", "32372818;3030", "0006;0442;2346", "202536", "0206;03122326;23324346",
    "0206;0312324346", "120305163645433212", "0208;0312324345361605", "4248;4332120305163645",
    "0206;03123243", "43321203143445361605", "20253646;0242", "0205163645;4246", "022642",
    "0216233642", "0246;4206", "0226;4218", "02420646",
    // { | } ~
    "302113242536", "2027", "102133242516", "03123342"};
static_assert(std::size(glyphs) == 95);

void blend(std::uint8_t* rgb, double colour, double cover)
{
    for (int k = 0; k < 3; ++k)
        rgb[k] = std::uint8_t(std::lround((1 - cover) * rgb[k] + cover * colour));
}

}  // namespace

Lettering::Lettering(const std::string& text) : wide(step * double(text.size()) - (step - 4))
{
    for (std::size_t k = 0; k < text.size(); ++k) {
        const auto at = std::size_t(static_cast<unsigned char>(text[k])) - std::size_t(' ');
        const std::string_view glyph =
            at < std::size(glyphs) && !glyphs[at].empty() ? glyphs[at] : box;
        add(glyph.data(), glyph.size(), step * double(k));
    }
}

void Lettering::add(const char* glyph, std::size_t size, double left)
{
    const auto point = [&](std::size_t at) {
        return Point{left + (glyph[at] - '0'), double(glyph[at + 1] - '0')};
    };
    for (std::size_t at = 0; at + 3 < size; at += 2) {
        if (glyph[at] == ';') ++at;
        if (at + 3 >= size || glyph[at + 2] == ';') continue;
        strokes.push_back({point(at), point(at + 2)});
    }
}

double Lettering::distance(double x, double y) const
{
    double nearest = 1e9;
    for (const Stroke& s : strokes) {
        const double dx = s.to.x - s.from.x, dy = s.to.y - s.from.y, square = dx * dx + dy * dy;
        const double along = (x - s.from.x) * dx + (y - s.from.y) * dy;
        const double t = square > 0 ? std::clamp(along / square, 0.0, 1.0) : 0.0;
        nearest = std::min(nearest, std::hypot(x - s.from.x - t * dx, y - s.from.y - t * dy));
    }
    return nearest;
}

void write_text(Image& image, const std::string& text, double x, double y, double height)
{
    const Lettering line(text);
    const double unit = height / Lettering::capital, pen = std::max(0.45, 0.55 / unit);
    const double edge = pen + 1.2 / unit, wide = line.width();
    const double left = x - unit * wide / 2, top = y - unit * 3, room = 1 + unit * edge;
    const auto column = [&](double at) { return int(std::clamp(at, 0.0, double(image.width))); };
    const auto row = [&](double at) { return int(std::clamp(at, 0.0, double(image.height))); };
    for (int j = row(top - room); j < row(top + unit * 8 + room + 1); ++j)
        for (int i = column(left - room); i < column(left + unit * wide + room + 1); ++i) {
            const double nearest = line.distance((i + 0.5 - left) / unit, (j + 0.5 - top) / unit);
            const auto cover = [&](double radius) {
                return std::clamp(unit * (radius - nearest) + 0.5, 0.0, 1.0);
            };
            std::uint8_t* const rgb =
                image.rgb.data() + 3 * (std::size_t(j) * std::size_t(image.width) + std::size_t(i));
            blend(rgb, 30, 0.8 * cover(edge));
            blend(rgb, 255, cover(pen));
        }
}

}  // namespace knead
