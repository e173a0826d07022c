// knead bench --peers: what a peer is handed, and what the results say of one that answers, and of
// one that does not. A shell script stands where Python would be.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>

#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/bench/bench.h"
#include "tests/folder.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

const PeerOptions small{16, 4, 1, 60};  // 2144 particles, 20 substeps

// Programs are looked for in `first`, then where they were; or, `alone`, only there.
class Path {
  public:
    Path(const std::string& first, bool alone) : before(std::getenv("PATH"))
    {
        setenv("PATH", (alone ? first : first + ":" + before).c_str(), 1);
    }
    Path(const Path&) = delete;
    ~Path() { setenv("PATH", before.c_str(), 1); }

  private:
    const std::string before;
};

class Peers : public InFolder {
  protected:
    // The results with a peer that does this: $2 is the scene, $3 the places, $5 when it projects.
    const Bench& bench(const std::string& does, PeerOptions options = small)
    {
        fs::create_directories(folder / "bin");
        write_whole(path("bin/python3"), "#!/bin/sh\n" + does + "\n");
        fs::permissions(folder / "bin/python3", fs::perms::owner_all);
        return run(false, options);
    }
    const Bench& run(bool alone, const PeerOptions& options = small)
    {
        const Path here(path("bin"), alone);
        of->result.peers.clear();
        run_peers(*of, options);
        EXPECT_EQ(of->result.peers.size(), 2u);
        return *of;
    }
    // One for all: it measures the machine first.
    static void SetUpTestSuite()
    {
        BenchOptions o;
        o.device = "cpu", o.data = "none", o.quiet = true;
        of = std::make_unique<Bench>(o);
    }
    static void TearDownTestSuite() { of.reset(); }

  private:
    inline static std::unique_ptr<Bench> of;
};

// A ball's middle, and the standard deviation of its places: 0.25 m / sqrt(5).
const char* const answer =
    R"(echo '{"substep_us": 12.5, "centre": [0.5, 0.5, 0.5], "extent": [0.1118, 0.1118, 0.1118]}')";

TEST_F(Peers, AreHandedTheSceneAndComparedWithOurs)
{
    const Bench& done = bench("cp \"$2\" " + path("scene.json") + "; cp \"$3\" " + path("x.f32") +
                              "; echo \"$5\" >>" + path("asked") + "\necho hello\n" + answer);
    for (const PeerRow& row : done.result.peers) {
        EXPECT_EQ(row.problem, "");
        EXPECT_DOUBLE_EQ(row.substep, 12.5e-6);
        EXPECT_GT(row.ours, 0);
        EXPECT_LT(row.apart, 2e-3);
        EXPECT_GT(row.apart, 0);
    }
    EXPECT_EQ(read_text(path("asked"), 100), "each-substep\neach-frame\n");
    const Json scene = read_json(path("scene.json"));
    EXPECT_EQ(scene["nodes"], 16);
    EXPECT_EQ(scene["frames"], 4);
    EXPECT_EQ(scene["warm_frames"], 1);
    EXPECT_EQ(scene["spheres"].size(), 5u);
    EXPECT_EQ(scene["particles"].get<std::size_t>() * 12, fs::file_size(path("x.f32")));
    EXPECT_NEAR(scene["particles"].get<double>() * scene["volume"].get<double>(),
                4.0 / 3 * M_PI * std::pow(0.25, 3), 1e-3);
    // Both cones close at 1 m/s: in 20 substeps of 0.1 ms, 2 mm each.
    const Json &first = scene["spheres"].front(), &end = scene["spheres"].back();
    for (std::size_t s = 0; s < 4; ++s)
        EXPECT_NEAR(end[s][0].get<double>() - first[s][0].get<double>(), s < 2 ? 2e-3 : -2e-3,
                    1e-9);
    const Json all = bench_json(done)["peers"];
    EXPECT_EQ(all[0]["name"], "taichi");
    EXPECT_DOUBLE_EQ(all[0]["times_as_long"].get<double>() * all[0]["ours_us"].get<double>(), 12.5);
    EXPECT_NE(bench_text(done).find("taichi, projecting once a frame"), std::string::npos);
}

// What is said of a peer that does this; the same in the text, in the JSON and in the row.
TEST_F(Peers, ThatGiveNoFiguresAreNamedWithTheReason)
{
    const auto said = [&](const Bench& done) {
        const std::string why = done.result.peers.at(0).problem;
        const Json all = bench_json(done)["peers"];
        EXPECT_EQ(all[0], (Json{{"name", "taichi"}, {"problem", why}}));
        EXPECT_NE(bench_text(done).find(why), std::string::npos);
        return why;
    };
    EXPECT_EQ(said(bench("echo a fault >&2; exit 4")), "no figures: it ended with 4");
    EXPECT_EQ(said(bench("echo '{\"substep_us\": -1}'; echo rubbish")),
              "no figures: it ended with 0");
    EXPECT_EQ(said(bench("exit 3")), "not run: Python has no taichi here");
    EXPECT_EQ(said(bench("kill -9 $$")), "no figures: it ended with 137");
    PeerOptions brief = small;
    brief.limit = 0.2;
    EXPECT_EQ(said(bench(std::string(answer) + "\nexec sleep 60", brief)),
              "no figures: it took more than 0.2 s");
    fs::remove(path("bin/python3"));
    EXPECT_EQ(said(run(true)), "not run: no program python3");
}

TEST_F(Peers, AnswerAloneAndNothingIsLeftBehind)
{
    const Bench& done = bench("[ \"$5\" = each-frame ] && exit 4\n" + std::string(answer) +
                              "\ndirname \"$2\" >" + path("where"));
    EXPECT_EQ(done.result.peers[0].problem, "");
    EXPECT_EQ(done.result.peers[1].problem, "no figures: it ended with 4");
    std::string where = read_text(path("where"), 1000);
    where.pop_back();
    EXPECT_FALSE(fs::exists(where)) << where;
}

}  // namespace
}  // namespace knead
