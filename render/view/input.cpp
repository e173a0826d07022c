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

const std::map<std::string, int> key_names{
    {"space", key_space}, {"escape", key_escape},       {"enter", key_enter},
    {"tab", key_tab},     {"backspace", key_backspace}, {"delete", key_delete},
    {"right", key_right}, {"left", key_left},           {"down", key_down},
    {"up", key_up},       {"home", key_home},           {"end", key_end},
    {"f12", key_f12},     {"shift", key_shift},         {"control", key_control},
    {"alt", key_alt},     {"super", key_super}};
const std::map<std::string, int> button_names{
    {"left", button_left}, {"right", button_right}, {"middle", button_middle}};

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
        if (&names == &key_names && found.size() == 1 && std::isalnum((unsigned char)found[0]))
            return std::toupper((unsigned char)found[0]);
        refuse(expected, found);
    }
};

}  // namespace

void InputState::begin_frame()
{
    pressed_.clear(), pressed_alone_.clear(), text_.clear();
    for (std::vector<int>& one : pressed_control_) one.clear();
    clicked_ = {};
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
            if (!e.down) break;
            pressed_.push_back(e.code);
            // Checked at the press: both keys may be released by the end of the frame.
            if (!combining()) pressed_alone_.push_back(e.code);
            if (control() && !other_held()) pressed_control_[shift()].push_back(e.code);
            break;
        case InputEvent::wheel:
            wheel_ += e.y;
            break;
        case InputEvent::text:
            text_.push_back(e.code);
            break;
        case InputEvent::screenshot:
        case InputEvent::lose:
            break;
    }
}

bool InputState::pressed(int key) const
{
    return std::find(pressed_.begin(), pressed_.end(), key) != pressed_.end();
}

bool InputState::pressed_alone(int key) const
{
    return std::find(pressed_alone_.begin(), pressed_alone_.end(), key) != pressed_alone_.end();
}

bool InputState::pressed_control(int key, bool with_shift) const
{
    const std::vector<int>& all = pressed_control_[with_shift];
    return std::find(all.begin(), all.end(), key) != all.end();
}

bool InputState::other_held() const
{
    return held(key_alt) || held(key_right_alt) || held(key_super) || held(key_right_super);
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
        } else if (kind == "screenshot") {
            e.kind = InputEvent::screenshot;
            e.file = line.word("a file");
            add(e);
        } else if (kind == "lose") {
            e.kind = InputEvent::lose;
            add(e);
        } else {
            line.refuse("move, button, key, wheel, text, screenshot or lose", kind);
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
