// What `knead view` does in a frame: input to camera, hand and session; the session's state to a
// picture with panels.
#pragma once
#include <memory>
#include <string>

#include "host/cli/view_panels.h"
#include "host/files/video.h"
#include "host/hands/pointer.h"
#include "host/session/live_look.h"
#include "host/session/splat_layer.h"
#include "render/coarse_picture.h"
#include "render/view/orbit.h"
#include "render/view/window.h"

namespace knead {

class ViewDesk {
  public:
    // With a script, time passes by a frame of the simulation for each one that is drawn, so that
    // the same script gives the same clay; otherwise it is real time.
    ViewDesk(std::unique_ptr<Window> window, std::shared_ptr<const LiveScene> scene, Device device,
             InputScript script, bool scripted, bool paused);

    // Draws a frame, `passed` [s] after the last one. A name of a file makes a picture of it.
    void frame(double passed, const std::string& screenshot);
    void end();  // of a film

    bool closed() const { return window->closed() || quit; }
    int drawn() const { return frames; }
    int gl_errors() const { return errors; }
    bool output_refused() const { return refused; }
    bool ended() const { return !session.state()->trouble.empty(); }  // the simulation has
    std::string summary() const;
    // Which way what the device makes comes to the window; "" where there is no CUDA device.
    std::string sharing() const
    {
        return device.kind == DeviceKind::cuda ? painter->sharing(device.index).text : "";
    }

    ViewPanels panels;

  private:
    void listen();
    void take_keys();
    void take_mouse(double passed);
    void lead_hand(bool on);
    void move_hand(double time);
    void draw();
    void follow_splats();
    void draw_splats(const EyeView& view, bool whole);
    void keep_picture(const std::string& file);
    void film();
    void frame_camera();
    void reopen();
    void tell_facts();

    std::unique_ptr<Window> window;
    std::unique_ptr<EyePainter> painter;
    std::unique_ptr<CoarsePicture> coarse;
    Pace pace;
    Device device;
    InputScript script;
    const bool scripted;
    LiveSession session;
    std::shared_ptr<const LiveState> state;
    InputState input;
    OrbitCamera camera;
    PointerHand pointer;
    HandFrame tracked;
    std::unique_ptr<SplatDrawer> splats;
    const LiveScene* shown = nullptr;  // the scene that camera and splats are of
    int splats_of = 0;                 // history
    long splat_version = 0;            // that is drawn
    std::unique_ptr<Video> video;
    double filmed = 0;                // [s] of the film so far
    std::vector<std::string> wanted;  // screenshots of this frame
    int frames = 0, errors = 0, lost = 0, film_width = 0, film_height = 0;
    bool hand_led = false, quit = false, refused = false;
    double time = 0, glow_until = 0;  // of the session; when an object was selected [s]
    int selected = 0;
    double raster_took = 0, picture_took = 0, show_took = 0;  // [s]
    long touched = 0, counted = 0;  // particle-substeps put out of tools; the version counted to
};

}  // namespace knead
