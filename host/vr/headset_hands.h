// The user's hands in a headset: input to the simulation, appearance, feedback.
#pragma once
#include <optional>

#include "host/hands/filter.h"
#include "host/live/live_session.h"
#include "host/vr/cue_sound.h"
#include "host/vr/headset_view.h"

namespace knead {

// Opacity of a hand: fades out when tracking is lost, fades in as the tool grows back.
class HandFade {
  public:
    static constexpr double fading = 0.3;  // [s]
    static constexpr float faint = 0.35f;  // opacity while it is not active yet
    // `size`: share of its full radii. Returns the opacity, 0 to 1.
    float frame(double time, bool tracked, float size);

  private:
    float opacity = 0;
    double last = 0, lost = -1e30;  // [s]
};

// Visible feedback: the rim of a hand lights up green at contact, glows while clay yields, red
// while its blade cuts, and fades afterwards.
class HandCue {
  public:
    static constexpr double lasting = 0.25;  // [s]
    void show(Feel feel, double time);
    Vec3<float> glow(double time) const;  // linear

  private:
    double struck = -1e30, felt = -1e30;  // last contact, last steady feedback [s]
    Feel steady = Feel::nothing;
};

// Detects tracking that is too slow for shaping: within `lasting` the hand filter restarted at
// least twice because frames were too far apart (HandFilter::slow_restarts()).
class TrackingWatch {
  public:
    static constexpr double lasting = 3;  // [s]
    // Call for each frame with its time [s] and the total number of restarts.
    void frame(double time, long restarts);
    bool too_slow() const { return slow; }
    double rate() const;  // of the last frames [1/s]; 0: unknown

  private:
    static constexpr int averaged = 8;   // frames
    double last = -1e30, interval = 0;   // [s]; 0: unknown
    double restart[2] = {-1e30, -1e30};  // times of the last two [s]
    long known = 0;
    bool slow = false;
};

// One frame of both hands, in the frame of recordings.
HandFrame hand_frame(const HeadsetViews& views, const Workplace& workplace, double time);

class HeadsetHands {
  public:
    explicit HeadsetHands(const HandsOptions& options) { set(options); }
    // Both hands open and opaque.
    static HeadsetHands open(const HandsOptions& options);
    // Replaces the tools and restarts the filter. Throws for an unknown tool.
    void set(const HandsOptions& options);
    const HandsOptions& options() const { return by; }
    // Changes the scale of hands relative to clay; keeps the filter.
    void set_zoom(double zoom);

    // Pushes tracked hands, in ascending order of time, through the filter that the simulation
    // uses, so that hands are drawn where they touch.
    void push(const HandFrame& frame);
    // Since the last set(); see HandFilter.
    long slow_restarts() const { return stream->slow_restarts(); }
    // Hands to draw at the newest time, one per tool.
    std::vector<HandLook> looks();
    // Feedback per side: the beginning of contact, then yielding or cutting. Nothing if the state
    // was evaluated before. Also updates the glow of looks().
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
