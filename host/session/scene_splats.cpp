#include "host/session/scene_splats.h"

namespace knead {

SceneSplats::SceneSplats(const Scene& scene, const std::vector<SplatObject>& objects)
    : moving(scene.upkeep, joined(objects))
{
    for (const SplatObject& of : objects)
        if (of.local)
            around_hands =
                std::make_unique<LocalClay>(scene, of.object, joined(objects, true), moving);
    refresh();
}

void SceneSplats::refresh()
{
    if (local()) shown = around_hands->shown();
}

void SceneSplats::set_state(const CarriedSplats& state, const LocalState& of_local)
{
    moving.set_state(state);
    if (local()) around_hands->set_state(of_local);
    refresh();
}

bool SceneSplats::after(const Frame& frame, FrameRow& row, Solver& solver)
{
    const UpkeepReport done = moving.after(row.frame, solver);
    row.splats_split = long(done.split), row.splats_added = long(done.added);
    row.splats_waiting = long(done.waiting);
    if (!local()) return false;
    const LocalReport now = around_hands->after(frame.motion, solver);
    row.cubes = long(now.cubes), row.cubes_taken = long(now.taken);
    row.cubes_given_back = long(now.given_back);
    return now.taken + now.given_back > 0;
}

}  // namespace knead
