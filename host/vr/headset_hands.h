// The user's hands in a headset: what the simulation is given, what is drawn, and what is felt.
#pragma once
#include <optional>

#include "host/hands/filter.h"
#include "host/live/live_session.h"
#include "host/vr/cue_sound.h"
#include "host/vr/headset_view.h"

namespace knead {

// How well a hand is seen, for its opacity: it fades where it was lost, and comes back as it grows.
class HandFade {
  public:
    static constexpr double fading = 0.3;  // [s]
    static constexpr float faint = 0.35f;  // while it does not yet touch
    // `size`: the share of its radii that it touches with. Answers the opacity.
    float frame(double time, bool tracked, float size);

  private:
    float opacity = 0;
    double last = 0, lost = -1e30;  // [s]
};

// What a hand feels, made visible: its rim lights up green at contact, glows while clay yields to
// it and red while its blade cuts, and fades when nothing more is felt.
class HandCue {
  public:
    static constexpr double lasting = 0.25;  // [s]
    void show(Feel feel, double time);
    Vec3<float> glow(double time) const;  // linear

  private:
    double struck = -1e30, felt = -1e30;  // when last: contact began, something steady [s]
    Feel steady = Feel::nothing;
};

// Whether hands are tracked too seldom to shape clay: more than once within some seconds one was
// taken for a new hand because its frames lie too far apart (HandFilter::slow_restarts()).
class TrackingWatch {
  public:
    static constexpr double lasting = 3;  // [s]
    // A frame at `time` [s], after so many restarts in all.
    void frame(double time, long restarts);
    bool too_slow() const { return slow; }
    double rate() const;  // of the last frames [1/s]; 0: not known

  private:
    static constexpr int averaged = 8;   // frames
    double last = -1e30, interval = 0;   // [s]; 0: not known
    double restart[2] = {-1e30, -1e30};  // the last two [s]
    long known = 0;
    bool slow = false;
};

// One frame of both hands, in the frame of recordings.
HandFrame hand_frame(const HeadsetViews& sight, const Workplace& workplace, double time);

class HeadsetHands {
  public:
    explicit HeadsetHands(const HandsOptions& options) { set(options); }
    // Both hands open, and wholly seen.
    static HeadsetHands open(const HandsOptions& options);
    // The tools are others from now on; hands begin anew.
    void set(const HandsOptions& options);
    const HandsOptions& options() const { return by; }
    // The same hands are larger or smaller against the clay; they stay as they are tracked.
    void set_zoom(double zoom);

    // Hands as they are now, for the same filter that the simulation uses: what is drawn is what
    // touches. Times rise.
    void push(const HandFrame& frame);
    // Since the tools are these, see HandFilter.
    long slow_restarts() const { return stream->slow_restarts(); }
    // What to draw at the newest time, tool by tool.
    std::vector<HandLook> looks();
    // What each side does to clay: contact of its own that begins, then whether clay yields to it
    // or its blade cuts. Nothing where the state was felt already. looks() shows it from then on.
    void feel(const LiveState& state, Feel felt[side_count]);

  private:
    HandsOptions by;
    std::optional<HandStream> stream;  // in the frame of the hands
    HandFade fade[side_count];
    HandCue cue[side_count];
    HandFrame newest;
    bool touched[side_count] = {false, false};
    long felt_version = -1;  // of the state
};

// How strongly a controller vibrates, 0 to 1.
float strength_of(Feel feel);

}  // namespace knead
