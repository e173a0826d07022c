// Objects in the hands of a headset: chosen and moved by pinches, and clay that a pinch lays.
#pragma once
#include <future>
#include <vector>

#include "host/ui/grab_gesture.h"
#include "host/ui/hover.h"
#include "host/ui/moved_objects.h"
#include "host/ui/nozzle_gesture.h"
#include "host/ui/panel_controller.h"
#include "host/ui/place_gesture.h"
#include "host/ui/place_watch.h"
#include "host/vr/hand_act.h"

namespace knead {

// One frame of both hands.
struct ObjectHands {
    HandAct acts[side_count];                 // in the frame of the hands
    bool aside[side_count] = {false, false};  // at the panel, or moving the scene: no pinch begins
    bool cancels = false;
    const HandsOptions& options;  // to the simulation's frame
    double now = 0;               // ascending [s]
    bool waits = false;           // a stepped session: for its answers
};

class HeadsetObjects {
  public:
    explicit HeadsetObjects(PanelController& panel) : panel_(panel) {}

    // In HandMode::choose and HandMode::lay, and while an object is put down, in any mode in which
    // hands touch nothing; elsewhere it does nothing.
    void frame(const LiveState& state, LiveSession& session, const ObjectHands& hands);
    // Ends what is under way: a motion without effect. Call before the mode changes.
    void stop(LiveSession& session);
    // Whether hands are in use: moving objects or laying clay.
    bool busy() const { return grab_.pinches() || nozzle_ || panel_.ui.placing; }

    // Amplitude with which a controller vibrates, 0 to 1: in pulses while the nozzle is clogged.
    float vibration(Side side) const;
    // Marks of chosen objects and of those below a hand, previews, rays and rings.
    std::vector<HandLook> looks(const LiveState& state, const HandsOptions& options) const;
    // What the hands do, for the panel; "": nothing.
    std::string text() const;

  private:
    void forget();
    void choose(const LiveState& state, LiveSession& session, const ObjectHands& hands);
    void begin_move(const LiveState& state, LiveSession& session, const ObjectHands& hands);
    void end_move(const LiveState& state, LiveSession& session);
    void place(const LiveState& state, LiveSession& session, const ObjectHands& hands);
    void lay(const LiveState& state, LiveSession& session, const ObjectHands& hands);
    void end_nozzle(LiveSession& session, bool keeps);
    ObjectMotion motion() const;
    Joint<double> in_simulation(const HandAct& act, const HandsOptions& options) const;
    HandLook nozzle_ring(Side side, const HandsOptions& options) const;

    PanelController& panel_;
    PlaceWatch watch_;
    Hover hover_[side_count];
    HandAct acts_[side_count];  // of the newest frame
    bool aside_[side_count] = {false, false};
    GrabGesture grab_;
    std::vector<ObjectId> moved_;  // objects of the motion
    Vec3<double> centre_{};        // their common one when it began
    ObjectPreviews preview_;
    std::future<ObjectPreviews> coming_;  // the preview, being made
    std::optional<PlaceGesture> place_;
    std::optional<NozzleGesture> nozzle_;
    Side nozzle_side_ = right;
    double clogged_since_ = -1;                  // [s]; negative: it is not
    double now_ = 0;                             // of the newest frame [s]
    bool pinched_[side_count] = {false, false};  // in the frame before
    unsigned motions_ = 0;
    int history_ = -1;
};

}  // namespace knead
