#include "tests/fuzz/formats.h"

namespace knead {

const std::vector<FuzzFormat>& fuzz_formats()
{
    static const std::vector<FuzzFormat> all = [] {
        std::vector<FuzzFormat> formats = mesh_formats();
        for (const auto& more : {cloud_formats(), session_formats()})
            formats.insert(formats.end(), more.begin(), more.end());
        return formats;
    }();
    return all;
}

}  // namespace knead
