#include "host/paging/scene_splats.h"

#include <atomic>
#include <stdexcept>
#include <string>

#include "host/hands/motion.h"
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
    refresh();  // allocates both buffers before the first activation
}

void SceneSplats::refresh()
{
    if (!local()) return;
    // Reuse a buffer that has no readers left.
    std::swap(shown, before);
    if (!shown || shown.use_count() > 1) shown = std::make_shared<SplatCloud>();
    std::atomic_thread_fence(std::memory_order_acquire);  // after the last reader's release
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

void SceneSplats::set_material(int object, const Material<double>& material,
                               EditableSimulator& solver)
{
    const auto& there = solver.config().materials;
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

void add(const UpkeepReport& done, PagingReport& report)
{
    report.splats_split = long(done.split), report.splats_added = long(done.added);
    report.splats_waiting = long(done.waiting);
}
void add(const LocalReport& now, PagingReport& report)
{
    report.cubes = long(now.cubes), report.cubes_activated = long(now.activated);
    report.cubes_frozen = long(now.frozen);
}

}  // namespace

PagingReport SceneSplats::after(int frame, const Motion& motion, EditableSimulator& solver)
{
    PagingReport report;
    add(moving.after(frame, solver), report);
    if (local()) add(around_hands->after(frame, motion, solver), report);
    return report;
}

void SceneSplats::adopt(UpkeepPlan plan, PagingReport& report, EditableSimulator& solver)
{
    add(moving.adopt(std::move(plan), solver), report);
}

void SceneSplats::follow_hands(const Motion& motion, PagingReport& report,
                               EditableSimulator& solver)
{
    if (local()) add(around_hands->follow(motion, solver), report);
}

bool SceneSplats::rehearse(EditableSimulator& solver,
                           const std::function<void(const Motion& away)>& frames)
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

void SceneSplats::begin_leaving(int frame, const Motion& motion, EditableSimulator& solver)
{
    if (local()) around_hands->begin_leaving(frame, motion, solver);
}

}  // namespace knead
