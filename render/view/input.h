// Mouse and keyboard input, independent of a window: from a user or a script.
#pragma once
#include <array>
#include <map>
#include <string>
#include <vector>

namespace knead {

// Key codes of GLFW: letters, digits and punctuation are their ASCII codes, letters in upper case.
enum Key : int {
    key_space = 32,
    key_escape = 256,
    key_enter,
    key_tab,
    key_backspace,
    key_insert,
    key_delete,
    key_right,
    key_left,
    key_down,
    key_up,
    key_page_up,
    key_page_down,
    key_home,
    key_end,
    key_f1 = 290,  // F2 to F12 follow
    key_f12 = 301,
    key_keypad_enter = 335,
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

// Code of a key: letters and punctuation as printed on the user's keyboard, all others by their
// place. `key`: GLFW's, the code of a US keyboard. `name`: what the key types without modifiers,
// UTF-8; null: none. Layouts without Latin letters have those of the US keyboard.
int key_code(int key, const char* name);

// Codes of the keys that are down, by scancode. A key is released under the code of its press, even
// if the layout has changed between.
class KeyCodes {
  public:
    int press(int scancode, int key, const char* name);
    int release(int scancode, int key, const char* name);
    void clear() { down_.clear(); }

  private:
    std::map<int, int> down_;
};

struct InputEvent {
    // enter, leave: of the cursor into and out of the window; unfocus: the window loses the
    // keyboard; drop: a file dragged into the window; close: the user asks to close it.
    enum Kind {
        move,
        button,
        key,
        wheel,
        text,
        enter,
        leave,
        unfocus,
        drop,
        close,
        screenshot,
        lose
    } kind;
    double x = 0, y = 0;  // move: pixels from the upper left; wheel: steps, away from the user
    int code = 0;         // of a button or key; text: a Unicode character
    bool down = false;    // of a button or key
    std::string file{};   // drop, screenshot
};

// A key with modifiers, left or right.
struct Chord {
    int key = 0;
    bool control = false, shift = false, alt = false;
};

// Keys and buttons held down, and events of the current frame.
class InputState {
  public:
    void begin_frame();  // clears the events of the last frame
    void take(const InputEvent& event);

    bool held(Key key) const { return in(key) && keys_[std::size_t(key)]; }
    bool held(MouseButton button) const { return buttons_[std::size_t(button)]; }
    // Since begin_frame(), even if released again; with any modifiers.
    bool went_down(int key) const;
    // The same, with exactly these modifiers at the press, and without super.
    bool pressed(const Chord& chord) const;
    // Without control, alt and super.
    bool held_alone(Key key) const { return held(key) && !combining(); }
    bool shift() const { return held(key_shift) || held(key_right_shift); }
    bool control() const { return held(key_control) || held(key_right_control); }
    bool alt() const { return held(key_alt) || held(key_right_alt); }
    const std::vector<int>& typed() const { return text_; }  // Unicode characters
    // The character, by whatever keys it has in the user's layout: for '?' and the like.
    bool typed(int character) const;
    bool inside() const { return inside_; }  // the cursor, in the window
    const std::vector<std::string>& dropped() const { return dropped_; }  // files
    bool close_requested() const { return close_; }
    double x() const { return x_; }
    double y() const { return y_; }
    double moved_x() const { return moved_x_; }
    double moved_y() const { return moved_y_; }
    double wheel() const { return wheel_; }
    bool clicked(MouseButton button) const { return clicked_[std::size_t(button)]; }

  private:
    static bool in(int key) { return key >= 0 && key < key_count; }
    bool super() const { return held(key_super) || held(key_right_super); }
    bool combining() const { return control() || alt() || super(); }

    struct Press {
        Chord chord;
        bool super;
    };
    std::array<bool, key_count> keys_{};
    std::array<bool, button_count> buttons_{}, clicked_{};
    std::vector<Press> pressed_;
    std::vector<int> text_;
    std::vector<std::string> dropped_;
    double x_ = 0, y_ = 0, moved_x_ = 0, moved_y_ = 0, wheel_ = 0;
    bool placed_ = false;  // the mouse position is known
    bool inside_ = true, close_ = false;
};

// Timed events: lines of "TIME EVENT" sorted by time [s]; # begins a comment.
//     move X Y | button left|right|middle down|up | key NAME down|up|tap | wheel STEPS |
//     text WORD | drop FILE | close | screenshot FILE | lose
// NAME is a letter, a digit, a punctuation character, or space, escape, enter, tab, left, f1, ...;
// the FILE that is dropped is the rest of the line; `close` asks to close the window, `lose`
// simulates the loss of the OpenGL context.
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
