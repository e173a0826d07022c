#include "host/files/webp.h"

#include <fmt/format.h>

#include <new>

#include "host/base/errors.h"

#ifdef KNEAD_HAS_WEBP
#include <webp/decode.h>
#include <webp/encode.h>
#endif

namespace knead {

#ifdef KNEAD_HAS_WEBP

bool webp_available() { return true; }

RgbaImage read_webp(const std::string& bytes, const std::string& what, std::size_t most)
{
    const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
    RgbaImage image;
    if (!WebPGetInfo(data, bytes.size(), &image.width, &image.height))
        throw InputError(what + ": expected a WebP image, found something else");
    const std::size_t pixels = std::size_t(image.width) * std::size_t(image.height);
    if (pixels > most)
        throw InputError(fmt::format("{}: expected an image of at most {} pixels, found {} x {}",
                                     what, most, image.width, image.height));
    image.pixels.resize(4 * pixels);
    if (!WebPDecodeRGBAInto(data, bytes.size(), image.pixels.data(), image.pixels.size(),
                            4 * image.width))
        throw InputError(what + ": expected a whole WebP image, found a damaged one");
    return image;
}

std::string webp_bytes(const RgbaImage& image)
{
    WebPConfig config;
    WebPPicture picture;
    constexpr int effort = 3;  // of 9: the highest takes ten times as long for a few percent
    if (!WebPConfigInit(&config) || !WebPPictureInit(&picture)) throw std::bad_alloc();
    WebPConfigLosslessPreset(&config, effort);
    config.exact = 1;  // colours are kept where alpha is 0
    WebPMemoryWriter writer;
    WebPMemoryWriterInit(&writer);
    picture.use_argb = 1, picture.width = image.width, picture.height = image.height;
    picture.writer = WebPMemoryWrite, picture.custom_ptr = &writer;
    const bool written = WebPPictureImportRGBA(&picture, image.pixels.data(), 4 * image.width) &&
                         WebPEncode(&config, &picture);
    WebPPictureFree(&picture);
    std::string out;
    if (written) out.assign(reinterpret_cast<const char*>(writer.mem), writer.size);
    WebPMemoryWriterClear(&writer);
    if (!written) throw std::bad_alloc();
    return out;
}

#else

bool webp_available() { return false; }

namespace {

[[noreturn]] void refuse_webp()
{
    throw ResourceError("this program was built without libwebp, which SOG needs");
}

}  // namespace

RgbaImage read_webp(const std::string&, const std::string&, std::size_t) { refuse_webp(); }

std::string webp_bytes(const RgbaImage&) { refuse_webp(); }

#endif

}  // namespace knead
