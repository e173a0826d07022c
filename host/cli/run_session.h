// The past of a run with commands, and its log where a command saves it.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/hands/hands.h"
#include "host/session/scene_history.h"
#include "host/session/session_file.h"

namespace knead {

struct RunOptions;

class RunSession {
  public:
    // A document command before the first frame, and the document after it.
    struct Beginning {
        std::string label;
        DocumentPtr document;
    };
    struct Wants {
        bool steps = false, file = false;  // commands that restore steps, or that save
    };
    // `base`: the scene as read, not built, before any command.
    RunSession(const RunOptions& options, Scene base, Wants wants);
    ~RunSession();

    // Call once, before the first frame. `of`: the simulator of the parts, also if it takes no
    // edits. `recording`: the hands that are played; may be null.
    void begin(SceneHistory::Parts parts, const Simulator& of, const std::vector<Beginning>& before,
               const Recording* recording);
    // Call with the motion of each frame: sets it, and keeps it for the log.
    Motion with_motion(Motion motion);
    void after_frame(const FrameResult& frame);
    std::optional<Refusal> apply(const Command& command);

    History& steps() { return past; }
    HistoryInfo info() const;
    // Why the last save, or else an export, was not written; "".
    const std::string& problem() const { return not_written.empty() ? not_exported : not_written; }

  private:
    void begin_past(const SceneHistory::Parts& parts, const std::vector<Beginning>& before);
    void begin_log(const SceneHistory::Parts& parts, const Recording* recording);
    void record(const SessionEvent& event);
    void hash_state();
    std::string in_out(const std::string& file) const;
    std::optional<Refusal> save(const Save& command);
    std::optional<Refusal> export_now(const Export& command);

    const RunOptions& options;
    const Scene base;
    const Wants wants;
    History past;
    std::unique_ptr<SessionWriter> writer;  // null: no log
    struct FirstStep {
        HistoryStep step;
        Capture made;  // from the step before
        std::shared_ptr<const ClayRows> rows;
    };
    std::vector<FirstStep> first_steps;  // for the log
    std::unique_ptr<SceneHistory> history;
    const EditableSimulator* simulator = nullptr;
    const SceneEditor* editor = nullptr;
    SessionLoop* loop = nullptr;
    SceneSplats* splats = nullptr;
    const Simulator* solver = nullptr;
    Vec3<double> origin{};  // Scene::origin [m]
    Motion given;
    long frames = 0;
    bool on_gpu = false;
    std::string not_written, not_exported;
};

}  // namespace knead
