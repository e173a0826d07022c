// The GL side of a headset's session: what both eyes see of a live state, drawn into the headset's
// textures.
#pragma once
#include <memory>
#include <string>

#include "host/live/live_session.h"
#include "host/session/backend.h"
#include "host/vr/headset_view.h"
#include "host/vr/panel_text.h"

namespace knead {

// What is drawn for one frame.
struct HeadsetPicture {
    const LiveState& state;
    std::vector<HandLook> hands;
    const HandsOptions& options;  // where hands, and so eyes, stand in the simulation
    const Workplace& workplace;
    float nearest;                            // [m] of the headset's size
    const PanelCanvas* canvas;                // the panel's new picture; null: the one before
    std::optional<Joint<float>> panel;        // where it stands, in the frame of the hands
    float panel_width = 0, panel_height = 0;  // [m]
    double now = 0;                           // when it is seen, in the state's session [s]
    bool at_once = false;  // other splats: else they are brought to the device beside the drawing
    // What OpenGL may take for both eyes [s], else they become smaller; 0: they are whole.
    double budget = 0;
};

struct HeadsetLoopOptions;  // host/vr/headset_loop.h

struct EyesOptions {
    // Of a frame that OpenGL may take in real time: the device has clay to move.
    static constexpr double gl_share = 0.6;
    static EyesOptions of(const HeadsetLoopOptions& options);
    // From frame to frame [s], as long as the display has not said.
    static double usual_period(const HeadsetLoopOptions& options);

    Device device;    // of the rasteriser of splats
    int samples = 1;  // of a pixel
    // What OpenGL may take for both eyes [s]: where empty ones take more, they begin with one
    // sample a pixel, and as small as that asks for. 0: not asked.
    double budget = 0;
    double least = 0.5;  // share of an eye's sides that is drawn at least
    double foveate = 0;  // degrees from a lens's middle up to which splats are fine; 0: all are
    bool whole() const { return least >= 1; }  // splats too have all pixels
};

struct EyesDrawn {
    float scale = 1;        // of a target's sides, that was drawn into
    float splat_scale = 1;  // of these, that splats were drawn with
    double splats = 0;      // that they took [s]; 0: there are none
};

class HeadsetEyes {
  public:
    // In the headset's context. Throws std::runtime_error where this OpenGL does not do.
    HeadsetEyes(Headset& headset, const EyesOptions& options);
    ~HeadsetEyes();
    HeadsetEyes(const HeadsetEyes&) = delete;

    void renew();  // the headset has a new session
    // Throws std::runtime_error and std::invalid_argument where it cannot be drawn.
    EyesDrawn draw(const HeadsetViews& sight, const HeadsetPicture& picture);
    // Draws some pictures that nobody sees, so that the first one waits for nothing that is loaded,
    // made or registered once, and is of a size for which there is time. Where they cannot be
    // drawn, that one says so.
    void rehearse(const HeadsetPicture& picture);
    int gl_errors() const;     // of what was drawn
    std::string told() const;  // of what was found at the start; "": nothing of note
    // Which way what the device makes comes here; without text where there is no CUDA device.
    Sharing sharing() const;

  private:
    struct Parts;
    std::unique_ptr<Parts> parts;
};

}  // namespace knead
