// The past of a running scene: begins, captures and restores the steps of its history, with no
// frame in flight. Commands of the document, and undo, redo and go_to, are applied here.
// docs/method/history.md.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/document/command_table.h"
#include "host/session/capture_thread.h"
#include "host/session/history.h"
#include "host/session/piece_watch.h"
#include "host/session/scene_editor.h"
#include "host/session/session_event.h"
#include "host/session/step_rule.h"

namespace knead {

// What decides when steps begin and are captured: the rule; or a replay, by events, whose steps are
// captured again, or are stored already.
enum class StepSource { rule, events, stored };

class SceneHistory {
  public:
    // What the history acts on. All must outlive it.
    struct Parts {
        const Scene& scene;  // built
        SceneSplats& splats;
        SessionLoop& loop;
        EditableSimulator* simulator;  // null: not editable
        SceneEditor& editor;
        History& past;  // of the session
        // Receives the events of steps and commands; may be empty.
        std::function<void(const SessionEvent&)> events{};
        // Called when particles of a step will be known; may be empty.
        std::function<void(const HistoryStep&, const FutureCapture&)> captured{};
        Codec codec = Codec::automatic;
    };
    // Why the scene keeps no steps; "": it does.
    static std::string why_none(const Scene& scene, const Simulator& simulator);

    // Begins the past with the current state, or adds a step for it where the past has steps.
    // `label`: of that step; "": none is added.
    SceneHistory(Parts parts, const std::string& label, StepSource source = StepSource::rule);
    SceneHistory(const SceneHistory&) = delete;

    // Whether apply() takes it: a command of the document, Carry, Undo, Redo or GoTo.
    static bool takes(const Command& command);
    // Applies such a command. As SceneEditor::apply(). Precondition: no frame in flight.
    CommandAnswer apply(const Issued& issued, PreparedObject* ready = nullptr);
    // Call after each frame, with no frame in flight, after SceneEditor::after_frame(). May take a
    // snapshot, never waits. Objects that were cut or torn into pieces are split (PieceWatch), in
    // the open step if there is one. Returns whether one was.
    bool after_frame(const FrameResult& frame);
    // Tools inside clay that was restored are without effect until they have left it. Call with
    // the motion of each frame.
    void release_tools(Motion& motion);

    bool keeps() const { return none.empty(); }  // steps
    // The open step, if any, is captured.
    void close()
    {
        if (keeps()) before_change();
    }
    // Of the editor, with what undo, redo and go_to depend on.
    Situation situation(bool live) const;
    const History& history() const { return parts.past; }
    long frames() const { return frame_count; }  // after_frame() so far

    // For a replay. Throw std::invalid_argument for a step that does not fit. With stored steps,
    // one that is not stored is passed over.
    void begin_step(const StepBegun& step);
    void capture_step(const StepCaptured& step);
    void restore_step(StepId id);
    // The simulator has the clay of the current step, though it was not restored: its state was
    // replaced, or is that of the beginning.
    void state_loaded() { in_step = true; }
    // The past begins again, with the simulator's present state, with its velocities.
    void begin_again();

  private:
    void begin_past(const std::string& label, bool moves);
    void capture();
    void before_change();
    bool extrudes() const;
    bool merges(const Issued& issued) const;
    void begin(const std::string& label);
    bool split_pieces(const FrameResult& frame);
    std::optional<Refusal> go_to(StepId id);
    void emit(const SessionEvent& event) const;
    DocumentPtr document() const { return parts.editor.document(); }
    std::shared_ptr<const CarriedSplats> splats() const;

    const Parts parts;
    const std::string none;  // why there are no steps
    const StepSource source;
    StepRule rule;
    PieceWatch watch;
    Issued last{};  // the command that began the open step, of a drag
    bool open_by_command = false, unreleased = false;
    // False: the simulator has the clay of the scene's beginning, not that of the current step.
    bool in_step = true;
    std::vector<char> released;  // per tool: it has left the restored clay
    long frame_count = 0;
    mutable std::shared_ptr<const CarriedSplats> last_splats;
    CaptureThread thread;  // its captures use the simulator
};

}  // namespace knead
