// What a display shows of a state that was a while ago.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "host/live/live_session.h"
#include "host/solver/editable_simulator.h"

namespace knead {
namespace {

TEST(MotionStamp, GoesOnByWhatHasPassedAndNoMoreThanItCame)
{
    const MotionStamp at{2, 0.5};
    EXPECT_EQ(at.extrapolation(1), 0);
    EXPECT_EQ(at.extrapolation(2), 0);
    EXPECT_FLOAT_EQ(at.extrapolation(2.125), 0.25f);
    EXPECT_EQ(at.extrapolation(3), 1);
    EXPECT_EQ((MotionStamp{2, 0}.extrapolation(3)), 0) << "nothing is known";
}

// Of every fourth point to a mesh, along the normal of its nearest vertex: root of the mean square
// [m].
double distance(const std::vector<Vec3<float>>& points, const Mesh& mesh)
{
    double sum = 0;
    long count = 0;
    for (std::size_t i = 0; i < points.size(); i += 4) {
        const Vec3<float> x = points[i];
        std::size_t nearest = 0;
        float least = 1e30f;
        for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
            const Vec3<float> d = x - mesh.vertices[v];
            if (dot(d, d) < least) least = dot(d, d), nearest = v;
        }
        const float along = dot(x - mesh.vertices[nearest], mesh.normals[nearest]);
        sum += double(along * along), ++count;
    }
    return std::sqrt(sum / double(count));
}

std::vector<Vec3<float>> carried(const Mesh& mesh, float extrapolation)
{
    std::vector<Vec3<float>> points = mesh.vertices;
    for (std::size_t v = 0; v < points.size(); ++v)
        points[v] = points[v] + extrapolation * mesh.advance[v] * mesh.normals[v];
    return points;
}

LiveOptions stepped()
{
    LiveOptions options;
    options.make_solver = [](const Setup& setup) { return cpu_solver(setup); };
    options.stepped = true, options.with_motion = true;
    return options;
}

// A state shown a frame later, carried on, against the state that is there by then, while recorded
// hands squeeze a ball that trembles after its fall: nearer than shown as it is, all in all (0.37
// mm instead of 0.51) and in most frames.
TEST(LiveMotion, CarriedOnASurfaceIsNearerToTheNextOne)
{
    const auto scene = load_live_scene("scenes/squeeze.json",
                                       {"domain.cells=32", "surface.nodes=40", "step.courant=0.9"});
    LiveSession session(scene, stepped());
    const double frame = 1 / scene->scene.frame_rate;
    double plain = 0, carried_on = 0;
    int nearer = 0, frames = 0;
    Meshes before;
    MotionStamp then;
    for (int k = 1; k <= 200; ++k) {
        session.advance_to((k + 0.5) * frame);
        const auto state = session.state();
        ASSERT_EQ(state->failure, "");
        ASSERT_EQ(state->meshes->size(), 1u);
        if (k > 2 && k % 3 > 0) {
            const Mesh& now = state->meshes->front();
            ASSERT_NEAR(then.step, frame, 1e-9);
            const float extrapolation = then.extrapolation(then.time + frame);
            const double as_is = distance(before->front().vertices, now);
            const double on = distance(carried(before->front(), extrapolation), now);
            if (std::getenv("KNEAD_SHOW"))
                std::printf("frame %d: %.3g mm as it is, %.3g carried on\n", k, 1e3 * as_is,
                            1e3 * on);
            plain += as_is, carried_on += on, nearer += on < as_is, ++frames;
        }
        before = state->meshes, then = state->mesh_stamp;
    }
    EXPECT_GE(frames, 100);
    EXPECT_LT(carried_on, 0.8 * plain);
    EXPECT_GE(nearer, frames * 7 / 10);
}

}  // namespace
}  // namespace knead
