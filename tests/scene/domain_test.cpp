// Walls in metres: whatever the lattice, floor and objects stand where the scene says.
#include "host/scene/domain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cuda/math/box.h"
#include "host/base/errors.h"
#include "host/hands/filter.h"
#include "host/run/run.h"
#include "host/scene/scene_hands.h"
#include "host/scene/seed.h"
#include "tests/folder.h"
#include "tests/sanitized.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

const std::string ball = R"({
    "schema": "knead.scene/1",
    "objects": [{"centre": [0.5, 0.25, 0.5], "diameter": 0.4}],
    "hands": {},
    "camera": {"eye": [1, 2, 3], "target": [0.5, 0.25, 0.5]}
})";

#define EXPECT_SAYS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << text

class Domain : public InFolder {
  protected:
    Scene scene(const std::vector<std::string>& settings) const
    {
        const fs::path path = folder / "scene.json";
        std::ofstream(path) << ball;
        return read_scene(path.string(), settings);
    }
    std::string complaint(const std::vector<std::string>& settings) const
    {
        try {
            Scene read = scene(settings);
            build(read, std::size_t(1) << 33);
        } catch (const InputError& e) {
            return e.what();
        }
        return "";
    }
};

// But for those with objects of splats, of which tests/assets/splat_object_test.cpp tells.
std::vector<std::string> shipped()
{
    std::vector<std::string> paths;
    for (const auto& entry : fs::directory_iterator("scenes")) {
        if (entry.path().extension() != ".json") continue;
        const std::vector<Object> objects = read_scene(entry.path().string()).objects;
        if (std::none_of(objects.begin(), objects.end(),
                         [](const Object& o) { return o.shape == ShapeKind::splats; }))
            paths.push_back(entry.path().string());
    }
    std::sort(paths.begin(), paths.end());
    return paths;
}

// Of each object's particles, in the frame of the scene's file.
std::vector<Box3<double>> extents(const Scene& scene,
                                  const std::vector<Particle<double>>& particles)
{
    std::vector<Box3<double>> all(scene.objects.size(), empty_box<double>());
    for (const Particle<double>& q : particles) {
        grow(all[std::size_t(q.object)], q.x + scene.origin);
    }
    return all;
}

double apart(Vec3<double> a, Vec3<double> b)
{
    return std::max({std::abs(a.x - b.x), std::abs(a.y - b.y), std::abs(a.z - b.z)});
}

// Whether the low faces stand on nodes, the last that are held.
bool low_on_nodes(const Walls<double>& walls)
{
    return walls.low_face == walls.first - Int3{1, 1, 1};
}

// Walls where the file has them, the low ones on nodes, two nodes of the lattice beyond each, and
// room between.
void expect_walls(const Scene& scene, const WallOptions& wanted)
{
    const Setup& s = scene.setup;
    EXPECT_LT(apart(s.walls.min + scene.origin, wanted.min), 1e-12);
    EXPECT_LT(apart(s.walls.max + scene.origin, wanted.max), 1e-12);
    const Walls<double> walls = walls_on<double>(s.lattice, s.walls);
    EXPECT_TRUE(low_on_nodes(walls));
    const auto axis = [&](double min, double max, int first, int free, int size) {
        EXPECT_GE(first, 3);
        EXPECT_GT(free, 0);
        EXPECT_LE(first + free, size - 3);
        EXPECT_EQ(size % block_edge, 0);
        // The face lies between the last node that is held and the first that is free.
        EXPECT_GE(min, s.lattice.dx * (first - 1 - 1e-3));
        EXPECT_LT(min, s.lattice.dx * first);
        EXPECT_GT(max, s.lattice.dx * (first + free - 1));
        EXPECT_LE(max, s.lattice.dx * (first + free + 1e-3));
    };
    const Int3 size = s.lattice.size;
    axis(s.walls.min.x, s.walls.max.x, walls.first.x, walls.free.x, size.x);
    axis(s.walls.min.y, s.walls.max.y, walls.first.y, walls.free.y, size.y);
    axis(s.walls.min.z, s.walls.max.z, walls.first.z, walls.free.z, size.z);
    // The surface's lattice reaches as far.
    const Lattice<float>& fine = scene.surface.lattice;
    EXPECT_GE(double(fine.dx) * fine.size.x, s.lattice.dx * size.x * (1 - 1e-6));
    EXPECT_GE(double(fine.dx) * fine.size.y, s.lattice.dx * size.y * (1 - 1e-6));
    EXPECT_GE(double(fine.dx) * fine.size.z, s.lattice.dx * size.z * (1 - 1e-6));
}

