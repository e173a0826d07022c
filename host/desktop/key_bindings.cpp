#include "host/desktop/key_bindings.h"

#include <sstream>
#include <stdexcept>

namespace knead {
namespace {

struct KeyBinding {
    Control control;
    Chord chord;
    bool is_character = false;  // typed by whatever keys the layout has it on
};

int key_of(const std::string& name)
{
    if (name.size() == 1) return name.front();
    if (name == "Space") return key_space;
    if (name == "Tab") return key_tab;
    if (name == "Delete") return key_delete;
    if (name == "Home") return key_home;
    if (name.size() >= 2 && name.size() <= 3 && name.front() == 'F') {
        const int number = std::stoi(name.substr(1));
        if (number >= 1 && number <= 12) return key_f1 + number - 1;
    }
    throw std::invalid_argument("no key is named " + name);
}

const std::vector<KeyBinding>& bindings()
{
    static const std::vector<KeyBinding> all = [] {
        std::vector<KeyBinding> made;
        for (const ControlRow& row : control_rows) {
            std::istringstream words(row.keys);
            for (std::string word; words >> word;)
                made.push_back({row.control, chord_of(word), word == "?"});
        }
        return made;
    }();
    return all;
}

// What a press changes the control to.
ControlValue next_value(const ControlState& one)
{
    if (const bool* on = std::get_if<bool>(&one.value)) return !*on;
    if (std::holds_alternative<std::string>(one.value)) return std::string();
    return std::monostate();
}

}  // namespace

Chord chord_of(const std::string& keys)
{
    Chord chord;
    std::string rest = keys;
    const auto takes = [&](const std::string& modifier) {
        if (rest.size() <= modifier.size() || rest.compare(0, modifier.size(), modifier) != 0)
            return false;
        rest.erase(0, modifier.size());
        return true;
    };
    while (true) {
        if (takes("Ctrl+"))
            chord.control = true;
        else if (takes("Shift+"))
            chord.shift = true;
        else if (takes("Alt+"))
            chord.alt = true;
        else
            break;
    }
    chord.key = key_of(rest);
    return chord;
}

std::vector<ControlEvent> pressed_controls(const InputState& input, const PanelModel& model)
{
    std::vector<ControlEvent> events;
    for (const KeyBinding& one : bindings()) {
        if (one.is_character ? !input.typed(one.chord.key) : !input.pressed(one.chord)) continue;
        if (const ControlState* const state = model.find({one.control, 0}))
            events.push_back({state->id, next_value(*state), 0});
    }
    return events;
}

}  // namespace knead
