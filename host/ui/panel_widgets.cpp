#include "host/ui/panel_widgets.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace knead {
namespace {

constexpr double hint = 2;  // duration of the hint that an item must be held [s]

// Bounded, because ImGui asserts on a text that does not fit its buffer.
constexpr std::size_t longest_text = 250;

const char* text_of_switch(const ControlState& one)
{
    if (one.id.control == Control::pause) return std::get<bool>(one.value) ? "Play" : "Pause";
    return one.label.c_str();
}

// "1.2 MPa". A unit that begins with another letter than Pa keeps its number.
std::string text_of(double value, const std::string& unit)
{
    if (unit.rfind("Pa", 0) == 0 && std::abs(value) >= 1e4) {
        const bool mega = std::abs(value) >= 1e6;
        return fmt::format("{:.3g} {}{}", value * (mega ? 1e-6 : 1e-3), mega ? 'M' : 'k', unit);
    }
    return unit.empty() ? fmt::format("{:.4g}", value) : fmt::format("{:.4g} {}", value, unit);
}

}  // namespace

void PanelWidgets::begin_frame(double seconds)
{
    now += seconds;
    events.clear(), places.clear();
    row_open = holding = false;
    list_was_open = std::exchange(list_is_open, false);
    left_early = now - early_at < hint;
    if (!ImGui::IsAnyItemActive()) dragged = 0;
}

std::vector<ControlEvent> PanelWidgets::end_frame()
{
    const bool pressed = ImGui::IsAnyItemActive();
    if (pressed && !active) ++drag;
    active = pressed;
    for (ControlEvent& one : events)
        if (one.drag) one.drag = drag;
    if (!pressed) held_item = 0;
    return std::exchange(events, {});
}

void PanelWidgets::event(ControlId id, ControlValue value, unsigned of_drag)
{
    events.push_back({id, std::move(value), of_drag});
}

void PanelWidgets::placed(ControlId id, int item)
{
    const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
    if (!ImGui::IsItemVisible()) return;
    if (item == whole_control) item = usual_item;
    places[{id, item}] = {low.x, low.y, high.x - low.x, high.y - low.y};
}

std::optional<PanelRect> PanelWidgets::place_of(ControlId id, int item) const
{
    const auto at = places.find({id, item});
    return at == places.end() ? std::nullopt : std::optional(at->second);
}

void PanelWidgets::flow(float width)
{
    if (row_open) {
        const float right = ImGui::GetItemRectMax().x + ImGui::GetStyle().ItemSpacing.x + width;
        const float end = ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
        if (right <= end + 0.5f) ImGui::SameLine();
    }
    row_open = true;
}

float PanelWidgets::touch_width(int count) const
{
    const float space = ImGui::GetStyle().ItemSpacing.x;
    return std::floor((ImGui::GetWindowContentRegionMax().x - ImGui::GetWindowContentRegionMin().x -
                       space * float(count - 1)) /
                      float(count));
}

void PanelWidgets::tooltip(const ControlState& one) const
{
    if (touch || !ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) return;
    const ControlRow& row = one.row();
    const std::string& text = one.why_not;
    // Also over an item that is greyed.
    ImGui::PushStyleVar(ImGuiStyleVar_Alpha, 1);
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(22 * ImGui::GetFontSize());
    if (!text.empty()) ImGui::TextUnformatted(fmt::format("Not available: {}", text).c_str());
    ImGui::TextUnformatted(row.help);
    if (*row.keys) ImGui::TextDisabled("%s", row.keys);
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
    ImGui::PopStyleVar();
}

bool PanelWidgets::row(const std::string& text, bool chosen, ImGuiSelectableFlags flags)
{
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const ImVec2 size = ImGui::CalcTextSize(text.c_str(), nullptr, false);
    const float wide = std::max(size.x, ImGui::GetContentRegionAvail().x);
    const bool pressed = ImGui::Selectable("###row", chosen, flags, {wide, 0});
    ImGui::GetWindowDrawList()->AddText(at, ImGui::GetColorU32(ImGuiCol_Text), text.c_str());
    return pressed;
}

bool PanelWidgets::button(ControlId id, const char* label, bool held, float width, bool lit)
{
    ImGui::PushID(int(id.control)), ImGui::PushID(id.index);
    const ImGuiID item = ImGui::GetID("button");
    const bool too_early = left_early && early_item == item;
    const bool waits = held_item == item && !held_done;
    const std::string text =
        (held && (waits || too_early) ? std::string("hold for 1 s") : std::string(label)) +
        "###button";
    if (lit) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetColorU32(ImGuiCol_ButtonActive));
    bool done = ImGui::Button(text.c_str(), {width, 0});
    if (lit) ImGui::PopStyleColor();
    placed(id);
    if (held && touch) {
        done = false;
        if (ImGui::IsItemActivated()) held_item = item, held_since = now, held_done = false;
        const bool inside = ImGui::IsItemActive() && ImGui::IsItemHovered();
        if (held_item == item && !held_done) {
            if (!inside) {
                held_item = 0, early_item = item, early_at = now;
            } else {
                holding = true;
                const float share =
                    float(std::min(1.0, (now - held_since) / PanelDrawing::held_for));
                const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
                ImGui::GetWindowDrawList()->AddRectFilled(
                    {low.x, high.y - 0.2f * (high.y - low.y)},
                    {low.x + share * (high.x - low.x), high.y}, IM_COL32(214, 84, 60, 255));
                done = share >= 1;
                held_done = done;
            }
        }
    }
    ImGui::PopID(), ImGui::PopID();
    return done;
}