// scenes/presets.json shows 24 things of a decimetre side by side: on fewer cells they are lost.
bool has_small_things(const std::string& path) { return path == "scenes/presets.json"; }

// The longest edge of its domain [m].
double edge_of(const Scene& scene)
{
    const Int3 cells = scene.setup.lattice.size;
    return scene.setup.lattice.dx * max(cells.x, max(cells.y, cells.z));
}

TEST(ShippedScenes, OnTheirOwnLatticeTheSimulationsFrameIsTheFiles)
{
    for (const std::string& path : shipped()) {
        const Scene scene = read_scene(path);
        // Its floor stands between nodes of the file's frame.
        const double at_most = path == "scenes/presets.json" ? scene.setup.lattice.dx : 0;
        EXPECT_LE(apart(scene.origin, {}), at_most) << path;
        const int cells = has_small_things(path) ? 112 : path == "scenes/demo.json" ? 48 : 64;
        EXPECT_EQ(scene.setup.lattice.size.x, cells) << path;
    }
}

TEST(ShippedScenes, FloorAndObjectsStandWhereTheyWereOn16To192Cells)
{
    ASSERT_GE(shipped().size(), 10u);
    for (const std::string& path : shipped()) {
        const Scene own = read_scene(path);
        for (const int cells : {16, 24, 32, 48, 64, 96, 128, 192}) {
            if (cells < 64 && has_small_things(path)) continue;
            if (sanitized && cells > 32) continue;
            SCOPED_TRACE(path + " on " + std::to_string(cells));
            std::vector<std::string> settings{"domain.cells=" + std::to_string(cells)};
            // Of the fine ones the places are what matters, not the number of particles.
            for (std::size_t i = 0; cells > 32 && i < own.objects.size(); ++i)
                settings.push_back("objects." + std::to_string(i) + ".per_cell=2");
            Scene scene = read_scene(path, settings);
            EXPECT_NEAR(scene.setup.lattice.dx, edge_of(own) / cells, 1e-15);
            WallOptions walls = own.setup.walls;
            walls.min = walls.min + own.origin, walls.max = walls.max + own.origin;
            expect_walls(scene, walls);
            build(scene, std::size_t(1) << 34);
            const std::vector<Box3<double>> found = extents(scene, scene.setup.particles);
            const double dx = scene.setup.lattice.dx;
            for (std::size_t i = 0; i < own.objects.size(); ++i) {
                const Object& o = own.objects[i];
                const Vec3<double> centre = o.centre + own.origin;
                EXPECT_LT(apart(found[i].low, centre - 0.5 * o.size), dx) << o.name;
                EXPECT_LT(apart(found[i].high, centre + 0.5 * o.size), dx) << o.name;
                EXPECT_GE(found[i].low.y, walls.min.y - 1e-12) << o.name;
            }
            const Vec3<double> by = scene.origin - own.origin;
            EXPECT_LT(apart(scene.hands.at + by, own.hands.at), 1e-12);
            EXPECT_LT(apart(scene.eye + by, own.eye), 1e-12);
            EXPECT_LT(apart(scene.target + by, own.target), 1e-12);
        }
    }
}

TEST(ShippedScenes, HaveTheirLowFacesOnNodesAndNoMoreLatticeForIt)
{
    int scenes = 0;
    for (const auto& entry : fs::directory_iterator("scenes")) {
        const std::string path = entry.path().string();
        if (entry.path().extension() != ".json") continue;
        ++scenes;
        for (const int cells : {16, 24, 32, 48, 64, 96}) {
            SCOPED_TRACE(path + " on " + std::to_string(cells));
            const Scene scene = read_scene(path, {"domain.cells=" + std::to_string(cells)});
            const auto& s = scene.setup;
            EXPECT_TRUE(low_on_nodes(walls_on<double>(s.lattice, s.walls)));
            // Not more nodes than with the first one where the file's frame begins, or whole
            // blocks before it.
            const HeldNodes there = held_nodes(s.walls.min.x + scene.origin.x,
                                               s.walls.max.x + scene.origin.x, s.lattice.dx);
            const int before = there.below < 2 ? block_edge : 0;
            const int nodes = before + there.above + 3, blocks = (nodes + 3) / block_edge;
            EXPECT_LE(s.lattice.size.x, std::max(cells + before, blocks * block_edge));
        }
    }
    EXPECT_GE(scenes, 12);
}

