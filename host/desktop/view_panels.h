// Between the panels of `knead view` and the live session: each material as sliders, the scenes
// that there are, the stages of a frame.
#pragma once
#include <string>
#include <vector>

#include "host/live/live_session.h"
#include "host/scene/presets.h"
#include "render/view/panel_model.h"

namespace knead {

// The material of an object as a person states it: its preset with what the scene says otherwise.
MaterialSpec stated(const Object& object);
// The quantities that this material uses, with ranges in which it can be simulated live.
std::vector<Slider> sliders_of(const MaterialSpec& spec);
// The same with the sliders' values. Throws std::invalid_argument for a slider that it has not.
MaterialSpec with_sliders(MaterialSpec spec, const std::vector<Slider>& sliders);

class ViewPanels {
  public:
    // Of the scene at `path`, and those beside it. `settings` and `cells` go with each that is
    // chosen, as far as it takes them.
    explicit ViewPanels(const std::string& path, std::vector<std::string> settings = {},
                        int cells = 0);

    PanelModel model;
    std::vector<std::string> paths;  // of model.scenes

    // The panels follow the state; objects are those of a scene that is new.
    void follow(const LiveState& state);
    // What a frame of the simulation and its picture took: once for each version of a state.
    void add_times(const LiveState& state, double raster, double gl, double show);
    // What was asked for by the panels, passed on to the session: tools, hands, gravity, materials.
    // What cannot be is said, and its control shows again what holds. True where clay has become
    // another.
    bool apply(const PanelRequests& asks, LiveSession& session, const LiveState& state);
    void load(int scene, LiveSession& session);        // throws std::out_of_range
    void show_scene(const LiveState& state);           // that which is there
    HandsOptions hands(const LiveState& state) const;  // with the tool that is chosen

  private:
    int history_ = -1;
    const LiveScene* scene_ = nullptr;
    long timed_ = 0;
    int refused_ = 0;
    std::vector<MaterialSpec> specs_;  // of the objects
    std::vector<int> presets_;         // likewise, as they were before the last choice
    std::vector<std::string> settings_;
    int cells_ = 0;
    double gravity_ = 0;  // that holds [m/s^2]

    bool set_gravity(double gravity, LiveSession& session);
    bool set_material(bool preset, LiveSession& session);
    void show_held(const LiveState& state);
    void show_tool(const Scene& scene);
};

}  // namespace knead