bool PanelWidgets::slider(const char* label, double& value, double low, double high,
                          const char* format, ImGuiSliderFlags flags)
{
    const ImGuiID item = ImGui::GetID(label);
    if (dragged == item) low = drag_low, high = drag_high;
    double next = typed_item == item ? typed_value : value;
    ImGui::SliderScalar(label, ImGuiDataType_Double, &next, &low, &high, format, flags);
    if (ImGui::IsItemActivated()) dragged = item, drag_low = low, drag_high = high;
    if (ImGui::IsItemActive() && ImGui::GetIO().WantTextInput) {
        typed_item = item, typed_value = next;
        return false;
    }
    if (typed_item == item) typed_item = 0;
    if (next == value || !std::isfinite(next)) return false;
    value = next;
    return true;
}

void PanelWidgets::number(const ControlState& one)
{
    end_row();
    double value = std::get<double>(one.value);
    ImGuiSliderFlags flags = one.logarithmic ? ImGuiSliderFlags_Logarithmic : 0;
    // While a number is typed, without a prefix. Otherwise the format has no number.
    const char* const label = touch ? "##slider" : one.label.c_str();
    const bool types = ImGui::GetIO().KeyCtrl || typed_item == ImGui::GetID(label);
    const std::string shown = touch   ? fmt::format("{}  {}", one.label, text_of(value, one.unit))
                              : types ? "%.6g " + one.unit
                                      : text_of(value, one.unit);
    if (touch) flags |= ImGuiSliderFlags_NoInput;
    ImGui::PushItemWidth(touch ? touch_width(1) : 0.56f * ImGui::GetWindowContentRegionMax().x);
    if (slider(label, value, one.low, one.high, shown.c_str(), flags)) event(one.id, value, 1);
    placed(one.id);
    // The label is no part of the slider.
    if (const auto at = places.find({one.id, usual_item}); at != places.end())
        at->second.width = ImGui::CalcItemWidth();
    ImGui::PopItemWidth();
    tooltip(one);
}

void PanelWidgets::whole(const ControlState& one)
{
    end_row();
    const int now_at = std::get<int>(one.value);
    const auto moved = [&](int way) {
        // A number between two steps goes to one of them first.
        const int below = now_at / one.step * one.step;
        const int to = way > 0 ? below + one.step : below < now_at ? below : now_at - one.step;
        return std::clamp(to, int(one.low), int(one.high));
    };
    const bool held = one.row().discards;
    const float side = touch ? touch_width(4) : ImGui::GetFrameHeight();
    const float between = touch ? touch_width(4) * 2 + ImGui::GetStyle().ItemSpacing.x : 0;
    for (const int way : {-1, 1}) {
        ImGui::PushID(way);
        if (button(one.id, way < 0 ? "-" : "+", held, side) && moved(way) != now_at)
            event(one.id, moved(way));
        placed(one.id, way < 0 ? 0 : 1);
        ImGui::PopID();
        tooltip(one);
        if (way > 0) continue;
        ImGui::SameLine();
        const std::string text =
            touch ? fmt::format("{}: {}", one.label, now_at) : fmt::format("{}", now_at);
        const float wide = touch ? between : 3 * ImGui::GetFontSize();
        const float start = ImGui::GetCursorPosX();
        ImGui::AlignTextToFramePadding();
        ImGui::SetCursorPosX(start +
                             std::max(0.f, (wide - ImGui::CalcTextSize(text.c_str()).x) / 2));
        ImGui::TextUnformatted(text.c_str());
        ImGui::SameLine();
        ImGui::SetCursorPosX(start + wide + ImGui::GetStyle().ItemSpacing.x);
    }
    if (touch) return;
    ImGui::SameLine();
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(one.label.c_str());
}

void PanelWidgets::choice(const ControlState& one)
{
    if (touch) return touch_choice(one);
    end_row();
    const int now_at = std::get<int>(one.value);
    const bool known = now_at >= 0 && std::size_t(now_at) < one.choices.size();
    const bool open = ImGui::BeginCombo(one.label.c_str(),
                                        known ? one.choices[std::size_t(now_at)].c_str() : "-");
    placed(one.id);
    if (open) {
        list_is_open = true;
        for (int i = 0; i < int(one.choices.size()); ++i) {
            ImGui::PushID(i);  // names need not be unique
            if (row(one.choices[std::size_t(i)], i == now_at)) event(one.id, i);
            placed(one.id, i);
            ImGui::PopID();
        }
        if (ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false))
            ImGui::CloseCurrentPopup();
        ImGui::EndCombo();
    } else {
        tooltip(one);
    }
    if (!one.note.empty()) ImGui::TextDisabled("%s", one.note.c_str());
}

