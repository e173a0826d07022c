#include "host/session/piece_watch.h"

#include <algorithm>
#include <cmath>

namespace knead {
namespace {

// Ten looks of 8 ms, or as many frames as that time has; at least two.
constexpr double look_time = 0.008, apart_time = 0.08;  // [s]
constexpr int most_looks = 10, fewest_looks = 2;
// After the last touch, clay is looked at for as long at least [s].
constexpr double looks_on = 1;

int frames_of_look(double seconds) { return std::max(1, int(std::lround(look_time / seconds))); }

}  // namespace

PieceWatch::PieceWatch(const Scene& scene)
    : on(scene.own_pieces),
      seconds(frame_duration(scene)),
      calm_speed(2 * scene.setup.lattice.dx),
      every(frames_of_look(seconds)),
      enough(std::clamp(int(apart_time / (every * seconds)), fewest_looks, most_looks))
{
}

void PieceWatch::restored() { armed = touching = false, looks.clear(), left.clear(); }

std::vector<ObjectId> PieceWatch::after_frame(const FrameResult& frame, bool touched,
                                              const SceneEditor& editor,
                                              const EditableSimulator& simulator)
{
    if (!on) return {};
    ++frames;
    if (touched && !touching) left.clear();
    touching = touched, since_touch = touched ? 0 : since_touch + seconds;
    armed = touched || (armed && (since_touch < looks_on || frame.stats.fastest > calm_speed));
    if (!armed) {
        looks.clear();
        return {};
    }
    if (frames % every != 0) return {};
    std::vector<int> group(simulator.config().materials.size(), -1);
    std::vector<ObjectId> seen;
    for (const auto& o : editor.document()->objects) {
        if (o->locked || left.contains(o->id)) continue;
        if (o->source.shape == ShapeKind::splats && o->source.splats.depth > 0) continue;
        for (const int number : editor.simulated(o->id))
            group.at(std::size_t(number)) = int(seen.size());
        seen.push_back(o->id);
    }
    if (seen.empty()) return {};
    const std::vector<int> counts = simulator.piece_counts(group, int(seen.size()));
    std::map<ObjectId, int> next;
    std::vector<ObjectId> found;
    for (std::size_t i = 0; i < seen.size(); ++i) {
        if (counts[i] < 2) continue;
        const auto before = looks.find(seen[i]);
        const int now = 1 + (before == looks.end() ? 0 : before->second);
        if (now >= enough)
            found.push_back(seen[i]);
        else
            next[seen[i]] = now;
    }
    looks = std::move(next);
    return found;
}

}  // namespace knead
