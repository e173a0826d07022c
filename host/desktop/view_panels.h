// Connects the panels of `knead view` with the live session: materials as sliders, the list of
// scenes, the stages of a frame.
#pragma once
#include <string>
#include <vector>

#include "host/live/live_session.h"
#include "host/scene/presets.h"
#include "render/view/panel_model.h"

namespace knead {

// Sliders for the quantities that this material uses, with ranges suited to live simulation.
std::vector<Slider> sliders_of(const MaterialSpec& spec);
// Returns `spec` with the sliders' values. Throws std::invalid_argument for a slider that the
// material does not use.
MaterialSpec with_sliders(MaterialSpec spec, const std::vector<Slider>& sliders);

class ViewPanels {
  public:
    // Lists the scene at `path` and those of its folder. `settings` and `cells` apply to every
    // scene that is loaded, as far as they are valid for it.
    explicit ViewPanels(const std::string& path, std::vector<std::string> settings = {},
                        int cells = 0);

    PanelModel model;
    std::vector<std::string> paths;  // of model.scenes

    // Updates the model from the state; for a new scene its objects, too.
    void follow(const LiveState& state);
    // Lists sessions to recover; one that the session opens leaves the list.
    void list_recoverable(std::vector<Recoverable> all);
    // Adds the times of a picture and, once per version of the state, of its simulation frame [s].
    void add_times(const LiveState& state, double raster, double gl, double show);
    // Sends what the panels request to the session: tools, hands, gravity, materials, undo, redo,
    // steps, save. follow() shows a refusal, and resets the control.
    void apply(const PanelRequests& requests, LiveSession& session);
    void load(int scene, LiveSession& session);  // throws std::out_of_range
    void recover(const std::string& file, LiveSession& session);
    void discard_log(const std::string& file);         // deletes it; a note says why not
    void send_tool(LiveSession& session);              // the chosen one, to the right hand
    void show_scene(const LiveState& state);           // selects the current scene in the list
    HandsOptions hands(const LiveState& state) const;  // with the chosen tool

  private:
    int history_ = -1;
    const LiveScene* scene_ = nullptr;
    long timed_ = 0;
    int refused_ = 0;
    long sent_ = 0;      // serial number of the last command
    DocumentPtr shown_;  // by the model: that of the state, and the commands not answered yet
    std::shared_ptr<const std::vector<StepInfo>> steps_;  // in the model
    std::vector<std::string> settings_;
    int cells_ = 0;

    void send(Command command, LiveSession& session, unsigned drag = 0);
    SetMaterial chosen_material(bool preset);
    void show(DocumentPtr document);
    void show_tool(const Scene& scene);
    void show_session(const LiveState& state);
    std::string held() const;  // the chosen tool; "": the bare hand
};

}  // namespace knead