// A list over the whole panel, with items for a finger.
void PanelWidgets::touch_choice(const ControlState& one)
{
    end_row();
    const int now_at = std::get<int>(one.value);
    const bool known = now_at >= 0 && std::size_t(now_at) < one.choices.size();
    const std::string text =
        fmt::format("{}: {}{}", one.label, known ? one.choices[std::size_t(now_at)] : "-",
                    one.note.empty() ? "" : " (" + one.note + ")");
    if (button(one.id, text.c_str(), false, touch_width(1))) ImGui::OpenPopup("list");
    ImGui::SetNextWindowPos(list_at), ImGui::SetNextWindowSize(list_size);
    if (!ImGui::BeginPopupModal("list", nullptr,
                                ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove))
        return;
    // All of them fit, with the button below.
    const float line = ImGui::GetFrameHeightWithSpacing();
    const int lines =
        std::max(1, int((list_size.y - 2 * ImGui::GetStyle().WindowPadding.y) / line) - 1);
    const int columns = std::max(2, (int(one.choices.size()) + lines - 1) / lines);
    const float wide = touch_width(columns);
    for (int i = 0; i < int(one.choices.size()); ++i) {
        if (i % columns) ImGui::SameLine();
        ImGui::PushID(i);
        if (ImGui::Button(one.choices[std::size_t(i)].c_str(), {wide, 0})) {
            event(one.id, i);
            ImGui::CloseCurrentPopup();
        }
        placed(one.id, i);
        ImGui::PopID();
    }
    if (ImGui::Button("Back", {touch_width(1), 0})) ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
}

void PanelWidgets::text(const ControlState& one)
{
    const Control control = one.id.control;
    if (control != Control::rename && control != Control::add_text) {  // a path: by a dialog
        flow(ImGui::CalcTextSize(one.label.c_str()).x + 2 * ImGui::GetStyle().FramePadding.x);
        if (button(one.id, one.label.c_str(), false) && open_dialog) open_dialog(control);
        return tooltip(one);
    }
    end_row();
    const auto being = edited.find(one.id);
    char buffer[longest_text + 6] = {};
    const std::string& from =
        being == edited.end() ? std::get<std::string>(one.value) : being->second;
    from.copy(buffer, longest_text);
    const bool entered = ImGui::InputText(one.label.c_str(), buffer, sizeof buffer,
                                          ImGuiInputTextFlags_EnterReturnsTrue);
    placed(one.id);
    if (ImGui::IsItemActive()) edited[one.id] = buffer;
    if (ImGui::IsItemDeactivated()) {
        // Escape restores the text; a click elsewhere keeps what was typed.
        const std::string to = being == edited.end() ? std::string(buffer) : being->second;
        const bool escaped = ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape));
        edited.erase(one.id);
        if (!escaped && !to.empty() && to != std::get<std::string>(one.value))
            event(one.id, entered ? std::string(buffer) : to);
    }
    tooltip(one);
}

void PanelWidgets::control(const ControlState& one)
{
    ImGui::PushID(int(one.id.control)), ImGui::PushID(one.id.index);
    // A finger that presses what is not available is answered by the reason.
    const bool greyed = !one.why_not.empty();
    if (greyed && touch)
        ImGui::PushStyleVar(ImGuiStyleVar_Alpha, 0.45f * ImGui::GetStyle().Alpha);
    else
        ImGui::BeginDisabled(greyed);
    const auto width = [&](const char* label) {
        const float needed = ImGui::CalcTextSize(label).x + 2 * ImGui::GetStyle().FramePadding.x;
        if (!touch) return needed;
        int count = per_row;
        while (count > 1 && touch_width(count) < needed) --count;
        return touch_width(count);
    };
    if (std::holds_alternative<std::monostate>(one.value)) {
        const float wide = width(one.label.c_str());
        flow(wide);
        if (button(one.id, one.label.c_str(), one.row().discards, touch ? wide : 0))
            event(one.id, std::monostate());
        tooltip(one);
    } else if (const bool* on = std::get_if<bool>(&one.value)) {
        const char* const label = text_of_switch(one);
        if (touch || one.id.control == Control::pause || one.id.control == Control::film) {
            const float wide = width(label);
            flow(wide);
            if (button(one.id, label, false, touch ? wide : 0, *on)) event(one.id, !*on);
        } else {
            flow(width(label) + ImGui::GetFrameHeight());
            bool next = *on;
            if (ImGui::Checkbox(label, &next)) event(one.id, next);
            placed(one.id);
        }
        tooltip(one);
    } else if (std::holds_alternative<double>(one.value)) {
        number(one);
    } else if (std::holds_alternative<int>(one.value)) {
        one.choices.empty() ? whole(one) : choice(one);
    } else {
        text(one);
    }
    if (greyed && touch)
        ImGui::PopStyleVar();
    else
        ImGui::EndDisabled();
    ImGui::PopID(), ImGui::PopID();
}

}  // namespace knead
