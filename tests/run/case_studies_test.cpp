// The case studies of scenes/cases: logs of commands with recorded hands. What stands, touches and
// is counted is checked on both back ends, and the hash of the state at the end on the CPU, as in
// golden_test.cpp: with it, knead_golden holds the test for the CPU.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>

#include "host/cli/run_options.h"
#include "host/cli/script.h"
#include "host/paging/scene_splats.h"
#include "host/scene/scene_hands.h"
#include "host/scene/seed.h"
#include "host/session/backend.h"
#include "host/solver/audit.h"
#include "tests/folder.h"
#include "tests/session/clay_rows.h"

namespace knead {
namespace {

#if defined(KNEAD_VERIFY) || !defined(__FMA__)
constexpr bool bits_as_written = true;
#else
constexpr bool bits_as_written = false;
#endif

bool is_long() { return std::getenv("KNEAD_LONG"); }

using Points = std::vector<Vec3<double>>;

// One run of a study: its log without `save`, with a look at the clay after chosen frames.
class Study {
  public:
    Study(const std::string& name, int cells, bool gpu) : on_gpu(gpu)
    {
        options.scene = "scenes/cases/" + name + ".json";
        options.cells = cells, options.quiet = true, options.out = folder.path().string();
        options.commands = folder / "log.jsonl";
        options.deterministic = true;
        std::ifstream from("scenes/cases/" + name + ".jsonl");
        std::ofstream to(options.commands);
        for (std::string line; std::getline(from, line);)
            if (line.find("\"save\"") == std::string::npos) to << line << "\n";
    }
    // Before and after the commands that follow frame `number`.
    std::map<int, std::function<void()>> before, after;

    void run(int frames)
    {
        Scene scene = scene_of(options);
        RunScript log(options, scene, [](const std::string&) {});
        build(scene, std::size_t(1) << 31);
        SceneSplats splats(scene, {});
        HandSource hands(hands_of(scene), scene.hands);
        solver = on_gpu ? gpu_solver(scene.setup, 0) : cpu_solver(scene.setup);
        dx = scene.setup.lattice.dx;
        RunObserver watch;
        log.play(scene, splats, *solver, &hands, frames, watch);
        script = &log;
        const auto commands = watch.edits;
        watch.edits = [&](int number, SessionLoop& loop) {
            const auto look = [&](const std::map<int, std::function<void()>>& at) {
                if (const auto found = at.find(number); found != at.end())
                    loop.edit([does = found->second](EditableSimulator&) { does(); });
            };
            look(before), commands(number, loop), look(after);
        };
        BatchRunOptions rule;
        rule.frames = frames, rule.audit_every = frames;
        record = run_frames(scene, *solver, &hands, rule, watch);
        EXPECT_EQ(record.end, End::complete) << record.failure;
        EXPECT_EQ(log.left(), 0u);
        if (last) last();
        script = nullptr;
    }
    std::function<void()> last;  // after the last frame

    std::string hash() const { return hexadecimal(record.rows.back().state.hash); }
    ClayRows rows() const { return solver->rows(*solver->snapshot()); }
    const Document& document() const { return script->document(); }
    const SceneObject& object(const std::string& name) const
    {
        const ObjectId id = std::get<ObjectId>(resolved(document(), ObjectRef(name)));
        return *document().find(id);
    }
    Points clay(const std::string& name) const
    {
        const std::vector<int> numbers = script->simulated(object(name).id);
        Points found;
        for (const Particle<double>& p : solver->save().contents.particles)
            if (std::ranges::count(numbers, p.object)) found.push_back(p.x);
        EXPECT_FALSE(found.empty()) << name;
        return found;
    }

