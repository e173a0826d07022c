// The panel of the headset: where it stands, which finger presses it, and when it is drawn again.
// The main panel is beside the clay; undo and redo lie on the palm of the support hand.
#pragma once
#include <vector>

#include "host/ui/panel_controller.h"
#include "host/ui/panel_drawing.h"
#include "host/ui/panel_refresh.h"
#include "host/vr/finger_pointer.h"
#include "host/vr/panel_place.h"

namespace knead {

// Both hands and the head, in the frame of the hands.
struct PanelSurroundings {
    Vec3<float> head{};
    Hand hands[side_count];
    bool contact[side_count] = {false, false};  // touches clay
    bool busy[side_count] = {false, false};     // holds a tool, or carries
};

// Bounds of the surface in the simulation's frame [m]; empty if there is no surface.
Box3<double> clay_box(const LiveState& state);

class HeadsetPanel {
  public:
    static constexpr PanelSize size{0.4f, 0.4f}, palm_size{0.084f, 0.074f};  // [m]
    static constexpr float pixel = 0.00055f;                                 // [m]
    enum Id { main_panel, palm_panel };

    // Layout of the panel seen from `distance` [m], with capitals of at least a degree everywhere.
    static PanelDrawingOptions layout(float distance);
    // The part of the picture that the main panel shows.
    static TouchPanel main_at(const Joint<float>& pose, const PanelDrawingOptions& layout);

    // Shows the model of `of`, which must outlive this object.
    explicit HeadsetPanel(const PanelController& of) : control(of) {}

    // Null: no panel; frame() then does nothing.
    void set_drawing(PanelDrawing* to) { drawing = to, refresh.again(); }
    bool exists() const { return drawing != nullptr; }
    bool shows_times() const { return drawing && drawing->shows_times(); }

    // Places it beside the clay's box (simulation frame) [m], on the side that is set.
    void place(const Workplace& workplace, const Box3<double>& clay, const HandsOptions& hands);
    // Leaves it where it is before the head while the frame of the hands moves.
    void keep(const Workplace& before, const Workplace& after)
    {
        place_.pose = in_hands(after, in_headset_frame(before, place_.pose));
    }
    float distance() const { return place_.distance; }

    // Processes the fingers at `time` [s] (ascending); lays the panel out again if it has changed
    // or a finger is near. Returns the events. `period`: since the last frame [s].
    std::vector<ControlEvent> frame(const TimeGraph& times, const PanelSurroundings& of,
                                    double time, double period);
    // Whether it was laid out anew since the last call.
    bool take_changed() { return std::exchange(changed, false); }
    // What is shown, in the frame of the hands.
    const std::vector<TouchPanel>& shown() const { return panels; }
    const PanelPointer& pointer() const { return finger; }

  private:
    const PanelController& control;
    PanelDrawing* drawing = nullptr;
    PanelPlace place_;
    FingerPointer fingers;
    PalmStrip palm[side_count];
    PanelPointer finger;
    std::vector<TouchPanel> panels;
    PanelRefresh refresh;
    bool changed = false;
};

}  // namespace knead
