// Pictures to PNG files: written beside the target and renamed, so that no half file is ever seen.
#include <png.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "host/files/image.h"

namespace knead {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& reason)
{
    throw std::runtime_error("cannot write picture " + path + ": " + reason);
}

void check(const std::string& path, const Image& image)
{
    if (path.empty()) throw std::runtime_error("cannot write picture: the path is empty");
    const std::string size = std::to_string(image.width) + " x " + std::to_string(image.height);
    if (image.width < 1 || image.height < 1) fail(path, "it is " + size + " pixels");
    const std::size_t bytes = std::size_t(3) * std::size_t(image.width) * std::size_t(image.height);
    if (image.rgb.size() != bytes) {
        fail(path, size + " pixels need " + std::to_string(bytes) + " bytes, but there are " +
                       std::to_string(image.rgb.size()));
    }
}

// Empty if all went well, else the reason.
std::string encode(std::FILE* file, const Image& image)
{
    png_image head{};
    head.version = PNG_IMAGE_VERSION;
    head.width = png_uint_32(image.width);
    head.height = png_uint_32(image.height);
    head.format = PNG_FORMAT_RGB;
    if (!png_image_write_to_stdio(&head, file, 0, image.rgb.data(), 0, nullptr)) {
        const int error = errno;
        std::string reason = head.message;
        if (error != 0) reason += std::string(" (") + std::strerror(error) + ")";
        return reason;
    }
    return {};
}

}  // namespace

void write_png(const std::string& path, const Image& image)
{
    check(path, image);
    const std::string partial = path + ".partial-" + std::to_string(::getpid());
    std::FILE* file = std::fopen(partial.c_str(), "wb");
    if (!file) fail(path, std::strerror(errno));
    errno = 0;
    std::string reason = encode(file, image);
    if (std::fclose(file) != 0 && reason.empty()) reason = std::strerror(errno);
    if (reason.empty() && std::rename(partial.c_str(), path.c_str()) != 0) {
        reason = std::strerror(errno);
    }
    if (!reason.empty()) {
        std::remove(partial.c_str());
        fail(path, reason);
    }
}

}  // namespace knead
