// `knead vr` on a GPU as in CI without one: CUDA's clay is shared with OpenGL, at a headset's size.
#include <gtest/gtest.h>

#ifdef KNEAD_XR_PROGRAM
#include "host/solver/editable_simulator.h"
#include "tests/vr/vr_run.h"

namespace knead {
namespace {

class KneadVrOnDevice : public KneadVr {
  protected:
    void SetUp() override
    {
        if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
        KneadVr::SetUp();
        for (auto& word : scene)
            if (word == "cpu") word = "cuda";
    }
};

TEST_F(KneadVrOnDevice, plays_the_squeeze_as_a_run_without_a_headset)
{
    Json script = squeeze();
    script["width"] = 2064, script["height"] = 2208;
    script["dump"] = path("dump"), script["dump_every"] = 100;
    scene = {"scenes/squeeze.json", "--device", "cuda", "--deterministic"};
    ASSERT_EQ(vr(script, {"--frames", "300", "--record", path("r.hands"), "--out", path("out"),
                          "--eye-scale", "1"}),
              exit_ok);
    expect_whole_squeeze(300);
    EXPECT_EQ(report["shared"], true);
}

TEST_F(KneadVrOnDevice, draws_what_the_goldens_of_software_show)
{
    Json script = squeeze();
    script["dump"] = path("dump");
    script["render_every"] = script["dump_every"] = 75;
    ASSERT_EQ(vr(script, {"--frames", "80", "--samples", "1", "--eye-scale", "1"}), exit_ok);
    expect_sound();
    EXPECT_EQ(report["shared"], true);
    expect_goldens();
}

}  // namespace
}  // namespace knead
#endif
