#include "host/paging/scene_splats.h"

#include <algorithm>
#include <atomic>
#include <stdexcept>
#include <string>

#include "host/hands/motion.h"
#include "host/scene/foresight.h"
#include "host/scene/soften.h"
#include "host/solver/material_spec.h"

namespace knead {

SceneSplats::SceneSplats(const Scene& given, const std::vector<SplatObject>& objects)
    : scene(given), carried(given.upkeep, joined(objects))
{
    for (const SplatObject& of : objects)
        if (of.local)
            local_clay =
                std::make_unique<LocalClay>(scene, of.object, joined(objects, true), carried);
    refresh();
    refresh();  // allocates both buffers before the first activation
}

void SceneSplats::refresh()
{
    if (!local()) return;
    // Reuse a buffer that has no readers left.
    std::swap(front, back);
    if (!front || front.use_count() > 1) front = std::make_shared<SplatCloud>();
    std::atomic_thread_fence(std::memory_order_acquire);  // after the last reader's release
    local_clay->write_all(*front);
}

std::shared_ptr<const SplatCloud> SceneSplats::picture() const
{
    if (local()) return front;
    const std::shared_ptr<const CarriedSplats> all = carried.shared();
    return {all, &all->cloud};
}

void SceneSplats::set_state(const CarriedSplats& state, const LocalState& of_local)
{
    carried.set_state(state);
    if (local()) local_clay->set_state(of_local);
    refresh();
}

void SceneSplats::add_object(int number, const SplatObject& object, EditableSimulator& solver)
{
    if (local()) throw std::invalid_argument("a scene with local clay takes no other splats");
    std::vector<Vec3<double>> places;
    for (const Vec3<float>& x : object.cloud.centre) places.push_back(cast<double>(x));
    std::vector<SplatObject> both(2);
    both[0].cloud = carried.cloud(), both[1] = object;
    CarriedSplats all = knead::carried(joined(both));
    // Splats that were split have the extent of their parent.
    std::copy(carried.state().extent.begin(), carried.state().extent.end(), all.extent.begin());
    solver.attach(number, places);
    carried.raise_capacity(object.cloud.count());
    carried.set_state(std::move(all));
}

void SceneSplats::replace(const std::vector<Gaussian<double>>& gaussians, CarriedSplats all,
                          EditableSimulator& solver)
{
    if (local()) throw std::invalid_argument("a scene with local clay takes no other splats");
    if (all.count() != gaussians.size())
        throw std::invalid_argument("expected one Gaussian for each splat");
    const std::size_t before = carried.cloud().count();
    solver.set_gaussians(gaussians);
    if (all.count() > before) carried.raise_capacity(all.count() - before);
    carried.set_state(std::move(all));
}

void SceneSplats::remove_objects(std::span<const int> numbers, EditableSimulator& solver)
{
    SomeGaussians gone;
    if (!local() && carried.cloud().count() > 0)
        gone = solver.gaussians_of(*solver.snapshot(), numbers);
    solver.remove_each(numbers);
    if (gone.indices.empty()) return;
    std::vector<std::uint32_t> kept;
    std::size_t next = 0;
    for (std::size_t i = 0; i < carried.cloud().count(); ++i) {
        if (next < gone.indices.size() && std::size_t(gone.indices[next]) == i)
            ++next;
        else
            kept.push_back(std::uint32_t(i));
    }
    CarriedSplats stay{picked(carried.cloud(), kept), {}};
    for (const std::uint32_t i : kept) stay.extent.push_back(carried.state().extent[i]);
    carried.set_state(std::move(stay));
}

void SceneSplats::set_rig(const Rig& rig)
{
    if (local()) local_clay->set_rig(rig);
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
    solver.set_material(object, whole);
    if (local()) local_clay->set_material(object, whole, solver);
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
    add(carried.after(frame, solver), report);
    if (local()) add(local_clay->after(frame, motion, solver), report);
    return report;
}

void SceneSplats::adopt(UpkeepPlan plan, PagingReport& report, EditableSimulator& solver)
{
    add(carried.adopt(std::move(plan), solver), report);
}

void SceneSplats::follow_hands(const Motion& motion, PagingReport& report,
                               EditableSimulator& solver)
{
    if (local()) add(local_clay->follow(motion, solver), report);
}

bool SceneSplats::rehearse(EditableSimulator& solver,
                           const std::function<void(const Motion& away)>& frames)
{
    if (!local()) return false;
    Motion motion = local_clay->motion_at_centre();
    if (motion.to.empty()) return false;
    local_clay->follow(motion, solver);
    refresh();
    const Motion away = far_away(motion);
    frames(away);
    local_clay->begin_freezing(0, away, solver);
    local_clay->finish_freezing(solver);
    return true;
}

void SceneSplats::begin_freezing(int frame, const Motion& motion, EditableSimulator& solver)
{
    if (local()) local_clay->begin_freezing(frame, motion, solver);
}

}  // namespace knead
