// Pictures to PNG files and back.
#include <png.h>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/files/image.h"

namespace knead {
namespace {

[[noreturn]] void refuse_png(const std::string& path, const std::string& reason)
{
    throw OutputError(path + ": the picture cannot be written: " + reason);
}

void check(const std::string& path, const Image& image)
{
    const std::string size = std::to_string(image.width) + " x " + std::to_string(image.height);
    if (image.width < 1 || image.height < 1) refuse_png(path, "it is " + size + " pixels");
    const std::size_t bytes = std::size_t(3) * std::size_t(image.width) * std::size_t(image.height);
    if (image.rgb.size() != bytes) {
        refuse_png(path, size + " pixels need " + std::to_string(bytes) + " bytes, but there are " +
                             std::to_string(image.rgb.size()));
    }
}

std::string encoded(const std::string& path, const Image& image)
{
    png_image head{};
    head.version = PNG_IMAGE_VERSION;
    head.width = png_uint_32(image.width);
    head.height = png_uint_32(image.height);
    head.format = PNG_FORMAT_RGB;
    // No picture of that size comes out longer.
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(head);
    std::string bytes(size, '\0');
    if (!png_image_write_to_memory(&head, bytes.data(), &size, 0, image.rgb.data(), 0, nullptr))
        refuse_png(path, head.message);
    bytes.resize(size);
    return bytes;
}

}  // namespace

void write_png(const std::string& path, const Image& image)
{
    check(path, image);
    write_whole(path, encoded(path, image));
}

Image read_png(const std::string& path)
{
    const auto refuse = [&](const std::string& why) {
        throw InputError(path + ": no picture that can be read: " + why);
    };
    const std::string bytes = read_text(path, std::size_t(1) << 30);
    png_image head{};
    head.version = PNG_IMAGE_VERSION;
    if (!png_image_begin_read_from_memory(&head, bytes.data(), bytes.size())) refuse(head.message);
    if (std::size_t(head.width) * head.height > max_picture_pixels) {
        png_image_free(&head);
        refuse(std::to_string(head.width) + " x " + std::to_string(head.height) +
               " pixels; expected at most " + std::to_string(max_picture_pixels) + " in all");
    }
    head.format = PNG_FORMAT_RGB;
    Image image{int(head.width), int(head.height), {}};
    image.rgb.resize(PNG_IMAGE_SIZE(head));
    const png_color black{0, 0, 0};  // what shows through is drawn over it
    if (!png_image_finish_read(&head, &black, image.rgb.data(), 0, nullptr)) refuse(head.message);
    return image;
}

}  // namespace knead
