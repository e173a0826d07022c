// Reads and writes PNG files.
#include <png.h>

#include <csetjmp>
#include <cstdio>
#include <new>
#include <utility>

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

// Encodes with libpng, row by row, cancellable between rows. libpng reports errors by longjmp,
// which skips no destructors here.
class Encoder {
  public:
    Encoder() : png(png_create_write_struct(PNG_LIBPNG_VER_STRING, this, fail, ignore))
    {
        if (png) info = png_create_info_struct(png);
        if (info) png_set_write_fn(png, this, append, nullptr);
    }
    ~Encoder() { png_destroy_write_struct(&png, &info); }
    Encoder(const Encoder&) = delete;
    Encoder& operator=(const Encoder&) = delete;

    enum class End { whole, given_up, failed };
    End encode(const Image& image, const std::function<bool()>& stop)
    {
        if (!info || setjmp(png_jmpbuf(png))) return End::failed;
        begin(image);
        if (!add_rows(image, stop)) return End::given_up;
        png_write_end(png, info);
        return End::whole;
    }

    std::string bytes;
    char reason[128] = "out of memory";

  private:
    void begin(const Image& image)
    {
        png_set_IHDR(png, info, png_uint_32(image.width), png_uint_32(image.height), 8,
                     PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                     PNG_FILTER_TYPE_DEFAULT);
        png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
        png_write_info(png, info);
    }
    bool add_rows(const Image& image, const std::function<bool()>& stop)
    {
        const std::size_t row = std::size_t(3) * std::size_t(image.width);
        for (std::size_t at = 0; at < image.rgb.size(); at += row) {
            if (stop && stop()) return false;
            png_write_row(png, image.rgb.data() + at);
        }
        return true;
    }

    static void append(png_structp png, png_bytep from, png_size_t count)
    {
        bool fits = true;
        try {
            static_cast<Encoder*>(png_get_io_ptr(png))
                ->bytes.append(reinterpret_cast<const char*>(from), count);
        } catch (const std::bad_alloc&) {
            fits = false;
        }
        if (!fits) png_error(png, "out of memory");
    }
    static void fail(png_structp png, png_const_charp why)
    {
        std::snprintf(static_cast<Encoder*>(png_get_error_ptr(png))->reason, sizeof reason, "%s",
                      why);
        png_longjmp(png, 1);
    }
    static void ignore(png_structp, png_const_charp) {}

    png_structp png = nullptr;
    png_infop info = nullptr;
};

}  // namespace

bool write_png(const std::string& path, const Image& image, const std::function<bool()>& stop)
{
    check(path, image);
    Encoder encoder;
    const Encoder::End end = encoder.encode(image, stop);
    if (end == Encoder::End::given_up) return false;
    if (end == Encoder::End::failed) refuse_png(path, encoder.reason);
    return write_whole_unless([&] { return stop && stop(); }, path, encoder.bytes);
}

std::string png_bytes(const Image& image)
{
    const std::string name = "picture";
    check(name, image);
    Encoder encoder;
    if (encoder.encode(image, {}) != Encoder::End::whole) refuse_png(name, encoder.reason);
    return std::move(encoder.bytes);
}

Image read_png(const std::string& path)
{
    return decoded_png(read_text(path, std::size_t(1) << 30), path);
}

Image decoded_png(const std::string& bytes, const std::string& path)
{
    const auto refuse = [&](const std::string& why) {
        throw InputError(path + ": no picture that can be read: " + why);
    };
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
    const png_color black{0, 0, 0};  // background for transparent pixels
    if (!png_image_finish_read(&head, &black, image.rgb.data(), 0, nullptr)) refuse(head.message);
    return image;
}

}  // namespace knead
