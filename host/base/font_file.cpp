#include "host/base/font_file.h"

#include <array>
#include <cstring>
#include <fstream>

namespace knead {
namespace {

// Dear ImGui ends the program at a file that is no font.
bool is_font(const char* path)
{
    std::array<char, 4> begin{};
    std::ifstream file(path, std::ios::binary);
    return file.read(begin.data(), begin.size()) && std::memcmp(begin.data(), "\0\1\0\0", 4) == 0;
}

}  // namespace

std::string font_file()
{
    constexpr const char* usual[] = {
        "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf", "/usr/share/fonts/TTF/DejaVuSans.ttf",
        "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
        "/usr/share/fonts/truetype/noto/NotoSans-Regular.ttf",
        "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf"};
    for (const char* one : usual)
        if (is_font(one)) return one;
    return {};
}

}  // namespace knead
