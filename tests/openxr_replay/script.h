// What the replay runtime plays: head, hands, controllers and faults, over time. Everything it
// answers is a function of the script and the time, or the number of the frame.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "host/hands/hands.h"

namespace knead::replay {

enum class FaultKind {
    lose_session,     // calls answer XR_ERROR_SESSION_LOST from here on
    session_loss,     // the event that says so comes first
    lose_instance,    // calls answer XR_ERROR_INSTANCE_LOST; then `count` calls find no runtime
    lose_headset,     // the session is lost, and `count` times there is no headset
    take_off,         // the session stops; after `count` polls it may begin again
    unworn,           // the user is not present, for `count` frames
    no_render,        // shouldRender is false, for `count` frames
    lose_hand,        // not active, for `count` frames
    invalid_joints,   // active, but no joint is valid, for `count` frames
    invalid_fingers,  // active, but the fingers are not valid, for `count` frames
    constant_radii,   // all radii 0.01, for `count` frames
    leap,             // the hand is 0.3 m higher, for `count` frames
    refresh,          // the display runs at `value` per second from here on
    recentre,         // the origin has moved
    gl_error,         // xrEndFrame leaves a GL error behind
    steal_context,    // from here on calls that touch the GL leave no context current
    busy_images,      // no image comes free in the time that is given, for `count` frames
    hang,             // `call` does not return for `value` seconds; 0: for good
    exit              // the runtime ends the session, as by its menu
};

struct Fault {
    FaultKind kind;
    int frame = 0;  // of the runtime, from 0
    int count = 1;
    std::optional<Side> side;  // both where not given
    double value = 0;
    std::string call = "xrWaitFrame";

    bool during(int at) const { return at >= frame && at < frame + count; }
    bool of(Side s) const { return !side || *side == s; }
};

struct HeadKey {
    double time = 0;  // [s]
    Joint<double> pose{{1, 0, 0, 0}, {0, 0, 0}};
};
// A controller that is held from `from` to `to`.
struct Controller {
    Side side = right;
    double from = 0, to = 0;  // [s]
    Joint<double> grip{{1, 0, 0, 0}, {0, 0, 0}};
    Vec3<double> velocity{};  // [m/s]
    double trigger = 0, squeeze = 0;
    double lower = 0, upper = 0;  // buttons: A, X or menu; B, Y or trackpad
};

struct Script {
    double rate = 90;        // of the display [1/s]
    bool real_time = false;  // else xrWaitFrame returns at once, a frame later
    int width = 256, height = 256;
    double eyes_apart = 0.064;  // [m]
    std::vector<HeadKey> head;
    std::optional<Recording> hands;
    Vec3<double> hands_at{};  // where the recording's origin stands [m]
    std::vector<Controller> controllers;
    std::vector<std::string> without;  // extensions that are not offered
    std::vector<Fault> faults;
    std::string log;           // JSON lines: every frame, every vibration, every wrong call
    std::string dump;          // folder of pictures; "": none
    int dump_every = 1;        // frames
    int render_every = 1;      // frames: no other is to be rendered
    bool passthrough = false;  // offers blending over the world, too
    // False: there is no instance to be had, as of a runtime whose service is not started; no
    // headset.
    bool service = true, headset = true;

    static Script read(const std::string& file);  // throws InputError
    double at_frame(int frame) const { return frame / rate; }
    int frame_at(double time) const;
    bool has(FaultKind kind, int frame, std::optional<Side> side = {}) const;
};

Joint<double> head_at(const Script& script, double time);
Joint<double> eye_at(const Script& script, double time, int eye);

struct HandAnswer {
    bool active = false;
    Hand hand;
};
HandAnswer hand_at(const Script& script, Side side, double time);
// The controller of a side, or null.
const Controller* controller_at(const Script& script, Side side, double time);
Joint<double> grip_at(const Controller& controller, double time);

}  // namespace knead::replay