// The mean place of clay and the root mean square of its way from there, along each axis [m].
struct Spread {
    Vec3<double> mean{}, width{};
};
Spread spread_of(const std::vector<Particle<double>>& clay)
{
    Spread s;
    Vec3<double> squares{};
    for (const Particle<double>& q : clay) s.mean = s.mean + (1.0 / double(clay.size())) * q.x;
    for (const Particle<double>& q : clay) {
        const Vec3<double> d = q.x - s.mean;
        squares =
            squares + (1.0 / double(clay.size())) * Vec3<double>{d.x * d.x, d.y * d.y, d.z * d.z};
    }
    s.width = {std::sqrt(squares.x), std::sqrt(squares.y), std::sqrt(squares.z)};
    return s;
}

// On a floor between nodes the liquid ran off into a corner, twice as wide.
TEST(ShippedScenes, TheLiquidSpreadsAsADiscWhateverTheCells)
{
    const auto widths = [](int cells) {
        Scene scene = read_scene("scenes/materials.json", {"domain.cells=" + std::to_string(cells),
                                                           sanitized ? "frames=6" : "frames=60"});
        const Object liquid = scene.objects.back();
        EXPECT_EQ(liquid.stated.name, "viscous-liquid");
        scene.objects = {liquid};
        build(scene, std::size_t(1) << 33);
        const auto solver = cpu_solver(scene.setup);
        BatchRunOptions options;
        options.frames = scene.frames;
        const RunRecord record = run_frames(scene, *solver, nullptr, options, {});
        EXPECT_EQ(record.end, End::complete) << record.failure;
        const Spread s = spread_of(*record.last_good);
        const Vec3<double> axis = liquid.centre + scene.origin;
        EXPECT_NEAR(s.mean.x, axis.x, 0.005) << cells;
        EXPECT_NEAR(s.mean.z, axis.z, 0.005) << cells;
        EXPECT_NEAR(s.width.x / s.width.z, 1, 0.05) << cells;
        EXPECT_TRUE(sanitized || s.width.x > 0.05) << cells;
        return s.width.x;
    };
    EXPECT_NEAR(widths(32) / widths(48), 1, 0.1);
}

TEST(ShippedScenes, RunAFrameOnCoarseLatticesAndOnTheirOwn)
{
    for (const std::string& path : shipped())
        for (const int cells : {16, 24, 32, 64}) {
            if (cells < 64 && has_small_things(path)) continue;
            if (sanitized && cells > 24 && !has_small_things(path)) continue;
            SCOPED_TRACE(path + " on " + std::to_string(cells));
            std::vector<std::string> settings{"domain.cells=" + std::to_string(cells)};
            if (cells > 32) settings.insert(settings.end(), {"clock=paper", "paper.substeps=2"});
            Scene scene = read_scene(path, settings);
            const WallOptions walls = scene.setup.walls;
            build(scene, std::size_t(1) << 33);
            const std::vector<Box3<double>> before = extents(scene, scene.setup.particles);
            const auto solver = cpu_solver(scene.setup);
            BatchRunOptions options;
            options.frames = 1;
            std::unique_ptr<HandSource> hands;
            if (scene.has_hands) hands = std::make_unique<HandSource>(hands_of(scene), scene.hands);
            const RunRecord record = run_frames(scene, *solver, hands.get(), options, {});
            ASSERT_EQ(record.end, End::complete) << record.failure;
            const FrameStats& stats = record.rows.back().stats;
            EXPECT_EQ(stats[Count::clipped] + stats[Count::confined] + stats[Count::repaired], 0);
            // A record's places are those of the file.
            Scene file = scene;
            file.origin = {};
            const std::vector<Box3<double>> after = extents(file, *record.last_good);
            for (std::size_t i = 0; i < before.size(); ++i) {
                EXPECT_LT(apart(after[i].low, before[i].low), scene.setup.lattice.dx);
                EXPECT_LT(apart(after[i].high, before[i].high), scene.setup.lattice.dx);
                EXPECT_GE(after[i].low.y, walls.min.y + scene.origin.y - 1e-6);
            }
        }
}

