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
    // Adds the times of a picture and, once per version of the state, of its simulation frame [s].
    void add_times(const LiveState& state, double raster, double gl, double show);
    // Passes requests of the panels to the session: tools, hands, gravity, materials. If a request
    // is refused, sets model.notice and resets its control. Returns whether clay was changed.
    bool apply(const PanelRequests& requests, LiveSession& session, const LiveState& state);
    void load(int scene, LiveSession& session);        // throws std::out_of_range
    void show_scene(const LiveState& state);           // selects the current scene in the list
    HandsOptions hands(const LiveState& state) const;  // with the chosen tool

  private:
    int history_ = -1;
    const LiveScene* scene_ = nullptr;
    long timed_ = 0;
    int refused_ = 0;
    std::vector<MaterialSpec> specs_;  // of the objects
    std::vector<int> presets_;         // of the objects, before the last choice
    std::vector<std::string> settings_;
    int cells_ = 0;
    double gravity_ = 0;  // in effect [m/s^2]

    bool set_gravity(double gravity, LiveSession& session);
    bool set_material(bool preset, LiveSession& session);
    void show_held(const LiveState& state);
    void show_tool(const Scene& scene);
};

}  // namespace knead
