// Files of splats are read and written in memory in proportion to their splats.
#include <gtest/gtest.h>
#include <malloc.h>

#include "host/files/webp.h"
#include "tests/files/splat_cases.h"
#include "tests/folder.h"
#include "tests/memory_of.h"
#include "tests/sanitized.h"

namespace knead {
namespace {

std::size_t bytes_of_cloud(const SplatCloud& c)
{
    return c.count() * (sizeof(Vec3<float>) * std::size_t(2 + harmonics(c.degree)) +
                        sizeof(Quat<float>) + sizeof(float));
}

using SplatMemory = InFolder;

// With the cloud itself, at most 1.5 times the cloud, and what does not grow with it.
TEST_F(SplatMemory, ReadingAndWritingTakeHalfOfTheSplatsMore)
{
    constexpr std::size_t constant = 14 << 20;  // parts, windows, codebooks
    const std::size_t count = sanitized ? 3000 : 250000;
    for (const int degree : {0, 3}) {
        const SplatCloud cloud = drawn(count, degree, 41);
        const double decoded = double(bytes_of_cloud(cloud));
        for (const std::string ending :
             {".ply", ".compressed.ply", ".splat", ".spz", ".4.spz", ".sog", ".glb"}) {
            if (ending == ".sog" && (!webp_available() || degree > 0)) continue;
            const std::string file = path("m" + ending);
            malloc_trim(0);
            const std::size_t writing =
                memory_of([&] { write_splats(file, cloud, ending == ".4.spz" ? 4 : 3); });
            malloc_trim(0);
            std::size_t read = 0;
            const std::size_t reading = memory_of([&] { read = read_splats(file).cloud.count(); });
            EXPECT_EQ(read, count) << ending;
            if (sanitized) continue;  // whose own memory is several times that
            const double kept = ending == ".splat" ? double(count) * 56 : decoded;
            // The encoder of libwebp takes some 36 bytes a pixel of noise.
            const double encoder = ending == ".sog" ? 36.0 * double(count) : 0;
            EXPECT_LE(double(writing), 0.5 * decoded + constant + encoder) << ending << degree;
            EXPECT_LE(double(reading), 1.5 * kept + constant) << ending << degree;
        }
    }
}

}  // namespace
}  // namespace knead