    const bool on_gpu;
    Folder folder;
    RunOptions options;
    double dx = 0;
    std::unique_ptr<EditableSimulator> solver;
    RunScript* script = nullptr;
    RunRecord record;
};

Vec3<double> middle(const Points& points)
{
    Vec3<double> sum{};
    for (const Vec3<double> x : points) sum = sum + x;
    return (1 / double(points.size())) * sum;
}
double highest(const Points& points)
{
    double y = -1e9;
    for (const Vec3<double> x : points) y = std::max(y, x.y);
    return y;
}
double lowest(const Points& points)
{
    double y = 1e9;
    for (const Vec3<double> x : points) y = std::min(y, x.y);
    return y;
}
// The smallest distance of a particle of `a` from one of `b`.
double gap(const Points& a, const Points& b)
{
    double least = 1e9;
    for (const Vec3<double> x : a)
        for (const Vec3<double> y : b) least = std::min(least, dot(x - y, x - y));
    return std::sqrt(least);
}

class CaseStudies : public ::testing::TestWithParam<bool> {
  protected:
    void SetUp() override
    {
        if (GetParam() && !gpu_present()) GTEST_SKIP() << "no GPU";
    }
    // Of the state at the end of a study, where its bits are those of the formulas as written.
    void expect_hash(const Study& study, const std::string& cpu) const
    {
        if (GetParam() || !bits_as_written) return;
        EXPECT_EQ(study.hash(), cpu);
    }
};

TEST_P(CaseStudies, ASnowmanGetsDentsCoalAndAHatAndStands)
{
    Study study("snowman", 48, GetParam());
    // Before the stylus and after it: by how much snow begins deeper along a line from the front.
    struct Line {
        const char* ball;
        double across, up, front;
    };
    std::vector<Line> lines;
    for (const double side : {-1, 1}) lines.push_back({"head", side * 0.033, 0.022, 0});
    for (const double up : {0.034, -0.01, -0.054}) lines.push_back({"belly", 0, up, 0});
    const auto front = [&](const Line& line) {
        const Points ball = study.clay(line.ball);
        const Vec3<double> c = middle(ball);
        double z = -1e9;
        for (const Vec3<double> x : ball)
            if (std::hypot(x.x - c.x - line.across, x.y - c.y - line.up) < 0.6 * study.dx)
                z = std::max(z, x.z - c.z);
        return z;
    };
    study.before[20] = [&] {
        for (Line& line : lines) line.front = front(line);
    };
    study.before[136] = [&] {
        for (const Line& line : lines)
            EXPECT_GT(line.front - front(line), 0.4 * study.dx) << line.ball << " " << line.up;
    };
    ClayRows before, after;
    study.before[172] = [&] { before = study.rows(); };
    std::map<std::string, Vec3<double>> stood;
    study.after[172] = [&] {
        after = study.rows();
        EXPECT_EQ(study.document().objects.size(), 15u);
        for (const auto& one : study.document().objects)
            stood[one->name] = middle(study.clay(one->name));
    };
    study.last = [&] {
        for (const auto& [name, was] : stood)
            EXPECT_LT(length(middle(study.clay(name)) - was), 1.0 * study.dx) << name;
        for (const auto& [a, b] : {std::pair{"foot", "belly"}, std::pair{"belly", "head"}})
            EXPECT_LT(gap(study.clay(a), study.clay(b)), 0.8 * study.dx) << b;
        for (const char* name : {"brim", "left eye", "right eye", "nose", "scarf"})
            EXPECT_LT(gap(study.clay("head"), study.clay(name)), 1.2 * study.dx) << name;
        for (const char* name : {"button 1", "button 2", "button 3", "left arm", "right arm"})
            EXPECT_LT(gap(study.clay("belly"), study.clay(name)), 1.5 * study.dx) << name;
    };
    study.run(is_long() ? 172 + 600 : 186);
    EXPECT_TRUE(same_rows(before, after));  // five steps of undo and of redo
    expect_hash(study, is_long() ? "5f83032bc1e30fb8" : "095d39edfd62307a");
}

TEST_P(CaseStudies, AHamburgerHasLayersThatDoNotStick)
{
    Study study("hamburger", 32, GetParam());
    const std::vector<std::string> layers = {"lower bun", "patty", "cheese", "lettuce",
                                             "upper bun"};
    study.before[68] = [&] {  // flattened by the board from 0.06 m of height and 0.16 m of width
        const Points patty = study.clay("patty");
        EXPECT_LT(highest(patty) - lowest(patty), 0.045);
        double wide = 0;
        for (const Vec3<double> x : patty) wide = std::max(wide, std::fabs(x.x - middle(patty).x));
        EXPECT_GT(2 * wide, 0.17);
    };
    std::vector<Vec3<double>> rested;
    study.before[142] = [&] {
        EXPECT_EQ(study.document().objects.size(), 20u);
        double y = 0;
        for (const std::string& name : layers) {
            const Points clay = study.clay(name);
            rested.push_back(middle(clay));
            EXPECT_GT(rested.back().y, y) << name;
            EXPECT_NEAR(rested.back().x, 0.22, study.dx) << name;
            EXPECT_NEAR(rested.back().z, 0.22, study.dx) << name;
            y = rested.back().y;
        }
        for (std::size_t i = 1; i < layers.size(); ++i)
            EXPECT_LT(gap(study.clay(layers[i]), study.clay(layers[i - 1])), 1.2 * study.dx) << i;
    };
    // The bun comes off alone: no clay of another object goes with it, then or after.
    const auto bare = [&](double least) {
        EXPECT_GT(lowest(study.clay("upper bun")) - highest(study.clay("lettuce")), least);
        for (std::size_t i = 0; i + 1 < layers.size(); ++i)
            EXPECT_LT(length(middle(study.clay(layers[i])) - rested[i]), 0.3 * study.dx) << i;
    };
    study.after[142] = [&] { bare(0.04); };
    study.before[146] = [&] { bare(0.02); };
    study.run(150);
    expect_hash(study, "5a92999a78c478c9");
}

#ifdef KNEAD_GOLDEN_APART
INSTANTIATE_TEST_SUITE_P(OnAGpu, CaseStudies, ::testing::Values(true));
#else
INSTANTIATE_TEST_SUITE_P(OnTheCpu, CaseStudies, ::testing::Values(false));
#endif

}  // namespace
}  // namespace knead
