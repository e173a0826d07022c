// The panel, drawn by Dear ImGui: in the window as movable panels with a menu, or with large items
// for a finger, into a picture that the headset shows. Both lay out the same model and return the
// same events.
#pragma once
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/ui/panel_model.h"
#include "host/ui/time_graph.h"

namespace knead {

enum class PanelKey {
    tab,
    backspace,
    remove,
    enter,
    escape,
    left,
    right,
    up,
    down,
    home,
    end,
    a,
    c,
    v,
    x,
    y,
    z
};
constexpr std::size_t panel_key_count = std::size_t(PanelKey::z) + 1;

// Input since the last frame.
struct PanelInput {
    double seconds = 1.0 / 60;   // since the last frame
    bool pointer = false;        // whether there is a pointer, at x, y
    float x = 0, y = 0;          // [pixels] from the upper left
    std::array<bool, 3> down{};  // left, right, middle button; a finger: the first
    float wheel = 0;             // away from the user
    bool control = false, shift = false;
    std::array<bool, panel_key_count> keys{};  // held, or pressed since the last frame
    std::vector<int> typed{};                  // Unicode characters
};

// From the upper left [pixels].
struct PanelRect {
    float x = 0, y = 0, width = 0, height = 0;
    bool holds(float px, float py) const
    {
        return px >= x && px < x + width && py >= y && py < y + height;
    }
};

struct PanelDrawingOptions {
    float scale = 1;  // content scale of the display; 2: twice the pixels per length
    // Items for a finger, in a picture of this size with capitals of this height [pixels]; the
    // window's layout otherwise.
    bool touch = false;
    int width = 0, height = 0;
    float capital = 20;
    int palm_width = 0, palm_height = 0;  // of the strip of the palm, below the picture
    bool gl = true;                       // false: layout only
    // Clipboard functions of the window; null: no clipboard.
    std::function<std::string()> clipboard{};
    std::function<void(const std::string&)> set_clipboard{};
};

constexpr const char* no_panel =
    "this build has no panel: Dear ImGui (in Debian libimgui-dev) was not found";

class PanelDrawing {
  public:
    static constexpr double held_for = 1;  // time to hold what discards work, by a finger [s]

    // Precondition of this and all functions, with `gl`: the context is current. Null: the program
    // was built without Dear ImGui. Throws ResourceError if OpenGL refuses.
    static std::unique_ptr<PanelDrawing> open(const PanelDrawingOptions& options);
    virtual ~PanelDrawing() = default;

    // Lays the panel out in a picture of this size [pixels], and returns what the input does.
    virtual std::vector<ControlEvent> frame(const PanelModel& model, const TimeGraph& times,
                                            const PanelInput& input, int width, int height) = 0;
    // Draws the last frame over the framebuffer (GL name; 0: the window's).
    virtual void draw(unsigned framebuffer) = 0;

    // Of the last frame: whether the panel uses the mouse; whether a text field uses the keys.
    virtual bool mouse_taken() const = 0;
    virtual bool keys_taken() const = 0;
    // Whether a list, question or dialog is open that Escape closes.
    virtual bool popup_open() const = 0;
    // Whether the next frame may differ even without input: an item is held, a caret blinks.
    virtual bool moves() const = 0;
    // Whether times are shown, which change in every frame.
    virtual bool shows_times() const = 0;
    // Columns covered at the left edge [pixels].
    virtual int covered() const = 0;
    // Opens the dialog of open, save_as or export_file; begins to edit the name (rename).
    virtual void begin(Control control) = 0;
    // Where the last frame has a control. `item`: an item of its open list, or on_palm_item; -1:
    // the whole control.
    static constexpr int on_palm_item = -4;
    virtual std::optional<PanelRect> place_of(ControlId id, int item = -1) const = 0;
    // Height of a capital [pixels].
    virtual float capital() const = 0;
    // Size of the picture with the strip of the palm [pixels]; with touch only.
    virtual int picture_width() const = 0;
    virtual int picture_height() const = 0;
};

}  // namespace knead
