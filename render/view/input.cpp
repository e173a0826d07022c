#include "render/view/input.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <map>
#include <sstream>

#include "host/base/errors.h"

namespace knead {
namespace {

const std::map<std::string, int> key_names{{"space", key_space},
                                           {"escape", key_escape},
                                           {"enter", key_enter},
                                           {"tab", key_tab},
                                           {"backspace", key_backspace},
                                           {"insert", key_insert},
                                           {"delete", key_delete},
                                           {"right", key_right},
                                           {"left", key_left},
                                           {"down", key_down},
                                           {"up", key_up},
                                           {"page_up", key_page_up},
                                           {"page_down", key_page_down},
                                           {"home", key_home},
                                           {"end", key_end},
                                           {"keypad_enter", key_keypad_enter},
                                           {"shift", key_shift},
                                           {"control", key_control},
                                           {"alt", key_alt},
                                           {"super", key_super},
                                           {"right_shift", key_right_shift},
                                           {"right_control", key_right_control},
                                           {"right_alt", key_right_alt},
                                           {"right_super", key_right_super},
                                           {"comma", ','},
                                           {"period", '.'},
                                           {"minus", '-'},
                                           {"equal", '='},
                                           {"slash", '/'},
                                           {"number_sign", '#'},
                                           {"f1", key_f1},
                                           {"f2", key_f1 + 1},
                                           {"f3", key_f1 + 2},
                                           {"f4", key_f1 + 3},
                                           {"f5", key_f1 + 4},
                                           {"f6", key_f1 + 5},
                                           {"f7", key_f1 + 6},
                                           {"f8", key_f1 + 7},
                                           {"f9", key_f1 + 8},
                                           {"f10", key_f1 + 9},
                                           {"f11", key_f1 + 10},
                                           {"f12", key_f12}};
const std::map<std::string, int> button_names{
    {"left", button_left}, {"right", button_right}, {"middle", button_middle}};

// Of ASCII, other than the space.
bool is_graphic(char c) { return c > ' ' && c < 0x7f; }

struct Line {
    std::istringstream words;
    std::string path;
    int number;

    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const
    {
        throw InputError(fmt::format("{}:{}: expected {}, found \"{}\"", path, number, expected,
                                     found.substr(0, 60)));
    }
    std::string word(const std::string& expected)
    {
        std::string found;
        if (!(words >> found)) refuse(expected, "the line's end");
        return found;
    }
    double number_of(const std::string& expected)
    {
        const std::string found = word(expected);
        try {
            std::size_t end = 0;
            const double value = std::stod(found, &end);
            if (end == found.size() && value > -1e6 && value < 1e6) return value;
        } catch (const std::exception&) {
        }
        refuse(expected, found);
    }
    int named(const std::map<std::string, int>& names, const std::string& expected)
    {
        const std::string found = word(expected);
        const auto at = names.find(found);
        if (at != names.end()) return at->second;
        if (&names == &key_names && found.size() == 1 && is_graphic(found[0]))
            return std::toupper((unsigned char)found[0]);
        refuse(expected, found);
    }
    // Without spaces at both ends.
    std::string rest(const std::string& expected)
    {
        std::string found;
        std::getline(words >> std::ws, found);
        found.erase(found.find_last_not_of(" \t\r") + 1);
        if (found.empty()) refuse(expected, "the line's end");
        return found;
    }
};

}  // namespace

int key_code(int key, const char* name)
{
    // Digits are used as a row, whatever is printed above them. The keypad, beyond ASCII, types
    // digits as well.
    const bool by_place = key > 0x7f || key == key_space || (key >= '0' && key <= '9');
    if (by_place || !name || !is_graphic(name[0]) || name[1] != 0) return key;
    return std::toupper((unsigned char)name[0]);
}

int KeyCodes::press(int scancode, int key, const char* name)
{
    return down_[scancode] = key_code(key, name);
}

int KeyCodes::release(int scancode, int key, const char* name)
{
    const auto pressed = down_.extract(scancode);
    return pressed ? pressed.mapped() : key_code(key, name);
}

void InputState::begin_frame()
{
    pressed_.clear(), text_.clear(), dropped_.clear();
    clicked_ = {};
    close_ = false;
    moved_x_ = moved_y_ = wheel_ = 0;
}

void InputState::take(const InputEvent& e)
{
    switch (e.kind) {
        case InputEvent::move:
            if (placed_) moved_x_ += e.x - x_, moved_y_ += e.y - y_;
            x_ = e.x, y_ = e.y;
            placed_ = true;
            break;
        case InputEvent::button:
            if (e.code < 0 || e.code >= button_count) return;
            buttons_[std::size_t(e.code)] = e.down;
            if (e.down) clicked_[std::size_t(e.code)] = true;
            break;
        case InputEvent::key:
            if (!in(e.code)) return;
            keys_[std::size_t(e.code)] = e.down;
            // Modifiers at the press: all keys may be released by the end of the frame.
            if (e.down) pressed_.push_back({{e.code, control(), shift(), alt()}, super()});
            break;
        case InputEvent::wheel:
            wheel_ += e.y;
            break;
        case InputEvent::text:
            text_.push_back(e.code);
            break;
        case InputEvent::enter:
        case InputEvent::leave:
            inside_ = e.kind == InputEvent::enter;
            break;
        case InputEvent::unfocus:
            keys_ = {}, buttons_ = {};
            break;
        case InputEvent::drop:
            dropped_.push_back(e.file);
            break;
        case InputEvent::close:
            close_ = true;
            break;
        case InputEvent::screenshot:
        case InputEvent::lose:
            break;
    }
}

bool InputState::went_down(int key) const
{
    return std::any_of(pressed_.begin(), pressed_.end(),
                       [&](const Press& p) { return p.chord.key == key; });
}

bool InputState::pressed(const Chord& c) const
{
    return std::any_of(pressed_.begin(), pressed_.end(), [&](const Press& p) {
        return p.chord.key == c.key && p.chord.control == c.control && p.chord.shift == c.shift &&
               p.chord.alt == c.alt && !p.super;
    });
}

bool InputState::typed(int character) const
{
    return std::find(text_.begin(), text_.end(), character) != text_.end();
}

InputScript InputScript::read(const std::string& path)
{
    std::ifstream in(path, std::ios::binary);
    if (!in) throw InputError(path + ": the script cannot be opened");
    std::ostringstream text;
    text << in.rdbuf();
    return parse(text.str(), path);
}

InputScript InputScript::parse(const std::string& text, const std::string& path)
{
    InputScript script;
    std::istringstream lines(text);
    std::string of;
    for (int number = 1; std::getline(lines, of); ++number) {
        of = of.substr(0, of.find('#'));
        if (of.find_first_not_of(" \t\r") == std::string::npos) continue;
        Line line{std::istringstream(of), path, number};
        const double time = line.number_of("a time in seconds");
        const double before = script.events_.empty() ? 0 : script.events_.back().time;
        if (!(time >= before)) line.refuse("a time that is not before the last", of);
        const auto add = [&](const InputEvent& event) { script.events_.push_back({time, event}); };
        const std::string kind = line.word("an event");
        InputEvent e{};
        if (kind == "move") {
            e.kind = InputEvent::move;
            e.x = line.number_of("x in pixels"), e.y = line.number_of("y in pixels");
            add(e);
        } else if (kind == "wheel") {
            e.kind = InputEvent::wheel;
            e.y = line.number_of("a number of steps");
            add(e);
        } else if (kind == "button" || kind == "key") {
            const bool key = kind == "key";
            e.kind = key ? InputEvent::key : InputEvent::button;
            e.code = key ? line.named(key_names, "a key") : line.named(button_names, "a button");
            const std::string way = line.word("down, up or tap");
            if (way != "down" && way != "up" && way != "tap") line.refuse("down, up or tap", way);
            e.down = way != "up";
            add(e);
            if (way == "tap") e.down = false, add(e);
        } else if (kind == "text") {
            e.kind = InputEvent::text;
            for (const char letter : line.word("a word")) e.code = (unsigned char)letter, add(e);
        } else if (kind == "drop") {
            e.kind = InputEvent::drop;
            e.file = line.rest("a file");
            add(e);
        } else if (kind == "close") {
            e.kind = InputEvent::close;
            add(e);
        } else if (kind == "screenshot") {
            e.kind = InputEvent::screenshot;
            e.file = line.word("a file");
            add(e);
        } else if (kind == "lose") {
            e.kind = InputEvent::lose;
            add(e);
        } else {
            line.refuse("move, button, key, wheel, text, drop, close, screenshot or lose", kind);
        }
        std::string rest;
        if (line.words >> rest) line.refuse("the line's end", rest);
    }
    return script;
}

std::vector<InputEvent> InputScript::due(double time)
{
    std::vector<InputEvent> found;
    while (next_ < events_.size() && events_[next_].time <= time + 1e-9)
        found.push_back(events_[next_++].event);
    return found;
}

}  // namespace knead
