// One format for libFuzzer: a program of this file and the define KNEAD_FORMAT, its name. The seeds
// are written by knead_fuzz --seeds FOLDER.
#include <cstdint>
#include <cstring>

#include "tests/fuzz/formats.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

const knead::FuzzFormat& format()
{
    for (const knead::FuzzFormat& one : knead::fuzz_formats())
        if (std::strcmp(one.name, KNEAD_FORMAT) == 0) return one;
    throw std::logic_error("no format " KNEAD_FORMAT);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    static const knead::FuzzFormat& chosen = format();
    try {
        chosen.read({reinterpret_cast<const char*>(data), size});
    } catch (const knead::InputError&) {
    }
    return 0;
}
