// An image, and PNG files.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace knead {

struct Image {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;  // 3 * width * height, sRGB, top row first
};

constexpr std::size_t max_picture_pixels = std::size_t(1) << 26;  // limit for reading

// Reads a PNG of any kind as 8 bits per channel. Throws InputError with path and reason.
Image read_png(const std::string& path);
// The same from a file's bytes; `path`: for messages.
Image decoded_png(const std::string& bytes, const std::string& path);
// The bytes of a PNG file. Throws OutputError.
std::string png_bytes(const Image& image);
// Writes a PNG atomically. Throws OutputError with path and reason. `stop` is polled between rows:
// if it returns true, nothing is written and the result is false.
bool write_png(const std::string& path, const Image& image, const std::function<bool()>& stop = {});

}  // namespace knead
