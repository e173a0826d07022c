// Mouse and keyboard input, independent of a window: from a user or a script.
#pragma once
#include <array>
#include <string>
#include <vector>

namespace knead {

// Key codes of GLFW: letters and digits are their upper-case ASCII codes.
enum Key : int {
    key_space = 32,
    key_escape = 256,
    key_enter,
    key_tab,
    key_backspace,
    key_delete = 261,
    key_right,
    key_left,
    key_down,
    key_up,
    key_home = 268,
    key_end,
    key_f12 = 301,
    key_shift = 340,
    key_control,
    key_alt,
    key_super,
    key_right_shift,
    key_right_control,
    key_right_alt,
    key_right_super,
    key_count = 349
};
enum MouseButton : int { button_left, button_right, button_middle, button_count };

struct InputEvent {
    enum Kind { move, button, key, wheel, text, screenshot, lose } kind;
    double x = 0, y = 0;  // move: pixels from the upper left; wheel: steps, away from the user
    int code = 0;         // of a button or key; text: a Unicode character
    bool down = false;    // of a button or key
    std::string file{};   // screenshot
};

// Keys and buttons held down, and events of the current frame.
class InputState {
  public:
    void begin_frame();  // clears the events of the last frame
    void take(const InputEvent& event);

    bool held(Key key) const { return in(key) && keys_[std::size_t(key)]; }
    bool held(MouseButton button) const { return buttons_[std::size_t(button)]; }
    bool pressed(int key) const;  // since begin_frame(), even if released again
    // The same, only without control, alt or super.
    bool pressed_alone(int key) const;
    // The same, with control, with or without shift as given, and without alt and super.
    bool pressed_control(int key, bool with_shift = false) const;
    bool held_alone(Key key) const { return held(key) && !combining(); }
    bool shift() const { return held(key_shift) || held(key_right_shift); }
    bool control() const { return held(key_control) || held(key_right_control); }
    const std::vector<int>& typed() const { return text_; }  // Unicode characters
    double x() const { return x_; }
    double y() const { return y_; }
    double moved_x() const { return moved_x_; }
    double moved_y() const { return moved_y_; }
    double wheel() const { return wheel_; }
    bool clicked(MouseButton button) const { return clicked_[std::size_t(button)]; }

  private:
    static bool in(int key) { return key >= 0 && key < key_count; }
    bool combining() const { return control() || other_held(); }
    bool other_held() const;  // alt, super

    std::array<bool, key_count> keys_{};
    std::array<bool, button_count> buttons_{}, clicked_{};
    std::vector<int> pressed_, pressed_alone_, pressed_control_[2], text_;  // [with shift]
    double x_ = 0, y_ = 0, moved_x_ = 0, moved_y_ = 0, wheel_ = 0;
    bool placed_ = false;  // the mouse position is known
};

// Timed events: lines of "TIME EVENT" sorted by time [s]; # begins a comment.
//     move X Y | button left|right|middle down|up | key NAME down|up|tap | wheel STEPS |
//     text WORD | screenshot FILE | lose
// NAME is a letter, a digit, or space, escape, enter, tab, left, ...; `lose` simulates the loss of
// the OpenGL context.
class InputScript {
  public:
    InputScript() = default;
    // Throws InputError with file, line, expected and found.
    static InputScript read(const std::string& path);
    static InputScript parse(const std::string& text, const std::string& path);

    // Returns the events up to `time` [s] not returned before.
    std::vector<InputEvent> due(double time);
    bool over() const { return next_ == events_.size(); }

  private:
    struct Timed {
        double time;
        InputEvent event;
    };
    std::vector<Timed> events_;
    std::size_t next_ = 0;
};

}  // namespace knead
