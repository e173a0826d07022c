// Moving and scaling by one gesture is one step of undo.
#include "tests/ui/panel_session.h"

namespace knead {
namespace {

TEST(MoveStep, AMoveAndAScaleOfOneGestureAreUndoneTogether)
{
    PanelSession session;
    const ObjectId ball = session.live.state()->document->objects.at(0)->id;
    const auto size = [&] {
        const auto places = session.live.object_places();
        const Box3<double> box = places->find(ball)->box;
        return box.high - box.low;
    };
    const auto both = [&](unsigned move, unsigned scale) {
        session.panel.send(ScaleObjects{{ball}, 0.5}, session.live, scale);
        session.panel.send(MoveObjects{{ball}, Vec3<double>{0, 0.1, 0}, {}, {}}, session.live,
                           move);
        session.settle();
    };
    const Vec3<double> before = size();
    both(7, 7);
    EXPECT_LT(size().x, 0.6 * before.x);
    EXPECT_TRUE(session.act(Control::undo));
    EXPECT_NEAR(size().x, before.x, 0.05 * before.x);
    both(8, 9);
    EXPECT_TRUE(session.act(Control::undo));
    EXPECT_LT(size().x, 0.6 * before.x) << "two gestures are two";
    EXPECT_TRUE(session.act(Control::undo));
    EXPECT_NEAR(size().x, before.x, 0.05 * before.x);
}

}  // namespace
}  // namespace knead
