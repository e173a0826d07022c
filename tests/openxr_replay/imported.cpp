#include "tests/openxr_replay/imported.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstring>

#include "render/gl.h"

namespace knead::replay {
namespace {

constexpr GLenum opaque_fd = 0x9586;  // GL_HANDLE_TYPE_OPAQUE_FD_EXT

// What Mesa's software renderers (22 and later) expect at the start of memory that they import: the
// size, where its use begins, and the first half of the SHA-1 of the renderer's name. Where it
// begins stands once more right before it, for the end of the mapping.
struct Header {
    std::uint64_t size, begin;
    unsigned char renderer[16];
};
constexpr Header llvmpipe{0,
                          4096,
                          {0x6c, 0xb9, 0xee, 0x07, 0x4a, 0x0b, 0xad, 0x7b, 0x01, 0x2e, 0x1b, 0xe9,
                           0x69, 0x7e, 0x53, 0x0f}};

// A file without a name of that memory; -1: there is none to be had.
int memory_of(std::uint64_t size)
{
    Header header = llvmpipe;
    header.size = header.begin + size;
    const int made = ::memfd_create("openxr_replay", MFD_CLOEXEC);
    if (made < 0) return -1;
    const auto write = [&](const void* from, std::size_t bytes, std::uint64_t at) {
        return ::pwrite(made, from, bytes, off_t(at)) == ssize_t(bytes);
    };
    if (::ftruncate(made, off_t(header.size)) == 0 && write(&header, sizeof header, 0) &&
        write(&header.begin, sizeof header.begin, header.begin - sizeof header.begin))
        return made;
    ::close(made);
    return -1;
}

// More than rows and tiles of any of our formats need.
std::uint64_t size_of(int width, int height, int layers)
{
    constexpr int tile = 64, largest_texel = 8;
    const auto whole = [](int side) { return std::uint64_t(side + tile - 1) / tile * tile; };
    return whole(width) * whole(height) * std::uint64_t(layers) * largest_texel + (1u << 16);
}

template <class Function>
Function* function(const GlGuardSource& gl, const char* name)
{
    return reinterpret_cast<Function*>(gl.address(name));
}

}  // namespace

bool ImportedMemory::give(const GlGuardSource& gl, unsigned texture, unsigned format, int width,
                          int height, int layers)
{
    const auto* renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    if (!renderer || !std::strstr(renderer, "llvmpipe")) return false;
    const auto create = function<void(int, unsigned*)>(gl, "glCreateMemoryObjectsEXT");
    const auto import =
        function<void(unsigned, std::uint64_t, unsigned, int)>(gl, "glImportMemoryFdEXT");
    const auto plain = function<void(unsigned, int, unsigned, int, int, unsigned, std::uint64_t)>(
        gl, "glTextureStorageMem2DEXT");
    const auto array =
        function<void(unsigned, int, unsigned, int, int, int, unsigned, std::uint64_t)>(
            gl, "glTextureStorageMem3DEXT");
    free = function<void(int, const unsigned*)>(gl, "glDeleteMemoryObjectsEXT");
    if (!create || !import || !plain || !array || !free) return false;
    const std::uint64_t size = size_of(width, height, layers);
    const int file = memory_of(size);
    if (file < 0) return false;
    unsigned object = 0;
    create(1, &object);
    import(object, size, opaque_fd, file);  // the file is OpenGL's
    if (glGetError() != 0) {
        free(1, &object);
        return false;
    }
    objects.push_back(object);
    if (layers > 1)
        array(texture, 1, format, width, height, layers, object, 0);
    else
        plain(texture, 1, format, width, height, object, 0);
    return true;
}

void ImportedMemory::unmap()
{
    if (!objects.empty()) free(int(objects.size()), objects.data());
    objects.clear();
}

}  // namespace knead::replay
