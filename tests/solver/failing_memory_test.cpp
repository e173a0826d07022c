// Edits of the CPU's simulator are all or nothing: wherever memory ends, what was is as it was.
#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <new>
#include <vector>

#include "host/bench/ball.h"
#include "host/solver/editable_simulator.h"
#include "tests/sanitized.h"
#include "tests/solver/same_bits.h"

namespace {

// Allocations of this thread until one fails; negative: none does.
thread_local long allocations_left = -1;

}  // namespace

#if !defined(__SANITIZE_ADDRESS__) && !defined(KNEAD_SANITIZED)  // these have their own
// Not inlined: GCC would miss the pairs of them.
[[gnu::noinline]] void* operator new(std::size_t bytes)
{
    if (allocations_left == 0) throw std::bad_alloc();
    if (allocations_left > 0) --allocations_left;
    if (void* memory = std::malloc(bytes > 0 ? bytes : 1)) return memory;
    throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
#endif

namespace knead {
namespace {

constexpr double frame = 1.0 / 90;

knead::Setup scene()
{
    knead::Setup s = ball(16);
    add_tools(s);
    add_gaussians(s, 50);
    s.threads = 1;
    return s;
}

std::unique_ptr<EditableSimulator> played(const knead::Setup& s)
{
    auto solver = cpu_solver(s);
    for (int f = 0; f < 2; ++f) solver->advance(closing(f * frame, frame), frame);
    return solver;
}

struct Named {
    const char* name;
    std::function<void(EditableSimulator&)> edit;
};

class MemoryEnds : public testing::TestWithParam<Named> {};

std::vector<Named> edits()
{
    const knead::Setup s = scene();
    std::vector<Particle<double>> more(s.particles.begin(), s.particles.begin() + 100);
    for (Particle<double>& p : more) p.x.y += 0.01;
    const Material<double> other = s.materials[0];
    Material<double> stiffer = other;
    stiffer.mu *= 2, stiffer.lambda *= 2;
    GaussianEdits grown;
    grown.splits = {{3, {1e-3, 0, 0}}};
    grown.added = {{5, {0, 1e-3, 0}}};
    const std::vector<Gaussian<double>> fewer(s.gaussians.begin(), s.gaussians.begin() + 7);
    const SavedState saved = played(s)->save();
    std::vector<Tool<double>> blades = s.tools;
    for (Tool<double>& t : blades) t.blade = true;
    return {
        {"Add", [=](EditableSimulator& of) { of.add(other, more); }},
        {"Remove", [](EditableSimulator& of) { of.remove(0); }},
        {"SetMaterial", [=](EditableSimulator& of) { of.set_material(0, stiffer); }},
        {"Move",
         [](EditableSimulator& of) {
             of.move(0, {{1, 0, 0, 0}, {0, 0.01, 0}});
         }},
        {"SetGravity",
         [](EditableSimulator& of) {
             of.set_gravity({0, -1, 0});
         }},
        {"SetWalls",
         [w = s.walls](EditableSimulator& of) {
             WallOptions slip = w;
             slip.mode = ContactMode::slip;
             of.set_walls(slip);
         }},
        {"SetContact",
         [](EditableSimulator& of) {
             of.set_contact({true, 0.5});
         }},
        {"SetTools", [rig = s.rig, blades](EditableSimulator& of) { of.set_tools(rig, blades); }},
        {"Attach",
         [at = s.particles[0].x](EditableSimulator& of) {
             of.attach(0, {at, at});
         }},
        {"SetGaussians", [=](EditableSimulator& of) { of.set_gaussians(fewer); }},
        {"EditGaussians", [=](EditableSimulator& of) { of.edit_gaussians(grown); }},
        {"Load", [=](EditableSimulator& of) { of.load(saved); }},
        {"Replace", [=](EditableSimulator& of) { of.replace(s, s); }}};
}

TEST_P(MemoryEnds, AndTheSceneIsAsItWas)
{
    if (sanitized) GTEST_SKIP() << "sanitizers allocate by their own operator new";
    const knead::Setup s = scene();
    const auto untouched = played(s);
    const auto before = untouched->save();
    untouched->advance(closing(2 * frame, frame), frame);
    const auto edited = played(s);
    long failures = 0;
    for (bool done = false; !done; ++failures) {
        ASSERT_LT(failures, 5000) << "it never succeeds";
        allocations_left = failures;
        try {
            GetParam().edit(*edited);
            done = true;
        } catch (const std::bad_alloc&) {
        }
        allocations_left = -1;
        if (done) break;
        ASSERT_TRUE(same_bits(edited->particles(), before.contents.particles)) << failures;
        ASSERT_TRUE(same_bits(edited->gaussians(), before.contents.gaussians)) << failures;
        ASSERT_EQ(edited->config().materials.size(), s.materials.size()) << failures;
        ASSERT_EQ(edited->config().gravity.y, s.gravity.y) << failures;
        if (failures % 7 != 0) continue;
        const auto snapshot = edited->snapshot();
        edited->advance(closing(2 * frame, frame), frame);
        ASSERT_TRUE(same_bits(edited->particles(), untouched->particles())) << failures;
        edited->restore(*snapshot);
    }
    EXPECT_GT(failures, 1) << "memory never ended within it";
}
INSTANTIATE_TEST_SUITE_P(Solver, MemoryEnds, testing::ValuesIn(edits()),
                         [](const auto& at) { return std::string(at.param.name); });

}  // namespace
}  // namespace knead
