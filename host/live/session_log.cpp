#include "host/live/session_log.h"

#include <fmt/format.h>

#include <stdexcept>

#include "host/document/command_table.h"
#include "host/live/simulation_run.h"

namespace knead {

std::vector<Particle<double>> replayed(
    const SessionLog& log, const std::function<std::unique_ptr<Simulator>(const Setup&)>& make)
{
    LiveOptions options;
    options.make_solver = make;
    options.recorded = false;
    options.budget = 1e30;  // cuts are those of the log
    LoggedFrame now;
    std::size_t taken = 0;
    options.take_background = [&](bool) {
        if (taken == now.taken.size())
            throw std::runtime_error("a background task that the log does not have");
        return bool(now.taken[taken++]);
    };
    IdSource ids;
    SimulationRun run(
        log.scene, options, ids, 0, [&] { return now.sampled; },
        [&](const FrameProgress& done) { return done.substeps == now.cut_after; });
    run.rehearse();
    std::optional<PreparedObject> ready;
    for (const SessionEvent& event : log.events) {
        if (const HandFrame* hands = std::get_if<HandFrame>(&event)) {
            run.push(*hands);
        } else if (const auto* begun = std::get_if<LoggedPreparation>(&event)) {
            ready = run.prepare(begun->command).get();
        } else if (const Command* command = std::get_if<Command>(&event)) {
            if (const Play* play = std::get_if<Play>(command))
                run.play(play->recorded);
            else if (const auto refusal = run.apply(*command, ready ? &*ready : nullptr).refusal)
                throw std::runtime_error(fmt::format("after frame {}: {} is refused: {}",
                                                     run.number(), row_of(*command).name,
                                                     refusal->text()));
        } else {
            now = std::get<LoggedFrame>(event), taken = 0;
            const std::string failure = run.frame(false);
            if (!failure.empty()) throw std::runtime_error(failure);
            if (taken != now.taken.size())
                throw std::runtime_error(
                    fmt::format("frame {}: fewer background tasks than in the log", run.number()));
        }
    }
    return run.of().particles();
}

}  // namespace knead
