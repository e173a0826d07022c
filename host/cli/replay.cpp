#include "host/cli/replay.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "host/base/errors.h"
#include "host/run/report.h"

namespace knead {
namespace {

bool is_there(const std::string& file)
{
    std::error_code problem;
    return std::filesystem::is_regular_file(file, problem);
}

}  // namespace

std::unique_ptr<ActionReplay> replay_of(const Scene& scene, const Recording& recording,
                                        const Note& note)
{
    const std::string file = actions_file(scene.hands.recording);
    if (!is_there(file)) return nullptr;
    HandActions actions = read_actions(file);
    if (actions.recording != file_hash(scene.hands.recording))
        throw InputError(file + ": expected the actions recorded with " + scene.hands.recording +
                         ", found those of another recording; without the file, only the hands "
                         "are played");
    note(fmt::format("{}: played, too; actions: {}", file, actions.all.size()));
    if (!actions.settings.empty())
        note(fmt::format("{}: recorded of {} with --set {}", file, actions.scene,
                         fmt::join(actions.settings, " --set ")));
    return std::make_unique<ActionReplay>(recording, scene.hands, scene.frame_rate,
                                          std::move(actions.all));
}

void play(ActionReplay& replay, SceneSplats& splats, RunObserver& watch)
{
    watch.motion = [&replay](double from, double to) { return replay.motion(from, to); };
    watch.edits = [&replay, &splats](int number, SessionLoop& loop) {
        replay.before_frame(number, loop, splats, [](const std::string& why) {
            std::fprintf(stderr, "knead: %s\n", why.c_str());
        });
    };
}

bool begin_with_hands(Scene& scene, const std::string& recording)
{
    const std::string file = actions_file(recording);
    if (!is_there(file)) return false;
    for (const HandAction& action : read_actions(file).all) {
        if (action.time > 0) return false;
        if (action.act != ActionType::hands) continue;
        scene.has_hands = true;
        scene.hands.zoom = action.hands.zoom, scene.hands.at = action.hands.at;
        for (const Side side : {left, right}) {
            scene.hands.held[side] = action.hands.held[side];
            scene.hands.present[side] = action.hands.present[side];
        }
        return true;
    }
    return false;
}

}  // namespace knead
