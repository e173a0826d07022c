// Connects the panel with a live session, in the window and in the headset alike: keeps the state
// of the user interface, sends commands, asks before work is lost, and shows refusals.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/ui/panel_model.h"

namespace knead {

class PanelController {
  public:
    static constexpr double notice_for = 6;  // that a notice is shown [s]

    // `scene`: path of the scene or session that is opened first.
    PanelController(unsigned place, const std::string& scene,
                    std::vector<std::string> settings = {}, int cells = 0);

    UiState ui;
    // Executes what the front end alone can do: frame_view, frame_all, screenshot, film, pause,
    // advance, quit, carry, choose, lay, recentre, standing. May be called within follow() and
    // apply().
    std::function<void(const ControlEvent&)> execute = [](const ControlEvent&) {};
    // True: controls that discard work ask first. False: they need not, for example because they
    // must be held.
    bool asks;
    // Set by the front end: clay has been shaped since the last load or reset.
    bool loses_clay = false;

    // Lists recent files, and records later ones.
    void remember_files();
    // Takes a published state, `now` [s], ascending.
    void follow(const LiveState& state, LiveSession& session, double now);
    // The panel of the last state.
    const PanelModel& model() const { return model_; }
    void refresh(const LiveState& state) { model_ = panel_model(state, ui); }
    // Applies an event of a control, key or dropped file. With `asks`, asks first if work would be
    // lost.
    void apply(const ControlEvent& event, LiveSession& session);
    // Sends a command, and shows at once what it will change.
    void send(Command command, LiveSession& session, unsigned drag = 0);
    void note(const std::string& text);
    // Cancels the open question. Returns false if there was none.
    bool decline();
    bool asking() const { return pending_.has_value(); }

    // Lists sessions to recover; one that the session opens leaves the list.
    void list_recoverable(std::vector<Recoverable> all);
    // Serial number of the last command sent.
    long sent() const { return sent_; }

  private:
    // Adds splats or a mesh to the scene.
    void take_object(const std::string& file, const LiveState& state, LiveSession& session);
    struct Pending {
        ControlEvent event;
        std::string text;
        std::vector<std::string> answers;  // the last one cancels
        bool saves = false;                // waits until the session is saved
    };
    void follow_scene(const LiveState& state);
    bool loses(Control control, const LiveState& state) const;
    void ask(const ControlEvent& event, const LiveState& state);
    void answer(int button, LiveSession& session);
    void act(const ControlEvent& event, LiveSession& session);
    void choose_object(bool anew, long frame);
    void discard_log(std::size_t row);
    void begin_placing(SceneObject object);

    void remember(const std::string& file);

    PanelModel model_;
    bool remembers_ = false;
    std::optional<Pending> pending_;
    double now_ = 0, noticed_ = -1e30;
    long sent_ = 0;
    int refused_ = 0, history_ = -1;
    const LiveScene* scene_ = nullptr;
    DocumentPtr shown_;           // published document that ui.document was last set from
    std::optional<int> goes_to_;  // target of the next GoTo, sent once all commands are answered
    std::string opens_;           // file of the unanswered Open; "": none
    std::string saved_as_;
    int exports_ = 0;                // that were reported
    std::vector<ObjectId> objects_;  // of the document before
};

}  // namespace knead
