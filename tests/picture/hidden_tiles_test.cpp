// Tiles that no lens shows: which they are, and that the others do not notice.
#include "host/picture/hidden_tiles.h"

#include <gtest/gtest.h>

#include "host/picture/splat_layer.h"
#include "host/splats/generate.h"
#include "host/splats/raster.h"

namespace knead {
namespace {

EyeView eye_of(int width, int height)
{
    EyeView view;
    view.left = -1.2f, view.right = 0.8f, view.down = -0.9f, view.up = 1.1f;
    view.width = width, view.height = height;
    return view;
}

EyeView eye_before(int width, int height)
{
    EyeView view = eye_of(width, height);
    view.position = {0, 0, 3};
    return view;
}

SplatCloud some_splats()
{
    SplatCloud cloud;
    cloud.degree = 0;
    for (int i = 0; i < 400; ++i) {
        const float x = float(i % 20) / 5 - 2, y = float(i / 20) / 5 - 2;
        cloud.centre.push_back({x, y, 0.1f * float(i % 7)});
        cloud.rotation.push_back({1, 0, 0, 0});
        cloud.scale.push_back({0.15f, 0.1f, 0.05f});
        cloud.opacity.push_back(0.6f);
        cloud.sh.push_back({0.5f, 0.1f * float(i % 5), 0.2f});
    }
    return cloud;
}

TEST(HiddenTiles, AreThoseOfWhichNoPixelNorNeighbourIsSeen)
{
    const EyeView view = eye_of(128, 96);
    HiddenTiles hidden;
    EXPECT_TRUE(hidden.of(view).empty());
    // The upper left quarter of the picture, in two triangles.
    const std::array<float, 2> a{-1.2f, 1.1f}, b{-0.2f, 1.1f}, c{-1.2f, 0.1f}, d{-0.2f, 0.1f};
    hidden.set({a, b, c, c, b, d});
    const std::vector<char> tiles = hidden.of(view);
    ASSERT_EQ(tiles.size(), 8u * 6u);
    // 64 by 48 pixels, whose last column and row have neighbours that are seen.
    for (int y = 0; y < 6; ++y)
        for (int x = 0; x < 8; ++x)
            EXPECT_EQ(int(tiles[std::size_t(8 * y + x)]), int(x < 3 && y < 2)) << x << " " << y;
    // Of a coarser picture they are others.
    EXPECT_EQ(hidden.of(eye_of(64, 48)).size(), 4u * 3u);
    EXPECT_EQ(int(hidden.of(eye_of(64, 48))[0]), 1);
    hidden.set({});
    EXPECT_TRUE(hidden.of(view).empty());
}

TEST(HiddenTiles, AreLeftEmptyAndNoOtherPixelChanges)
{
    const EyeView view = eye_before(128, 96);
    const SplatCloud cloud = some_splats();
    SplatFrame frame;
    frame.eyes = {splat_eye(view)};
    const Picture whole = cpu_raster(cloud, frame).front();
    HiddenTiles hidden;
    hidden.set({{-1.2f, 1.1f}, {0.8f, 1.1f}, {-1.2f, -0.9f}});
    frame.hidden = {hidden.of(view)};
    const Picture part = cpu_raster(cloud, frame).front();
    int left_out = 0, covered = 0;
    for (int y = 0; y < 96; ++y)
        for (int x = 0; x < 128; ++x) {
            const std::size_t at = std::size_t(128 * y + x);
            const bool empty = frame.hidden[0][std::size_t(8 * (y / 16) + x / 16)];
            left_out += empty;
            covered += empty && whole.alpha[at] > 0.5f;
            ASSERT_EQ(part.alpha[at], empty ? 0 : whole.alpha[at]) << x << " " << y;
            ASSERT_EQ(part.depth[at], empty ? no_depth : whole.depth[at]);
            ASSERT_EQ(part.colour[at].x, empty ? 0 : whole.colour[at].x);
        }
    EXPECT_GT(left_out, 128 * 96 / 4) << "most of the half that is hidden";
    EXPECT_GT(covered, 1000) << "splats would have been drawn there";
    frame.hidden = {{1, 1}};
    EXPECT_THROW(cpu_raster(cloud, frame), std::invalid_argument);
}

// What a live session draws, as far as splats go: fine around the lens's middle, blocks beside it.
TEST(SplatLayers, AreCoarseBesideAFovea)
{
    const EyeView view = eye_before(320, 320);  // whose axis meets pixel (192, 176)
    SplatDrawer drawer(some_splats(), Device{DeviceKind::cpu}, 1);
    const SplatLayer fine = drawer.layer(view, {}, true);
    drawer.foveate({0, 0, 0.1f, 0.3f});
    const SplatLayer found = drawer.layer(view, {}, true);
    const auto at = [](int x, int y) { return std::size_t(4 * (320 * y + x)); };
    int blocks = 0, changed = 0;
    for (int y = 0; y < 320; ++y)
        for (int x = 0; x < 320; ++x) {
            const std::size_t i = at(x, y);
            if (x / 64 == 3 && y / 64 == 2) {
                ASSERT_EQ(found.colour[i], fine.colour[i]) << x << " " << y;
            }
            changed += found.colour[i] != fine.colour[i];
            blocks += found.colour[i] == found.colour[at(x / 4 * 4, y / 4 * 4)];
        }
    EXPECT_GT(changed, 20000);
    EXPECT_GT(blocks, 50000);
}

}  // namespace
}  // namespace knead
