// The loop of `knead vr`: connects the headset, a live session and the renderer. It draws and waits
// for the display only; the simulation runs on its own thread.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/base/abandonable.h"
#include "host/document/command_text.h"
#include "host/live/live_session.h"
#include "host/session/backend.h"
#include "host/vr/headset_figures.h"
#include "host/vr/headset_view.h"

namespace knead {

struct HeadsetLoopOptions {
    HeadsetOptions headset;
    Device device;  // resolved; for solver and splats
    // True: the simulation advances by the display's time and each display frame waits for it;
    // equal hands give bitwise equal results. False: real time.
    bool stepped = false;
    bool recorded = false;    // the scene's recorded hands move the tools
    bool hands_only = false;  // no simulation: hands are only recorded
    Workplace workplace;
    bool panel = true;
    std::string scene;                  // path; the panel lists the scenes of its folder
    std::vector<std::string> settings;  // --set, for all scenes
    std::string session;                // file of a session to go on with; "": none
    bool protects = false;              // keeps a working log
    int frames = 0;                     // display frames to draw, without paused ones; 0: no limit
    double near_plane = 0.05;           // near plane [m]
    int samples = 0;  // per pixel; 0: 1 on a CPU; on a GPU 4, or 1 if that is too slow
    // Real time: lower limit of the linear resolution scale, which is reduced if drawing is too
    // slow.
    double min_scale = 0.5;
    double foveate = 0;  // angle from a lens's axis with full splat resolution [deg]; 0: no limit
    bool sound = true;   // acoustic feedback, in real time only
    // Both must be thread-safe.
    std::function<void(const std::string&)> notify;  // messages for the user
    std::function<bool()> should_stop;               // true: the user has interrupted
};

// Options of the live session. `clock`: the session's time [s].
LiveOptions live_options(const HeadsetLoopOptions& options, std::function<double()> clock);

struct HeadsetEnd {
    std::string reason;  // why the session ended; "": on request
    HeadsetInfo facts;
    FrameFigures figures;
    Recording hands;      // as the simulation received them; empty if there were none
    CommandLog commands;  // that were applied; without the recording's hash
    std::shared_ptr<const LiveState> state;  // never null
    std::string hash;                        // of the clay's state; "": there was no simulation
    double rate = 0;                         // of the display [1/s]; 0: unknown
    double length = 0;                       // of the session, from its first frame [s]
    long particles = 0;
    long drawn = 0;              // display frames drawn, both eyes each
    int gl_errors = 0;           // raised by the project's drawing
    int runtime_gl_errors = 0;   // GL errors left by the runtime
    int sessions_recreated = 0;  // sessions lost and recreated
    double left_out = 0;         // stepped time: display time that was not simulated [s]
    bool shared = false;         // clay and splats reach OpenGL without a copy through the host
};

// The session of `knead vr`. One thread calls open(), step() until it returns false, and close();
// another thread may call results() while it holds the gate.
class HeadsetSession {
  public:
    // `gate` must outlive the session. Precondition of all functions: the caller holds it.
    static std::unique_ptr<HeadsetSession> make(std::shared_ptr<const LiveScene> scene,
                                                const HeadsetLoopOptions& options, CallGate& gate);
    virtual ~HeadsetSession() = default;

    // Throws HeadsetError, and std::runtime_error if OpenGL lacks what is needed.
    virtual void open() = 0;
    // One round of the loop; false when the session is over: left by the user, ended by the
    // runtime, or all frames drawn.
    virtual bool step() = 0;
    // Call once; ends simulation and recording. `reason`: default for HeadsetEnd::reason.
    virtual HeadsetEnd results(const std::string& reason) = 0;
    virtual void close() = 0;
    // Whether the loop depends on the runtime: the session is visible, is being recreated or is
    // ending. Only then does a call that does not return count as a lost runtime.
    virtual bool needs_runtime() const = 0;
};

}  // namespace knead
