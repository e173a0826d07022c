// A picture in which nothing moves is drawn once, whole.
#include <gtest/gtest.h>

#include "host/desktop/view_still.h"

namespace knead {
namespace {

TEST(StillPicture, IsDrawnWholeOnceWhenNothingMoves)
{
    const auto ball = [](float shift) {
        std::vector<Mesh> meshes(1);
        meshes[0].vertices = {{shift, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        meshes[0].triangles = {{0, 1, 2}};
        return std::make_shared<const std::vector<Mesh>>(meshes);
    };
    PictureContent content;
    content.view.width = 64, content.view.height = 48;
    content.within = 0.001f;
    content.meshes = ball(0);
    StillPicture still;
    still.update(content, 1);
    EXPECT_FALSE(still.due(1.1));
    EXPECT_TRUE(still.due(1 + StillPicture::rest));
    still.drawn_full();
    EXPECT_TRUE(still.full_resolution());
    content.meshes = ball(0.0005f);
    still.update(content, 2);
    EXPECT_TRUE(still.full_resolution()) << "clay that trembles by less than is seen";
    content.meshes = ball(0.01f);
    still.update(content, 3);
    EXPECT_FALSE(still.full_resolution() || still.due(3.1));
    still.drawn_full();
    content.view.position.x = 0.1f;
    still.update(content, 4);
    EXPECT_FALSE(still.full_resolution()) << "the camera moved";
    still.drawn_full();
    content.hands = {1, 2, 3};
    still.update(content, 5);
    EXPECT_FALSE(still.full_resolution()) << "a hand came";
    still.drawn_full();
    content.hidden = {0};
    still.update(content, 5.5);
    EXPECT_FALSE(still.full_resolution()) << "an object was hidden";
    still.drawn_full();
    still.forget();
    still.update(content, 6);
    EXPECT_FALSE(still.full_resolution()) << "what was drawn is lost";
}

}  // namespace
}  // namespace knead
