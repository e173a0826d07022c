// OpenGL side of a headset session: draws a live state for both eyes into the headset's textures.
#pragma once
#include <memory>
#include <string>

#include "host/live/live_session.h"
#include "host/session/backend.h"
#include "host/ui/panel_drawing.h"
#include "host/vr/finger_pointer.h"
#include "host/vr/headset_view.h"

namespace knead {

// Input for drawing one frame.
struct HeadsetPicture {
    const LiveState& state;
    std::vector<HandLook> hands;
    const HandsOptions& options;  // scale and offset of hands and eyes in the simulation
    const Workplace& workplace;
    float near_plane;  // near plane [m], unscaled
    // Shown in the frame of the hands: parts of the picture of panel().
    std::vector<TouchPanel> panels{};
    bool panel_changed = false;  // panel() was laid out anew
    double now = 0;              // time of display, in the state's session [s]
    bool at_once = false;        // upload new splats before drawing; else on a thread
    // GPU time for both eyes [s]; the resolution is reduced if it is exceeded. 0: no limit.
    double budget = 0;
};

struct HeadsetLoopOptions;  // host/vr/headset_loop.h

struct EyesOptions {
    // Share of a frame for OpenGL in real time: the device also simulates.
    static constexpr double gl_share = 0.6;
    static EyesOptions of(const HeadsetLoopOptions& options);
    // Frame period [s] assumed until the display reports its own.
    static double usual_period(const HeadsetLoopOptions& options);

    Device device;    // of the rasteriser of splats
    int samples = 1;  // per pixel
    // GPU time for both eyes [s]: if empty eyes take longer at the start, drawing begins with one
    // sample per pixel and, if needed, reduced resolution. 0: not measured.
    double budget = 0;
    double least = 0.5;  // lower limit of the linear resolution scale
    double foveate = 0;  // angle from a lens's axis with full splat resolution [deg]; 0: no limit
    bool full_resolution() const { return least >= 1; }  // splats too have full resolution
};

struct EyesDrawn {
    float scale = 1;        // linear resolution scale of the eyes
    float splat_scale = 1;  // linear scale of the splats, relative to it
    double splats = 0;      // time for splats [s]; 0: there are none
};

class HeadsetEyes {
  public:
    // Precondition: the headset's context is current. Throws std::runtime_error if this OpenGL
    // lacks what is needed.
    HeadsetEyes(Headset& headset, const EyesOptions& options);
    ~HeadsetEyes();
    HeadsetEyes(const HeadsetEyes&) = delete;

    void renew();  // call when the headset has a new session
    // Throws std::runtime_error or std::invalid_argument if drawing fails.
    EyesDrawn draw(const HeadsetViews& views, const HeadsetPicture& picture);
    // Warm-up: draws some pictures off screen, so that the first visible one loads, allocates and
    // registers nothing, and its resolution has settled. Errors are ignored; draw() reports them.
    void rehearse(const HeadsetPicture& picture);
    // Replaces the panel. Null: a build without one. Throws ResourceError if OpenGL refuses.
    PanelDrawing* open_panel(const PanelDrawingOptions& layout);
    int gl_errors() const;        // of the drawing
    std::string message() const;  // message from the measurement at the start; "": none
    // How data of the CUDA device reaches OpenGL; without text if there is no CUDA device.
    Sharing sharing() const;

  private:
    struct Parts;
    std::unique_ptr<Parts> parts;
};

}  // namespace knead
