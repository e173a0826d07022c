#include "host/session/scene_splats.h"

#include <atomic>
#include <stdexcept>
#include <string>

#include "host/scene/foresight.h"
#include "host/scene/soften.h"
#include "host/solver/material_spec.h"

namespace knead {

SceneSplats::SceneSplats(const Scene& given, const std::vector<SplatObject>& objects)
    : scene(given), moving(given.upkeep, joined(objects))
{
    for (const SplatObject& of : objects)
        if (of.local)
            around_hands =
                std::make_unique<LocalClay>(scene, of.object, joined(objects, true), moving);
    refresh();
    refresh();  // both have memory before hands come
}

void SceneSplats::refresh()
{
    if (!local()) return;
    // Memory that nobody looks at any more serves again.
    std::swap(shown, before);
    if (!shown || shown.use_count() > 1) shown = std::make_shared<SplatCloud>();
    std::atomic_thread_fence(std::memory_order_acquire);  // who read it has ended
    around_hands->show(*shown);
}

std::shared_ptr<const SplatCloud> SceneSplats::picture() const
{
    if (local()) return shown;
    const std::shared_ptr<const CarriedSplats> all = moving.shared();
    return {all, &all->cloud};
}

void SceneSplats::set_state(const CarriedSplats& state, const LocalState& of_local)
{
    moving.set_state(state);
    if (local()) around_hands->set_state(of_local);
    refresh();
}

void SceneSplats::set_rig(const Rig& rig)
{
    if (local()) around_hands->set_rig(rig);
}

void SceneSplats::set_material(int object, const Material<double>& material, Solver& solver)
{
    const auto& there = solver.rules().materials;
    if (object < 0 || std::size_t(object) >= there.size())
        throw std::invalid_argument("there is no object " + std::to_string(object));
    if (const auto fault = fault_of(stated(material))) throw std::invalid_argument(fault->text());
    Material<double> whole = softer(material, softening(scene, material));
    check_substeps(scene, whole);
    whole.volume = there[std::size_t(object)].volume;
    whole.mass = whole.density * whole.volume;
    whole.category = there[std::size_t(object)].category;
    solver.set_material(object, whole);
    if (local()) around_hands->set_material(object, whole, solver);
}

namespace {

void tell(const UpkeepReport& done, FrameRow& row)
{
    row.splats_split = long(done.split), row.splats_added = long(done.added);
    row.splats_waiting = long(done.waiting);
}

// True if clay came or went.
bool tell(const LocalReport& now, FrameRow& row)
{
    row.cubes = long(now.cubes), row.cubes_taken = long(now.taken);
    row.cubes_given_back = long(now.given_back);
    return now.taken + now.given_back > 0;
}

}  // namespace

bool SceneSplats::after(const Frame& frame, FrameRow& row, Solver& solver)
{
    tell(moving.after(row.frame, solver), row);
    return local() && tell(around_hands->after(row.frame, frame.motion, solver), row);
}

void SceneSplats::adopt(UpkeepPlan plan, FrameRow& row, Solver& solver)
{
    tell(moving.adopt(std::move(plan), solver), row);
}

bool SceneSplats::follow_hands(const Frame& frame, FrameRow& row, Solver& solver)
{
    return local() && tell(around_hands->follow(frame.motion, solver), row);
}

bool SceneSplats::rehearse(Solver& solver, const std::function<void(const Motion& away)>& frames)
{
    if (!local()) return false;
    Motion motion = around_hands->over_ground();
    if (motion.to.empty()) return false;
    around_hands->follow(motion, solver);
    refresh();
    const Motion away = far_away(motion);
    frames(away);
    around_hands->begin_leaving(0, away, solver);
    around_hands->end_leaving(solver);
    return true;
}

void SceneSplats::begin_leaving(const Frame& frame, Solver& solver)
{
    if (local()) around_hands->begin_leaving(frame.number, frame.motion, solver);
}

}  // namespace knead
