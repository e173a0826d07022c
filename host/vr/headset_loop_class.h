// The headset session's members, for the files that define its functions.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "host/live/session_record.h"
#include "host/session/carry.h"
#include "host/vr/headset_eyes.h"
#include "host/vr/headset_feel.h"
#include "host/vr/headset_hands.h"
#include "host/vr/headset_loop.h"
#include "host/vr/headset_notices.h"
#include "host/vr/headset_time.h"
#include "host/vr/panel_desk.h"

namespace knead {

class HeadsetLoop : public HeadsetSession {
  public:
    HeadsetLoop(std::shared_ptr<const LiveScene> scene, HeadsetLoopOptions options, CallGate& gate);
    void open() override;
    bool turn() override;
    HeadsetEnd results(const std::string& reason) override;
    void close() override;
    bool awaited() const override { return in_view || lost || leaving; }

  private:
    // Calls into the runtime, and into OpenGL, which may wait for it: they may never return.
    template <class Call>
    auto runtime(const Call& call)
    {
        return gate.outside(true, call);
    }
    template <class Call>
    auto drawing(const Call& call)
    {
        return gate.outside(false, call);
    }
    void frame();
    void simulate(const HeadsetViews& sight, bool runs, FrameParts& parts);
    void push(HandFrame given, bool runs, double now);
    void follow_history();
    HeadsetPicture picture_of(std::vector<HandLook> looks, bool repaint);
    void rehearse();
    bool draw(const HeadsetViews& sight, FrameParts& parts);
    void poke(const HeadsetViews& sight);
    void hold_clay(const HandFrame& given);
    void tell_hands();
    void apply(const PanelCommand& command, const HeadsetViews& sight);
    void look_for_end(const HeadsetEvents& news);

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
    FrameTiming tick;
    bool ran = false;         // in the frame before
    bool pictured = false;    // a frame was submitted since the OpenXR session began
    bool started = false;     // so was the simulation
    double last_shown = -1;   // the frame before, by Tick::time; negative: it was not [s]
    double began = -1;        // of the wall [s]; negative: no frame has
    bool anew = false;        // hands are to be taken for new
    bool place_anew = false;  // the clay before the head, as soon as that is located
    Floor floor = Floor::seated;
    bool leaving = false, in_view = false, lost = false;
    bool taken = false;  // the results were
    int frames = 0;      // of the session's time
    int history = 0;     // of the state that is followed
    SessionRecord record;

    HeadsetPanel panel;
    PanelDesk desk;
    PanelCanvas canvas;
    Side panel_side = left;
    bool paused = false;
    Carry hold;
    bool holding = false;  // hands carry clay, and do not shape it
    int panel_age = 0;     // frames since it was painted; 0: it must be
    std::string undrawn;   // why nothing is, if so
    HeadsetNotices notices;
    HeadsetFeel felt;
};

}  // namespace knead
