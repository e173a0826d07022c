// A live session whose surfaces and Gaussians stay on the device is the one that fetches them.
#include <gtest/gtest.h>

#include <thread>

#include "host/live/live_session.h"
#include "host/session/backend.h"
#include "host/solver/audit.h"

namespace knead {
namespace {

LiveOptions rule_of(bool on_device)
{
    LiveOptions options;
    options.make_solver = [](const Setup& setup) {
        return make_solver(setup, parse_device("cuda"));
    };
    options.stepped = true;
    options.on_device = on_device;
    return options;
}

TEST(LiveOnDevice, IsTheSameSession)
{
    if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    const auto scene = load_live_scene("scenes/pot.json", {"deterministic=true"});
    LiveSession kept(scene, rule_of(true)), fetched(scene, rule_of(false));
    std::shared_ptr<const LiveState> first;
    std::vector<Mesh> first_meshes;
    for (const double time : {0.0, 0.5, 1.0}) {
        kept.advance_to(time), fetched.advance_to(time);
        const auto a = kept.state(), b = fetched.state();
        ASSERT_EQ(a->failure + b->failure, "");
        ASSERT_TRUE(a->on_device && a->gaussians_on_device);
        ASSERT_TRUE(b->meshes && b->gaussians);
        EXPECT_FALSE(a->meshes || a->gaussians || b->on_device || b->gaussians_on_device);
        const Meshes found = meshes_of(*a);
        ASSERT_EQ(found->size(), b->meshes->size());
        for (std::size_t m = 0; m < found->size(); ++m) {
            const Mesh &x = (*found)[m], &y = (*b->meshes)[m];
            ASSERT_EQ(x.vertices.size(), y.vertices.size());
            ASSERT_EQ(x.triangles.size(), y.triangles.size());
            for (std::size_t i = 0; i < x.vertices.size(); ++i)
                ASSERT_EQ(length(x.vertices[i] - y.vertices[i]), 0) << time << ": " << i;
        }
        SplatFrame frame;
        a->gaussians_on_device->fetch(frame);
        ASSERT_EQ(frame.moved_centre.size(), b->gaussians->size());
        for (std::size_t i = 0; i < b->gaussians->size(); ++i) {
            const Gaussian<double>& g = (*b->gaussians)[i];
            ASSERT_EQ(length(frame.moved_centre[i] - cast<float>(g.x)), 0) << time << ": " << i;
            ASSERT_EQ(length(frame.moved_F[i].a - cast<float>(g.F.a)), 0) << time << ": " << i;
            ASSERT_EQ(length(frame.moved_F[i].c - cast<float>(g.F.c)), 0) << time << ": " << i;
        }
        if (!first) first = a, first_meshes = *found;
    }
    // A state that is held is as it was.
    const Meshes again = meshes_of(*first);
    ASSERT_EQ(again->size(), first_meshes.size());
    for (std::size_t m = 0; m < again->size(); ++m)
        EXPECT_EQ((*again)[m].triangles.size(), first_meshes[m].triangles.size());
}

// Graphs, surfaces and memory are there before the first frame; the clay is that of the scene.
TEST(LiveOnDevice, IsAsItWasThoughFramesWereRehearsed)
{
    if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    for (const char* file : {"scenes/squeeze.json", "scenes/pot.json", "scenes/ground.json"}) {
        const auto scene = load_live_scene(file, {"deterministic=true"});
        LiveOptions real = rule_of(true);
        real.stepped = false, real.manual_start = true;
        real.clock = [] { return 0.0; };
        LiveSession session(scene, real), wanted(scene, rule_of(true));
        const auto hash = [](LiveSession& of) {
            std::uint64_t found = 0;
            of.inspect_solver([&](const Simulator& s) {
                found = audit(s.particles(), s.editable()->config().materials,
                              s.editable()->config().lattice.dx)
                            .hash;
            });
            return found;
        };
        session.rehearse();
        session.wait_for_commands(), wanted.wait_for_commands();
        EXPECT_EQ(session.state()->failure, "");
        EXPECT_EQ(session.state()->frame.number, 0);
        EXPECT_EQ(hash(session), hash(wanted)) << file;
        session.send(Pause{true}), session.start();
        session.send(Advance{5});
        while (session.state()->frame.number < 5 && session.state()->failure.empty())
            std::this_thread::yield();
        wanted.advance_to(5.0 / scene->scene.frame_rate);
        EXPECT_EQ(hash(session), hash(wanted)) << file;
    }
}

// While it is paused, too: no frame comes that would make another mesh.
TEST(LiveOnDevice, HasTheSurfaceThatIsAskedForAtOnce)
{
    if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    const auto scene = load_live_scene("scenes/squeeze.json", {"domain.cells=16"});
    LiveSession session(scene, rule_of(true));
    session.advance_to(0.1);
    session.send(Pause{true});
    session.wait_for_commands();
    const auto triangles = [&] {
        const auto state = session.state();
        EXPECT_TRUE(state->on_device);
        return meshes_of(*state)->at(0).triangles.size();
    };
    const std::size_t before = triangles();
    session.send(SetSurface{2 * session.state()->surface.lattice.size.x});
    session.wait_for_commands();
    EXPECT_GT(triangles(), 2 * before);
}

}  // namespace
}  // namespace knead
