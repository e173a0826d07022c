// Index fingers as the pointer of a picture whose parts are shown on panels in space. Independent
// of OpenGL and the simulation.
#pragma once
#include <optional>
#include <vector>

#include "host/hands/hands.h"

namespace knead {

// A panel, and the rectangle of the picture that it shows.
struct TouchPanel {
    int id = 0;  // the same from frame to frame
    // Of its centre, in the frame of the hands: x right, y up, z towards the user.
    Joint<float> pose{{1, 0, 0, 0}, {0, 0, 0}};
    float width = 0, height = 0;                                // [m]
    float x = 0, y = 0, picture_width = 0, picture_height = 0;  // from the upper left [pixels]
    bool touched_by[side_count] = {true, true};                 // sides whose finger it accepts
};

// Tip joint of an index finger in the frame of the hands [m].
struct FingerTip {
    Vec3<float> at{};
    bool tracked = false;
};

struct PanelPointer {
    // Position if not `inside`: outside all controls, so that a release triggers nothing [pixels].
    static constexpr float nowhere = -1e6f;

    bool inside = false;             // a finger hovers over a panel or presses it
    float x = nowhere, y = nowhere;  // from the upper left of the picture [pixels]
    bool down = false;
    // The press has ended in this frame without a release on the panel: the finger was lost,
    // jumped, slid off or went through, or the panel has gone.
    bool cancelled = false;
    float distance = 0;  // from the surface to the skin; negative: behind [m]. 0 unless `inside`
    int panel = -1;      // id; -1 unless `inside`
    Side side = left;    // of the finger, if `inside` or `cancelled`
};

// One finger owns the pointer at a time. A press begins when a finger that was in front crosses
// the surface within the panel, and ends when it is in front again. A finger that comes from
// behind or from the side, or that was lost or jumped, must first move in front. The other finger
// cannot press meanwhile.
class FingerPointer {
  public:
    static constexpr float finger = 0.007f;  // from the tip's joint to the skin [m]
    static constexpr float near = 0.05f;     // distance in front up to which a finger hovers [m]
    static constexpr float away = 0.012f;    // distance in front that ends a press [m]
    static constexpr float deep = 0.06f;     // distance behind that cancels a press [m]
    static constexpr float slack = 0.01f;    // distance beside a panel that ends a press [m]
    // The pointer stays at the first point of a press until the finger moves farther than this
    // along the surface, so that a poke does not drag [m].
    static constexpr float slip = 0.004f;

    // Call once per frame; `time` [s] ascends.
    PanelPointer frame(double time, const std::vector<TouchPanel>& panels,
                       const FingerTip (&tips)[side_count]);

  private:
    // A finger relative to a panel.
    struct Track {
        int panel;
        Side side;
        bool known = false;    // it was seen in the newest frame
        bool fresh = false;    // but not in the one before, or it jumped
        Vec3<float> at{};      // in the panel's frame
        bool armed = false;    // has been in front since it last crossed
        bool crossed = false;  // within the panel, in this frame
        float share = 0;       // of the frame, at which it crossed
        Vec3<float> hit{};     // where
    };
    struct Press {
        int panel;
        Side side;
        Vec3<float> begin{};  // first point, in the panel's frame
        bool slid = false;    // has moved farther than `slip`
        float x, y;           // newest position [pixels]
    };

    Track& track_of(int panel, Side side);
    void follow(Track& track, const TouchPanel& panel, const FingerTip& tip, double duration);
    PanelPointer go_on(const std::vector<TouchPanel>& panels);
    const Track* crossing() const;
    const Track* hovering(const std::vector<TouchPanel>& panels) const;

    std::vector<Track> tracks;
    std::optional<Press> press;
    int hover_panel = -1;  // of the pointer in the previous frame; -1: none
    Side hover_side = left;
    double last = -1e30;  // time of the previous frame [s]
};

}  // namespace knead
