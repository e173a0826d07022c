// A headset, a live session and the painter of eyes, joined: the loop of `knead vr`. It draws and
// waits for the display alone; the simulation lives on its own thread.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/session/headset_figures.h"
#include "host/session/headset_hands.h"
#include "host/session/headset_time.h"
#include "host/session/live.h"
#include "host/session/panel_desk.h"
#include "host/session/panel_quad.h"

namespace knead {

struct HeadsetLoopRule {
    HeadsetRule headset;
    std::function<std::unique_ptr<Solver>(const Setup&)> make;  // the solver of a scene
    // The display's time steps the simulation, and a frame waits for it: the same hands give the
    // same bits. Otherwise it lives in real time.
    bool stepped = false;
    bool recorded = false;  // the scene's recorded hands move the tools, the user watches
    Workplace workplace;
    bool panel = true;
    std::string scene;                  // its file: the panel offers those beside it
    std::vector<std::string> settings;  // that go with it
    int frames = 0;         // of the simulation's time, in frames of the display; 0: until it ends
    double nearest = 0.05;  // nothing nearer to an eye is drawn [m]
    int samples = 1;        // of a pixel
    std::function<void(const std::string&)> tell;  // messages for people
    std::function<bool()> stop;                    // asked every frame
};

struct HeadsetEnd {
    std::string reason;  // why the headset ended; "": as it was asked to
    HeadsetFacts facts;
    FrameFigures figures;
    Recording hands;  // as the simulation had them; without frames: none came
    std::shared_ptr<const LiveState> state;
    std::string hash;   // of the clay's state; "": there was no simulation
    long drawn = 0;     // pairs of eyes
    int gl_errors = 0;  // of our own drawing
    int stray = 0;      // GL errors that the runtime left
    int renewals = 0;   // sessions that were lost and begun anew
};

class HeadsetLoop {
  public:
    // Opens the headset. Throws HeadsetError, and std::runtime_error where OpenGL does not do.
    HeadsetLoop(std::shared_ptr<const LiveScene> scene, HeadsetLoopRule rule);
    ~HeadsetLoop();
    // Until the user or the runtime leaves, or all frames were drawn.
    HeadsetEnd run();

  private:
    bool turn();
    void frame(const News& news);
    void simulate(const Sight& sight, bool runs, FrameParts& parts);
    void push(HandFrame given, bool runs, double now);
    void follow_history();
    void draw(const Sight& sight);
    void draw_panel(const EyeView& view, const EyeTarget& to);
    void poke(const Sight& sight);
    void obey(const PanelCommand& command, const Sight& sight);
    void show_state();
    void look_for_end(const News& news);
    void make_targets();
    double wall() const;

    HeadsetLoopRule rule;
    std::unique_ptr<Headset> headset;
    std::unique_ptr<EyePainter> painter;
    unsigned target = 0;     // framebuffer
    unsigned own_depth = 0;  // texture, where the headset takes none
    DisplayClock clock;
    SessionTime time;
    std::unique_ptr<LiveSession> live;
    std::shared_ptr<const LiveState> state;
    HeadsetHands hands;
    Workplace workplace;
    HeadsetEnd end;
    Tick tick;
    bool ran = false;   // in the frame before
    bool anew = false;  // hands are to be taken for new
    bool leaving = false;
    int frames = 0;  // of the session's time
    bool recording_full = false;
    int history = 0;           // of the state that is followed
    double recorded_from = 0;  // the session's time at its begin [s]

    HeadsetPanel panel;
    PanelDesk desk;
    std::unique_ptr<PanelQuad> quad;
    Side panel_side = left;
    bool paused = false;
    int panel_age = 0;  // frames since it was painted; 0: it must be
};

}  // namespace knead
