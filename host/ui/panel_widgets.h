// Controls of the panel as items of Dear ImGui. Precondition of all functions: within
// ImGui::NewFrame() and Render().
#pragma once
#include <imgui.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "host/ui/panel_drawing.h"

namespace knead {

class PanelWidgets {
  public:
    explicit PanelWidgets(bool for_touch) : touch(for_touch) {}

    void begin_frame(double seconds);
    std::vector<ControlEvent> end_frame();
    bool moves() const { return holding || left_early; }

    // A control by the kind of its value, after the last one in the row where both fit.
    void control(const ControlState& one);
    // Where it is on the same row as a button before it, if it fits: width [pixels].
    void flow(float width);
    void end_row() { row_open = false; }
    void event(ControlId id, ControlValue value, unsigned drag = 0);
    void tooltip(const ControlState& one) const;
    // A row of a list, with any text: Dear ImGui takes "##" in a label for an id. True: pressed.
    // Precondition: an id is pushed.
    bool row(const std::string& text, bool chosen, ImGuiSelectableFlags flags = 0);
    bool list_open() const { return list_was_open; }  // of a choice, in the frame before
    // Whether a number is being typed.
    bool types_number() const { return typed_item != 0; }
    // Records where the last item is.
    void placed(ControlId id, int item = whole_control);
    std::optional<PanelRect> place_of(ControlId id, int item) const;

    // A button; with `held`, by a finger, it must be held. True: it is triggered.
    bool button(ControlId id, const char* label, bool held, float width = 0, bool lit = false);
    bool slider(const char* label, double& value, double low, double high, const char* format,
                ImGuiSliderFlags flags);

    static constexpr int whole_control = -1;
    const bool touch;
    int usual_item = whole_control;  // recorded for whole controls: another one where they repeat
    // Opens a dialog of the window for a control whose value is a path.
    std::function<void(Control)> open_dialog;
    // Region of lists that a finger opens [pixels].
    ImVec2 list_at{}, list_size{};
    int per_row = 3;  // buttons for a finger

  private:
    void choice(const ControlState& one);
    void touch_choice(const ControlState& one);
    void number(const ControlState& one);
    void whole(const ControlState& one);
    void text(const ControlState& one);
    float touch_width(int count) const;

    std::vector<ControlEvent> events;
    std::map<std::pair<ControlId, int>, PanelRect> places;
    double now = 0;         // [s]
    bool row_open = false;  // a button can follow on the row
    bool list_is_open = false, list_was_open = false;
    bool active = false;  // an item is pressed
    unsigned drag = 0;    // number of the last press
    // Range of the slider that is pressed: it does not follow a value that leaves it.
    ImGuiID dragged = 0;
    double drag_low = 0, drag_high = 0;
    // A number is applied when editing ends, not after each digit: 2e6 starts with 2.
    ImGuiID typed_item = 0;
    double typed_value = 0;
    // The held item that is pressed, or was released too early.
    ImGuiID held_item = 0, early_item = 0;
    double held_since = 0, early_at = -1e30;
    bool held_done = false, holding = false, left_early = false;
    std::map<ControlId, std::string> edited;  // texts being edited
};

}  // namespace knead
