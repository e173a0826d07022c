// The headset session's members, for the files that define its functions.
#pragma once
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "host/live/session_record.h"
#include "host/session/fist_gesture.h"
#include "host/vr/headset_eyes.h"
#include "host/vr/headset_feel.h"
#include "host/vr/headset_hands.h"
#include "host/vr/headset_loop.h"
#include "host/vr/headset_notices.h"
#include "host/vr/headset_objects.h"
#include "host/vr/headset_panel.h"
#include "host/vr/headset_time.h"
#include "host/vr/scene_gesture.h"

namespace knead {

class HeadsetLoop : public HeadsetSession {
  public:
    HeadsetLoop(std::shared_ptr<const LiveScene> scene, HeadsetLoopOptions options, CallGate& gate);
    void open() override;
    bool step() override;
    HeadsetEnd results(const std::string& reason) override;
    void close() override;
    bool needs_runtime() const override { return visible || lost || leaving; }

  private:
    // Calls into the runtime, and into OpenGL, which may wait for the runtime. Either may never
    // return; the gate is released meanwhile.
    template <class Call>
    auto runtime(const Call& call)
    {
        return gate.call_unlocked(true, call);
    }
    template <class Call>
    auto drawing(const Call& call)
    {
        return gate.call_unlocked(false, call);
    }
    void frame();
    void simulate(const HeadsetViews& views, bool runs, FrameParts& parts);
    void push(HandFrame given, bool runs, double now);
    void follow_history();
    HeadsetPicture picture_of(std::vector<HandLook> looks);
    void rehearse();
    bool draw(const HeadsetViews& views, FrameParts& parts);
    void open_panel();
    void place_panel();
    void follow_panel(const HeadsetViews& views);
    PanelSurroundings surroundings(const HeadsetViews& views) const;
    void follow_tools();
    void add_times(const FrameParts& parts);
    void follow_fists(const HandFrame& given);
    void begin_carrying(int category, Side by);
    void end_carrying();
    void send_presence();
    void pause(bool on);
    void execute(const ControlEvent& event);
    void set_mode(HandMode to);
    void follow_objects(const HeadsetViews& views);
    void follow_buttons(const HandAct (&acts)[side_count]);
    void move_scene(const HeadsetViews& views, const HandAct (&acts)[side_count]);
    void check_end(const HeadsetEvents& events);

    CallGate& gate;
    std::shared_ptr<const LiveScene> first_scene;
    HeadsetLoopOptions options;
    std::unique_ptr<Headset> headset;
    std::unique_ptr<HeadsetEyes> eyes;
    DisplayClock clock;
    SessionTime time;
    std::unique_ptr<LiveSession> live;
    std::shared_ptr<const LiveState> state;
    HeadsetHands hands;
    Workplace workplace;
    HeadsetEnd end;
    FrameTiming timing;
    bool ran = false;              // simulated time advanced in the previous frame
    bool frame_submitted = false;  // a frame was submitted since the OpenXR session began
    bool started = false;          // the simulation was started
    double last_shown = -1;  // FrameTiming::time of the previous frame [s]; negative: it was not
                             // displayed
    double began = -1;       // wall time of the first frame [s]; negative: none yet
    bool restart_filter = false;     // restart the hand filter with the next frame
    bool replace_workplace = false;  // move the clay before the head, once that is located
    Floor floor = Floor::seated;
    bool leaving = false, visible = false, lost = false;
    bool finished = false;  // results() was called
    int frames = 0;         // pushed to the simulation
    int history = 0;        // of the current state
    SessionRecord record;

    PanelController control;
    HeadsetPanel panel{control};
    Side placed_side = left;    // of the panel, when it was placed,
    double placed_zoom = 0;     // and the zoom of the hands
    float opened_distance = 0;  // of the panel, for which its letters are large enough [m]
    DocumentPtr tools_of;       // whose tools the hands hold
    TimeGraph times;            // of the last frames
    HeadsetViews newest_views;  // of this frame
    bool paused = false;
    HandMode mode = HandMode::shape;
    HandReader readers[side_count];
    bool buttons[side_count][2] = {};  // of controllers, in the previous frame
    HeadsetObjects objects{control};
    SceneGesture scene_gesture;
    FistGesture fists;
    std::vector<ObjectRef> carried;  // objects in a fist
    Side carried_by = right;
    bool shapes_after = false;  // an object is being put down by hands that shaped before
    bool moving_scene = false;  // by two fists, in the previous frame
    int facts_age = 0;          // frames since the panel's lines of text were renewed
    std::string draw_error;     // reason of the last drawing failure; "": none
    HeadsetNotices notices;
    std::future<std::vector<Recoverable>> recoverable;  // being searched
    HeadsetFeel feedback;
};

}  // namespace knead
