// A headset, a live session and the painter of eyes, joined: the loop of `knead vr`. It draws and
// waits for the display alone; the simulation lives on its own thread.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/base/abandonable.h"
#include "host/live/live_session.h"
#include "host/session/backend.h"
#include "host/vr/headset_figures.h"
#include "host/vr/headset_view.h"

namespace knead {

struct HeadsetLoopOptions {
    HeadsetOptions headset;
    Device device;  // resolved: of solver and splats
    // The display's time steps the simulation, and a frame waits for it: the same hands give the
    // same bits. Otherwise it lives in real time.
    bool stepped = false;
    bool recorded = false;    // the scene's recorded hands move the tools, the user watches
    bool hands_only = false;  // the clay stands still: hands are recorded
    Workplace workplace;
    bool panel = true;
    std::string scene;                  // its file: the panel offers those beside it
    std::vector<std::string> settings;  // that go with it
    int frames = 0;         // of the simulation's time, in frames of the display; 0: until it ends
    double nearest = 0.05;  // nothing nearer to an eye is drawn [m]
    int samples = 0;        // of a pixel; 0: 1, or on a GPU 4 where there is time for them
    // In real time, where OpenGL is too slow, an eye's sides are drawn down to this share.
    double least_scale = 0.5;
    double foveate = 0;  // degrees from a lens's middle up to which splats are fine; 0: all are
    bool sound = true;   // of what hands do to clay, in real time
    std::function<void(const std::string&)> tell;  // messages for people, of several threads
    std::function<bool()> stop;                    // the user interrupts it; any thread calls this
};

// Of the session that it joins with the headset. `clock` says the session's time [s]; `acted` is
// told of what is done beside hands.
LiveOptions live_options(const HeadsetLoopOptions& options, std::function<double()> clock,
                         std::function<void(const HandAction&)> acted);

struct HeadsetEnd {
    std::string reason;  // why the headset ended; "": as it was asked to
    HeadsetInfo facts;
    FrameFigures figures;
    Recording hands;      // as the simulation had them; without frames: none came
    HandActions actions;  // what was done beside them; the recording's hash is not filled in
    std::shared_ptr<const LiveState> state;  // never null
    std::string hash;                        // of the clay's state; "": there was no simulation
    double rate = 0;                         // of the display [1/s]; 0: not known
    double length = 0;                       // of the session, from its first frame [s]
    long particles = 0;
    long drawn = 0;       // pairs of eyes
    int gl_errors = 0;    // of our own drawing
    int stray = 0;        // GL errors that the runtime left
    int renewals = 0;     // sessions that were lost and begun anew
    double left_out = 0;  // time of the display that was not simulated in stepped time [s]
    bool shared = false;  // clay and splats went from CUDA to OpenGL without the host
};

// The session of `knead vr`. One thread calls open(), turn() until it is false, and close();
// results() may be called by another that has entered the gate.
class HeadsetSession {
  public:
    // `gate` outlives it, and is held during all calls.
    static std::unique_ptr<HeadsetSession> make(std::shared_ptr<const LiveScene> scene,
                                                const HeadsetLoopOptions& options, CallGate& gate);
    virtual ~HeadsetSession() = default;

    // Throws HeadsetError, and std::runtime_error where OpenGL does not do.
    virtual void open() = 0;
    // One round of the loop; false when the user or the runtime has left the headset, or all frames
    // were drawn.
    virtual bool turn() = 0;
    // Once; nothing is simulated or recorded afterwards. `reason` as HeadsetEnd::reason, where the
    // session has none of its own.
    virtual HeadsetEnd results(const std::string& reason) = 0;
    virtual void close() = 0;
    // Whether the runtime owed an answer in the last round: a frame that is seen, a new session, or
    // its end.
    virtual bool awaited() const = 0;
};

}  // namespace knead
