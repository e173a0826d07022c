// Main loop of `knead view`: input to camera, hand and session; the session's state to a picture
// with panels.
#pragma once
#include <future>
#include <memory>
#include <string>

#include "host/desktop/view_clock.h"
#include "host/desktop/view_still.h"
#include "host/files/video.h"
#include "host/hands/pointer.h"
#include "host/live/session_record.h"
#include "host/picture/live_look.h"
#include "host/picture/splat_layer.h"
#include "host/ui/live_results.h"
#include "host/ui/moved_objects.h"
#include "host/ui/nozzle_gesture.h"
#include "host/ui/panel_controller.h"
#include "host/ui/panel_drawing.h"
#include "host/ui/panel_refresh.h"
#include "host/ui/pick.h"
#include "host/ui/place_gesture.h"
#include "host/ui/place_watch.h"
#include "host/ui/transform_gesture.h"
#include "render/coarse_picture.h"
#include "render/view/losses.h"
#include "render/view/orbit.h"
#include "render/view/window.h"

namespace knead {

struct ViewAppOptions {
    Device device;  // resolved
    // With a script, each drawn frame simulates one frame, so that equal scripts give equal clay;
    // otherwise real time.
    InputScript script;
    bool scripted = false;
    bool every_frame = false;           // draw even if nothing has changed
    bool paused = false;                // at the start
    std::vector<std::string> settings;  // --set, for every scene
    int cells = 0;                      // for every scene; 0: the scene's
    std::size_t memory = 0;             // limit for loading a scene [bytes]; 0: what is free
    std::string session;                // file of a session to go on with; "": none
    std::string dropped;    // splats or a mesh to add at the beginning: a file; "": none
    bool protects = false;  // keeps a working log, and lists sessions to recover
};

class ViewApp {
  public:
    // Throws what opening the session threw.
    ViewApp(std::unique_ptr<Window> window, std::shared_ptr<const LiveScene> scene,
            ViewAppOptions options);

    // One round, `passed` [s] after the last one: waits for input if there is nothing to do, draws
    // if something has changed. `screenshot`: file for a picture of this round; "": none.
    void frame(double passed, const std::string& screenshot);
    void end();  // ends the recorded video
    // Pauses the session and returns its results. Call once.
    LiveResults results();

    bool closed() const { return leaves; }
    int drawn() const { return frames; }
    int gl_errors() const { return errors; }
    int contexts_lost() const { return losses.count(); }
    const std::string& renderer() const { return gl_renderer; }
    bool output_refused() const { return refused; }
    bool ended() const { return !session.state()->failure.empty(); }  // by a fault
    std::string summary() const;
    // How data of the CUDA device reaches the window; "" if there is no CUDA device.
    std::string sharing() const
    {
        return options.device.kind == DeviceKind::cuda ? painter->sharing(options.device.index).text
                                                       : "";
    }

    PanelController panel;

  private:
    LiveOptions live_options();
    bool process_input();
    double event_timeout() const;
    bool must_draw(bool happened);
    void lay_out_panel(double passed, bool happened);
    void update_visibility();
    void follow_history();
    bool clay_changed() const;
    void open_panel();
    PanelInput panel_input(double passed) const;
    void execute(const ControlEvent& event);
    void take_keys();
    void take_mouse(double passed);
    void take_nozzle(bool begins, bool held);
    void end_nozzle(bool keeps);
    void take_placing();
    std::vector<HandLook> placing_looks() const;
    void take_file(const std::string& file);
    void click(float x, float y, bool several);
    void follow_places();
    void hover(bool free);
    bool shows_chosen() const;
    // Gestures (view_transform.cpp).
    TransformView transform_view() const;
    void begin_transform(TransformKind kind);
    std::optional<TransformSurface> floor_at(const TransformView& view) const;
    std::optional<TransformSurface> surface_at(const TransformView& view) const;
    void take_transform();
    void end_transform(bool applies);
    std::vector<HandLook> transform_looks() const;
    std::vector<HandLook> outlines() const;
    void follow_colours();
    void escape();
    void control_hand(bool on);
    HandsOptions hands_now() const;
    void pause(bool on);
    void step();
    long newest_step() const;
    void move_hand();
    void find_surface(Vec3<double> eye, Vec3<double> ray);
    HandLook ring() const;
    void simulate();
    void record_hands();
    void draw();
    PictureContent picture_content(const EyeView& view, const EyeLook& look) const;
    void paint(const EyeView& view, const EyeLook& look, const std::vector<HandLook>& hands);
    void follow_splats();
    void draw_splats(const EyeView& view, bool full_resolution);
    void save_picture(const std::string& file);
    void save_pictures();
    void keep_picture();
    void film();
    void fit_camera(ObjectId chosen);
    void recreate_context();
    void update_facts();
    void update_title();
    void add_times();