TEST_F(Domain, WallsStandInMetresAndTheirDefaultDoesNotFollowTheCells)
{
    for (const int cells : {8, 16, 64, 100}) {
        const Scene s = scene({"domain.cells=" + std::to_string(cells)});
        EXPECT_LT(apart(s.setup.walls.min + s.origin, {3.0 / 64, 3.0 / 64, 3.0 / 64}), 1e-12);
        EXPECT_LT(apart(s.setup.walls.max + s.origin, {60.0 / 64, 60.0 / 64, 60.0 / 64}), 1e-12);
    }
    const Scene wide = scene({"domain={\"edge\": 2, \"cells\": [64, 32, 128]}"});
    EXPECT_DOUBLE_EQ(wide.setup.walls.min.y + wide.origin.y, 2 * 3.0 / 64);
    EXPECT_DOUBLE_EQ(wide.setup.walls.max.y + wide.origin.y, 0.5 - 2 * 4.0 / 64);
}

TEST_F(Domain, LowFacesStandOnNodesAndMissingNodesAreAddedByWholeBlocks)
{
    const std::string at_ends = "walls={\"min\": [0, 0.1, 0], \"max\": [0.9, 1, 0.5]}";
    const Scene s = scene({"domain.cells=32", at_ends});
    expect_walls(s, {{0, 0.1, 0}, {0.9, 1, 0.5}, ContactMode::sticky, 0.4});
    EXPECT_EQ(s.setup.lattice.size.x, 36);
    EXPECT_EQ(s.setup.lattice.size.y, 36);
    EXPECT_EQ(s.setup.lattice.size.z, 36);
    EXPECT_DOUBLE_EQ(s.origin.x, -4.0 / 32);
    EXPECT_NEAR(s.origin.y, 0.1 - 3.0 / 32, 1e-15);  // 3.2 cells
    EXPECT_DOUBLE_EQ(s.origin.z, -4.0 / 32);
}

TEST_F(Domain, WallsThatCannotBeAreRefused)
{
    EXPECT_SAYS(complaint({"walls.min=0.1"}), "/walls/min: expected three numbers");
    EXPECT_SAYS(complaint({"walls.min=[-0.1,0,0]"}), "/walls/min/0");
    EXPECT_SAYS(complaint({"walls.max=[0.9,1.1,0.9]"}), "/walls/max: expected y at least 2 cells");
    EXPECT_SAYS(complaint({"walls.max=[0.9,0.9,0.06]"}), "/walls/max: expected z at least 2 cells");
    EXPECT_SAYS(complaint({"walls.max=[0.9,0.9,0.06]"}), "found 0.06 m");
}

TEST_F(Domain, ASceneThatGivesItsWallsInNodesIsToldWhatToWrite)
{
    const std::string said = complaint({"walls.margin=3"});
    EXPECT_SAYS(said, "/walls/margin: expected walls in metres");
    EXPECT_SAYS(said, "\"min\": [0.046875, 0.046875, 0.046875]");
    EXPECT_SAYS(said, "\"max\": [0.9375, 0.9375, 0.9375]");
    EXPECT_SAYS(complaint({"walls.margin=many"}), "/walls/margin: expected walls in metres");
}

TEST_F(Domain, WallsTakeAContactMode)
{
    EXPECT_EQ(scene({"walls.contact_mode=slip"}).setup.walls.mode, ContactMode::slip);
    EXPECT_SAYS(complaint({"walls.touch=slip"}),
                "/walls/touch: the key \"touch\" is called \"contact_mode\" now");
}

TEST_F(Domain, ComplaintsSpeakOfThePlacesInTheFile)
{
    for (const char* cells : {"domain.cells=16", "domain.cells=64"})
        EXPECT_SAYS(complaint({cells, "objects.0.centre=[0.5,0.2,0.5]"}),
                    "y from 0.046875 to 0.9375 m, found y from 0 to 0.4 m");
}

void expect_near(const Scene& a, const Scene& b)
{
    constexpr double rounding = 1e-15;
    EXPECT_TRUE(a.setup.lattice.size == b.setup.lattice.size);
    EXPECT_EQ(a.setup.lattice.dx, b.setup.lattice.dx);
    EXPECT_TRUE(a.surface.lattice.size == b.surface.lattice.size);
    EXPECT_EQ(a.surface.lattice.dx, b.surface.lattice.dx);
    EXPECT_LT(apart(a.origin, b.origin), rounding);
    EXPECT_LT(apart(a.setup.walls.min, b.setup.walls.min), rounding);
    EXPECT_LT(apart(a.setup.walls.max, b.setup.walls.max), rounding);
    EXPECT_LT(apart(a.hands.at, b.hands.at), rounding);
    EXPECT_LT(apart(a.eye, b.eye), rounding);
    EXPECT_LT(apart(a.target, b.target), rounding);
    ASSERT_EQ(a.captions.size(), b.captions.size());
    for (std::size_t i = 0; i < a.captions.size(); ++i)
        EXPECT_LT(apart(a.captions[i].at, b.captions[i].at), rounding);
    ASSERT_EQ(a.objects.size(), b.objects.size());
    for (std::size_t i = 0; i < a.objects.size(); ++i)
        EXPECT_LT(apart(a.objects[i].centre, b.objects[i].centre), rounding);
}

