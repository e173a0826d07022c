#include "host/base/font_file.h"

#include <cstdint>
#include <fstream>
#include <iterator>

namespace knead {

std::string font_bytes(const std::string& path)
{
    std::ifstream file(path, std::ios::binary);
    std::string bytes(std::istreambuf_iterator<char>(file), {});
    const auto number = [&](std::size_t at, int size) {  // of the most significant byte first
        std::uint64_t n = 0;
        for (int i = 0; i < size; ++i)
            n = n << 8 | static_cast<unsigned char>(bytes[at + std::size_t(i)]);
        return n;
    };
    constexpr std::size_t header = 12, entry = 16;
    if (bytes.size() < header || number(0, 4) != 0x10000) return {};
    const std::size_t tables = number(4, 2);
    if (tables == 0 || header + tables * entry > bytes.size()) return {};
    for (std::size_t i = 0; i < tables; ++i) {
        const std::size_t at = header + i * entry;
        if (number(at + 8, 4) + number(at + 12, 4) > bytes.size()) return {};
    }
    return bytes;
}

std::string font_file()
{
    constexpr const char* usual[] = {
        "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf", "/usr/share/fonts/TTF/DejaVuSans.ttf",
        "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
        "/usr/share/fonts/truetype/noto/NotoSans-Regular.ttf",
        "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf"};
    for (const char* one : usual)
        if (!font_bytes(one).empty()) return one;
    return {};
}

}  // namespace knead
