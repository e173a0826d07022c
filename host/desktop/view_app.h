// What `knead view` does in a frame: input to camera, hand and session; the session's state to a
// picture with panels.
#pragma once
#include <memory>
#include <string>

#include "host/desktop/view_clock.h"
#include "host/desktop/view_panels.h"
#include "host/desktop/view_still.h"
#include "host/files/video.h"
#include "host/hands/pointer.h"
#include "host/live/session_record.h"
#include "host/picture/live_look.h"
#include "host/picture/splat_layer.h"
#include "host/ui/live_results.h"
#include "render/coarse_picture.h"
#include "render/view/losses.h"
#include "render/view/orbit.h"
#include "render/view/window.h"

namespace knead {

struct ViewAppOptions {
    Device device;  // resolved
    // With a script, time passes by a frame of the simulation for each one that is drawn, so that
    // the same script gives the same clay; otherwise it is real time.
    InputScript script;
    bool scripted = false;
    bool every_frame = false;           // draws though nothing has changed: frames are counted
    bool paused = false;                // begins so
    std::vector<std::string> settings;  // of the command line, for every scene that is chosen
    int cells = 0;                      // likewise; 0: the scene's
    std::size_t memory = 0;             // [bytes] that a scene may take; 0: what is free
};

class ViewApp {
  public:
    ViewApp(std::unique_ptr<Window> window, std::shared_ptr<const LiveScene> scene,
            ViewAppOptions options);

    // One round, `passed` [s] after the last one: it waits where there is nothing to do, and draws
    // where something has changed. A name of a file makes a picture of it.
    void frame(double passed, const std::string& screenshot);
    void end();  // of a film
    // What came of the session, which stands still from now on.
    LiveResults results();

    bool closed() const { return window && window->closed(); }
    int drawn() const { return frames; }
    int gl_errors() const { return errors; }
    int contexts_lost() const { return losses.count(); }
    const std::string& renderer() const { return drawn_by; }
    bool output_refused() const { return refused; }
    bool ended() const { return !session.state()->trouble.empty(); }  // the simulation has
    std::string summary() const;
    // Which way what the device makes comes to the window; "" where there is no CUDA device.
    std::string sharing() const
    {
        return options.device.kind == DeviceKind::cuda ? painter->sharing(options.device.index).text
                                                       : "";
    }

    ViewPanels panels;

  private:
    // A command that throws clay away; it needs a confirmation.
    struct Discard {
        bool reset = false;
        int load = -1;     // the scene's number
        double until = 0;  // the window's time at which the question goes away [s]
        bool any() const { return reset || load >= 0; }
    };

    LiveOptions live_options();
    bool listen();
    double patience() const;
    bool must_draw(bool happened);
    void look_whether_seen();
    void follow_history();
    void apply(PanelRequests asks);
    void take_keys();
    void take_mouse(double passed);
    void lead_hand(bool on);
    void pause(bool on);
    void step();
    void discard(Discard what);
    void do_discard(const Discard& what);
    void answer(bool yes);
    void move_hand();
    void simulate();
    void record_hands();
    void draw();
    PictureContent seen_now(const EyeView& view, const EyeLook& look) const;
    void paint(const EyeView& view, const EyeLook& look, const std::vector<HandLook>& hands);
    void follow_splats();
    void draw_splats(const EyeView& view, bool whole);
    void keep_picture(const std::string& file);
    void keep_pictures();
    void film();
    void frame_camera();
    void reopen();
    void tell_facts();

    const ViewAppOptions options;
    std::unique_ptr<Window> window;
    std::unique_ptr<EyePainter> painter;
    std::unique_ptr<CoarsePicture> coarse;
    Pace pace;
    InputScript script;
    WindowClock clock;  // in real time
    SessionRecord record;
    LiveSession session;
    std::shared_ptr<const LiveState> state;
    InputState input;
    OrbitCamera camera;
    PointerHand pointer;
    HandFrame tracked;
    std::unique_ptr<SplatDrawer> splats;
    const LiveScene* shown = nullptr;  // the scene that camera and splats are of
    int history = 0;                   // that is followed
    int splats_of = 0;                 // history
    long splat_version = 0;            // that is drawn
    std::unique_ptr<Video> video;
    double filmed = 0;                // [s] of the film so far
    std::vector<std::string> wanted;  // screenshots of this frame
    int frames = 0, errors = 0, film_width = 0, film_height = 0;
    ContextLosses losses;
    std::string drawn_by;  // OpenGL's name of the renderer
    bool hand_led = false, refused = false, paused = false;
    bool hidden = false;     // nobody sees the window: the session waits
    bool stepping = false;   // one frame, though paused
    bool worked = false;     // the clay was shaped since its history began
    Discard asked;           // what is to be confirmed
    double window_time = 0;  // goes on with the window [s]
    double time = 0;         // of the session's history; stands still while paused [s]
    long ticks = 0;          // of the history, with a script: frames
    struct {
        std::size_t next = 0;  // frame
        double at = 0;         // of the recording [s]
        double shift = 0;      // from its time to the session's [s]
    } replay;                  // the scene's recorded hands, which are recorded anew
    double pushed = -1e30;     // the last hands to the simulation [s]
    double glow_until = 0;     // of the window: an object was selected [s]
    int selected = 0;
    double awake_until = 0;     // of the window: panels move for so long after an event [s]
    int settling = 0;           // frames until panels that changed have their size
    double last_drawn = -1e30;  // of the window [s]
    double began = 0;           // the last round, on the wall's clock [s]
    long drawn_version = -1;    // of the state
    std::string drawn_text;     // what was said and asked
    StillPicture still;
    double raster_took = 0, picture_took = 0, show_took = 0;  // [s]
    long touched = 0, counted = 0;  // particle-substeps put out of tools; the version counted to
};

}  // namespace knead