TEST_F(Domain, AMoveOutAndInGivesTheSameScene)
{
    for (const char* cells : {"64", "48", "[64,32,48]", "40", "128"})
        for (const char* low : {"[0,0,0]", "[0.01,0.02,0.03]", "[0.0625,0.0625,0.0625]"})
            for (const char* nodes : {"0", "96"}) {
                const Scene s = scene({std::string("domain.cells=") + cells,
                                       std::string("walls.min=") + low, "walls.max=[0.9,0.45,0.6]",
                                       "pictures.captions=[{\"text\":\"a\",\"at\":[1,2,3]}]",
                                       std::string("surface.nodes=") + nodes});
                Scene moved = s;
                move_out(moved);
                EXPECT_EQ(length(moved.origin), 0);
                EXPECT_TRUE(moved.setup.lattice.size == s.stated_cells);
                EXPECT_LT(apart(moved.objects[0].centre, {0.5, 0.25, 0.5}), 1e-15);
                EXPECT_LT(apart(moved.eye, {1, 2, 3}), 1e-15);
                EXPECT_LT(apart(moved.setup.walls.max, {0.9, 0.45, 0.6}), 1e-15);
                EXPECT_EQ(moved.surface.lattice.size.x, *nodes == '0' ? 2 * s.stated_cells.x : 96);
                Scene again = moved;
                move_in(again);
                expect_near(again, s);
                for (int i = 0; i < 100; ++i) move_out(again), move_in(again);
                expect_near(again, s);
            }
}

// Other walls between nodes: as if the scene had been read with them.
TEST_F(Domain, AMovedOutSceneTakesOtherWalls)
{
    Scene s = scene({"walls.min=[0.01,0.02,0.03]"});
    move_out(s);
    const auto read = [&](ObjectReader& r) {
        s.setup.walls = read_walls(r, s.setup.walls, s.setup.lattice);
    };
    ObjectReader::read(parse_json(R"({"min": [0.3, 0.0, 0.05], "friction": 0.1})", "line 3"),
                       "line 3", "/set_walls", read);
    move_in(s);
    const Scene wanted = scene({"walls.min=[0.3,0.0,0.05]", "walls.friction=0.1"});
    expect_near(s, wanted);
    EXPECT_EQ(s.setup.walls.friction, 0.1);
    EXPECT_GT(length(s.origin), 0);
}

// The clay's spin is about the origin of the file's frame, too.
TEST_F(Domain, ARecordSpeaksOfThePlacesInTheFile)
{
    Audit first[2];
    for (int shifted = 0; shifted < 2; ++shifted) {
        Scene s = scene({"domain.cells=48", "gravity=[0,0,0]", "objects.0.velocity=[1,2,3]",
                         shifted ? "walls.min=[0.01,0.01,0.01]"
                                 : "walls.min=[0.0625,0.041666666666666664,0.0625]"});
        EXPECT_EQ(length(s.origin) > 0, shifted == 1);
        build(s, std::size_t(1) << 33);
        const auto solver = cpu_solver(s.setup);
        BatchRunOptions options;
        options.frames = 1, options.last_mesh = true;
        const RunRecord record = run_frames(s, *solver, nullptr, options, {});
        first[shifted] = record.first;
        const Vec3<double> middle =
            s.objects[0].centre + s.origin + (1.0 / 90) * Vec3<double>{1, 2, 3};
        Scene file = s;
        file.origin = {};
        const Box3<double> e = extents(file, *record.last_good)[0];
        EXPECT_LT(apart(0.5 * (e.low + e.high), middle), s.setup.lattice.dx / 2);
        Vec3<double> sum{};
        for (const Vec3<float>& x : record.meshes->at(0).vertices) sum = sum + cast<double>(x);
        EXPECT_LT(apart((1.0 / double(record.meshes->at(0).vertices.size())) * sum, middle), 0.005);
        EXPECT_LT(length(record.rows.back().state.spin - record.first.spin),
                  1e-3 * length(record.first.spin));
    }
    EXPECT_LT(length(first[1].spin - first[0].spin), 1e-2 * length(first[0].spin));
}

}  // namespace
}  // namespace knead