    const ViewAppOptions options;
    std::unique_ptr<Window> window;
    std::unique_ptr<EyePainter> painter;
    std::unique_ptr<CoarsePicture> coarse;
    std::unique_ptr<PanelDrawing> drawing;  // null: a build without panels
    PanelRefresh refresh;
    float drawing_scale = 0;
    TimeGraph times;
    long timed = 0;  // version of the state whose times were added
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
    PlaceWatch watch;
    std::optional<NozzleGesture> nozzle;      // laying clay
    std::optional<TransformGesture> gesture;  // under way
    std::optional<Vec3<double>> placing_at;   // of the object that is being put down [m]
    ObjectPreviews preview;                   // surfaces when it began
    bool buttons_ignored = false;             // those that ended a gesture, while they are down
    ClayColours colours;                      // of the clay that is drawn,
    long coloured = -1;                       // of this version of it,
    DocumentPtr colours_of;                   // this document,
    std::shared_ptr<const ObjectPlaces> colours_at;  // and these places
    ObjectId hovered;                                // below the pointer, without a hand; 0: none
    std::optional<Picked> below;  // the pointer, found from here, along this ray [m]
    Vec3<double> sought_from{}, sought_along{};
    long sought_in = -1;      // version of the state
    double sought_at = -1e9;  // window time [s]
    std::unique_ptr<SplatDrawer> splats;
    const LiveScene* shown = nullptr;  // scene of camera and splats
    int history = 0;                   // of the current state
    int splats_of = 0;                 // history of the drawn splats
    long splat_version = 0;            // of the drawn splats
    std::unique_ptr<Video> video;
    double filmed = 0;                // duration of the film so far [s]
    std::vector<std::string> wanted;  // screenshots of this frame
    int frames = 0, errors = 0, film_width = 0, film_height = 0;
    ContextLosses losses;
    std::string gl_renderer;  // OpenGL's name of the renderer
    bool hand_controlled = false, refused = false, paused = false;
    bool hidden = false;     // the window is not visible: the session pauses
    bool stepping = false;   // compute one frame while paused
    bool shaped = false;     // the clay has been shaped since the last load or reset
    DocumentPtr opened;      // first document of the history
    bool leaves = false;     // the user has closed the window
    bool pressing = false;   // the left button went down in the picture, and is still
    bool cancelled = false;  // by escape: the press has no effect until the button is up
    float pressed_x = 0, pressed_y = 0;  // where [pixels]
    float hand_x = 0, hand_y = 0;        // where the hand points; rests while a dialog is open
    long step_at_press = -1;             // newest step when the button went down
    bool dragged = false;                // the mouse has moved since
    std::string title;
    double window_time = 0;  // never pauses [s]
    double time = 0;         // of the session's history; constant while paused [s]
    long ticks = 0;          // with a script: frames of the history
    struct {
        std::size_t next = 0;  // frame
        double at = 0;         // of the recording [s]
        double shift = 0;      // session time minus recording time [s]
    } replay;                  // the scene's recorded hands, to be recorded again
    double pushed = -1e30;     // time of the last hands pushed to the simulation [s]
    double glow_until = 0;     // window time until which the chosen object glows [s]
    ObjectId glowing;
    double awake_until = 0;     // window time until which panels are redrawn after an event [s]
    int settling = 0;           // frames until changed panels have their final size
    double last_drawn = -1e30;  // window time [s]
    double began = 0;           // wall time of the last round [s]
    long drawn_version = -1;    // of the state
    PanelModel drawn_model;
    StillPicture still;
    double raster_took = 0, picture_took = 0, show_took = 0;  // [s]
    std::future<std::vector<Recoverable>> recoverable;        // being searched
    std::future<void> encoding;  // the last picture, being encoded; destroyed before the session
    double kept_at = -1e30;      // window time of that picture [s]
    std::shared_ptr<const std::vector<StepInfo>> kept_steps;  // of that picture
    long touched = 0, counted = 0;  // particle-substeps projected out of tools; version of the
                                    // state up to which they are counted
};

}  // namespace knead
