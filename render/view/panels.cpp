#include "render/view/panels.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>

namespace knead {
namespace {

constexpr float wide = 300;  // width of the panels at scale 1 [pixels]

bool combo(const char* label, int& chosen, const std::vector<std::string>& names)
{
    const bool known = chosen >= 0 && std::size_t(chosen) < names.size();
    bool changed = false;
    if (!ImGui::BeginCombo(label, known ? names[std::size_t(chosen)].c_str() : "-")) return false;
    for (int i = 0; i < int(names.size()); ++i) {
        ImGui::PushID(i);  // names need not be unique
        if (ImGui::Selectable(names[std::size_t(i)].c_str(), i == chosen)) {
            changed = i != chosen;
            chosen = i;
        }
        ImGui::PopID();
    }
    ImGui::EndCombo();
    return changed;
}

// A slider. By default typed values are clamped to the range; for quantities that the solver
// checks, `flags` allows any. Returns true if the value changed; ignores NaN and infinity.
bool slide(const char* label, double& value, double low, double high, const char* format,
           ImGuiSliderFlags flags = ImGuiSliderFlags_AlwaysClamp)
{
    // A typed number is applied when editing ends, not after each digit: 2e6 starts with 2.
    static struct {
        ImGuiID item = 0;
        double value = 0;
    } typed;
    const ImGuiID item = ImGui::GetID(label);
    double next = typed.item == item ? typed.value : value;
    ImGui::SliderScalar(label, ImGuiDataType_Double, &next, &low, &high, format, flags);
    if (ImGui::IsItemActive() && ImGui::GetIO().WantTextInput) {
        typed.item = item, typed.value = next;
        return false;
    }
    if (typed.item == item) typed.item = 0;
    if (next == value || !std::isfinite(next)) return false;
    value = next;
    return true;
}

void scene_part(PanelModel& m, PanelRequests& requests)
{
    if (!ImGui::CollapsingHeader("Scene", ImGuiTreeNodeFlags_DefaultOpen)) return;
    if (combo("##scene", m.scene, m.scenes)) requests.load = m.scene;
    ImGui::SameLine();
    if (ImGui::Button("Frame")) requests.fit_camera = true;
    if (ImGui::Button(m.paused ? "Play" : "Pause")) requests.pause = !m.paused;
    ImGui::SameLine();
    if (ImGui::Button("Step")) requests.step = true;
    ImGui::SameLine();
    if (ImGui::Button("Reset")) requests.reset = true;
    if (m.has_recording) {
        bool on = m.recorded;
        if (ImGui::Checkbox("Recorded hands", &on)) requests.recorded = on;
    }
    if (slide("Gravity", m.gravity, 0, 20, "%.2f m/s2", 0)) requests.gravity = m.gravity;
}

void command_button(const CommandButton& button, const char* key, bool& pressed)
{
    ImGui::BeginDisabled(!button.why_not.empty());
    pressed |= ImGui::Button(button.label.c_str());
    ImGui::EndDisabled();
    if (ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled))
        ImGui::SetTooltip("%s", button.why_not.empty() ? key : button.why_not.c_str());
}

void step_list(PanelModel& m, PanelRequests& requests)
{
    constexpr int most = 6;  // lines
    const int count = int(m.steps.size());
    const float line = ImGui::GetTextLineHeightWithSpacing();
    ImGui::BeginChild("steps", {0, line * float(std::min(count, most))});
    ImGuiListClipper clipper;
    clipper.Begin(count, line);
    while (clipper.Step())
        for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
            const StepRow& step = m.steps[std::size_t(i)];
            ImGui::PushID(step.id);
            if (!step.on_line)
                ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetColorU32(ImGuiCol_TextDisabled));
            if (ImGui::Selectable(step.label.c_str(), step.current) && !step.current)
                requests.go_to = step.id;
            if (!step.on_line) ImGui::PopStyleColor();
            ImGui::PopID();
        }
    for (int i = 0; i < count && m.steps_changed; ++i)
        if (m.steps[std::size_t(i)].current) ImGui::SetScrollY(line * float(i - most / 2));
    ImGui::EndChild();
    m.steps_changed = false;
}

void session_part(PanelModel& m, PanelRequests& requests)
{
    if (!ImGui::CollapsingHeader("Session", ImGuiTreeNodeFlags_DefaultOpen)) return;
    command_button(m.undo, "Ctrl+Z", requests.undo);
    ImGui::SameLine();
    command_button(m.redo, "Ctrl+Y", requests.redo);
    ImGui::SameLine();
    command_button(m.save, "Ctrl+S", requests.save);
    if (!m.session.empty()) ImGui::TextWrapped("%s", m.session.c_str());
    for (const StepRow& step : m.steps)
        if (step.current) ImGui::TextWrapped("Last step: %s", step.label.c_str());
    if (m.steps.empty() || !ImGui::TreeNode("Steps")) return;
    step_list(m, requests);
    ImGui::TreePop();
}

void recover_part(const PanelModel& m, PanelRequests& requests, const PictureTexture& texture)
{
    if (m.recoverable.empty()) return;
    if (!ImGui::CollapsingHeader("Recover", ImGuiTreeNodeFlags_DefaultOpen)) return;
    constexpr float across = 96;  // of a picture [pixels]
    for (int i = 0; i < int(m.recoverable.size()); ++i) {
        const RecoverRow& row = m.recoverable[std::size_t(i)];
        ImGui::PushID(i);
        if (const Image* picture = row.picture.get()) {
            const float high = across * float(picture->height) / float(picture->width);
            ImGui::Image(reinterpret_cast<void*>(std::uintptr_t(texture(row.picture))),
                         {across, high});
            ImGui::SameLine();
        }
        ImGui::BeginGroup();
        ImGui::TextWrapped("%s", row.name.c_str());
        ImGui::TextWrapped("%s", row.text.c_str());
        if (ImGui::Button("Recover")) requests.recover = i;
        ImGui::SameLine();
        if (ImGui::Button("Discard")) requests.discard_log = i;
        ImGui::EndGroup();
        ImGui::PopID();
    }
    if (ImGui::Button("Not now")) requests.hide_recoverable = true;
}

void material_part(PanelModel& m, PanelRequests& requests)
{
    if (!ImGui::CollapsingHeader("Material", ImGuiTreeNodeFlags_DefaultOpen)) return;
    if (m.objects.empty()) return ImGui::TextUnformatted("No objects.");
    std::vector<std::string> names;
    for (const ObjectPanel& o : m.objects) names.push_back(o.name);
    m.object = std::clamp(m.object, 0, int(names.size()) - 1);
    if (names.size() > 1) combo("Object", m.object, names);
    ObjectPanel& o = m.objects[std::size_t(m.object)];
    if (combo("Preset", o.preset, m.presets)) requests.preset = true;
    for (Slider& s : o.sliders) {
        const std::string format = "%.4g " + s.unit;
        const ImGuiSliderFlags flags = s.logarithmic ? ImGuiSliderFlags_Logarithmic : 0;
        if (slide(s.name.c_str(), s.value, s.low, s.high, format.c_str(), flags))
            requests.material = true;
    }
}

void hand_part(PanelModel& m, PanelRequests& requests)
{
    if (!ImGui::CollapsingHeader("Hand and tools", ImGuiTreeNodeFlags_DefaultOpen)) return;
    ImGui::Checkbox("The mouse leads a hand (H)", &m.hand);
    int tool = m.tool;
    if (combo("Holds", tool, m.tools)) requests.tool = tool;
    combo("Posture", m.posture, m.postures);
    slide("Press", m.press, 0.01, 0.4, "%.2f m");
    slide("Tilt", m.tilt, -1.5, 1.5, "%.2f rad");
    slide("Roll", m.roll, -3.14, 3.14, "%.2f rad");
    const char* fingers[5] = {"Thumb (1)", "Index (2)", "Middle (3)", "Ring (4)", "Little (5)"};
    if (ImGui::TreeNode("Fingers")) {
        for (int i = 0; i < 5; ++i) slide(fingers[i], m.curl[i], 0, 1, "%.2f");
        ImGui::TreePop();
    }
}

ImU32 colour_of(std::size_t stage)
{
    const float hue = std::fmod(0.08f + 0.61803f * float(stage), 1.0f);
    return ImGui::GetColorU32(ImVec4(ImColor::HSV(hue, 0.55f, 0.9f)));
}

// One bar per frame with stacked stages, the newest at the right.
void bars(const TimeGraph& g, ImVec2 size)
{
    ImDrawList* draw = ImGui::GetWindowDrawList();
    const ImVec2 at = ImGui::GetCursorScreenPos();
    draw->AddRectFilled(at, {at.x + size.x, at.y + size.y}, ImGui::GetColorU32(ImGuiCol_FrameBg));
    const double most = std::max(g.longest(), 1e-6);
    const float step = size.x / float(TimeGraph::frames);
    for (int back = 0; back < g.count(); ++back) {
        const float right = at.x + size.x - step * float(back);
        float top = at.y + size.y;
        for (std::size_t i = 0; i < g.names().size(); ++i) {
            const float high = size.y * float(g.seconds(back, i) / most);
            draw->AddRectFilled({right - step, top - high}, {right, top}, colour_of(i));
            top -= high;
        }
    }
    ImGui::Dummy(size);
}

void time_part(const PanelModel& m)
{
    if (!ImGui::CollapsingHeader("Times", ImGuiTreeNodeFlags_DefaultOpen)) return;
    bars(m.graph, {ImGui::GetContentRegionAvail().x, 60});
    ImGui::Text("highest bar: %.1f ms", 1e3 * m.graph.longest());
    if (ImGui::BeginTable("stages", 2)) {
        for (std::size_t i = 0; i < m.graph.names().size(); ++i) {
            ImGui::TableNextColumn();
            ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(colour_of(i)), "%s",
                               m.graph.names()[i].c_str());
            ImGui::TableNextColumn();
            ImGui::Text("%.2f ms", 1e3 * m.graph.mean(i));
        }
        ImGui::EndTable();
    }
    for (const std::string& fact : m.facts) ImGui::TextWrapped("%s", fact.c_str());
}

// Error and notice, at the lower edge.
void said(const PanelModel& m)
{
    if (m.failure.empty() && m.notice.empty()) return;
    const ImVec2 screen = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({screen.x / 2, screen.y - 12}, ImGuiCond_Always, {0.5f, 1});
    ImGui::SetNextWindowSizeConstraints({200, 0}, {std::max(220.0f, 0.7f * screen.x), 400});
    const ImGuiWindowFlags flags = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                                   ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoNav;
    ImGui::Begin("said", nullptr, flags);
    ImGui::PushTextWrapPos(0.68f * screen.x);
    if (!m.failure.empty()) {
        ImGui::TextColored({1, 0.5f, 0.4f, 1}, "The simulation has ended: %s", m.failure.c_str());
        ImGui::TextUnformatted("Reset begins it anew.");
    }
    if (!m.notice.empty()) ImGui::TextUnformatted(m.notice.c_str());
    ImGui::PopTextWrapPos();
    ImGui::End();
}

// Confirmation dialog before something is discarded, above error and notice.
void question_part(const PanelModel& m, PanelRequests& requests)
{
    if (m.question.empty()) return;
    const ImVec2 screen = ImGui::GetIO().DisplaySize;
    const float left = m.open ? panels_across() : 0, across = std::max(220.0f, screen.x - left);
    ImGui::SetNextWindowPos({left + across / 2, screen.y / 3}, ImGuiCond_Always, {0.5f, 0.5f});
    ImGui::SetNextWindowSizeConstraints({200, 0}, {0.95f * across, 400});
    ImGui::Begin("question", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoNav);
    ImGui::PushTextWrapPos(0.9f * across);
    ImGui::TextUnformatted(m.question.c_str());
    ImGui::PopTextWrapPos();
    if (ImGui::Button(m.answer.c_str())) requests.confirm = true;
    ImGui::SameLine();
    if (ImGui::Button((m.decline + " (Esc)").c_str())) requests.confirm = false;
    ImGui::End();
}

}  // namespace

void style_panels()
{
    ImGui::StyleColorsDark();
    ImGuiStyle& style = ImGui::GetStyle();
    style.WindowRounding = style.FrameRounding = 4;
    style.Colors[ImGuiCol_WindowBg].w = 0.86f;
    style.ScaleAllSizes(std::max(1.0f, ImGui::GetIO().FontGlobalScale));
}

float panels_across() { return 8 + wide * std::max(1.0f, ImGui::GetIO().FontGlobalScale); }

PanelRequests build_panels(PanelModel& m, const PictureTexture& texture)
{
    PanelRequests requests;
    if (m.open) {
        const float scale = std::max(1.0f, ImGui::GetIO().FontGlobalScale);
        const float high = ImGui::GetIO().DisplaySize.y - 16;
        ImGui::SetNextWindowPos({8, 8}, ImGuiCond_Always);
        ImGui::SetNextWindowSizeConstraints({scale * wide, 0},
                                            {scale * wide, std::max(high, 50.f)});
        ImGui::Begin("Knead", nullptr, ImGuiWindowFlags_NoMove | ImGuiWindowFlags_AlwaysAutoResize);
        ImGui::PushItemWidth(0.58f * scale * wide);
        recover_part(m, requests, texture);
        scene_part(m, requests);
        session_part(m, requests);
        material_part(m, requests);
        hand_part(m, requests);
        time_part(m);
        if (ImGui::Button("Screenshot (F12)")) requests.screenshot = true;
        ImGui::SameLine();
        if (ImGui::Button(m.filming ? "Stop film" : "Film")) requests.film = true;
        ImGui::TextDisabled("Tab hides this.");
        ImGui::PopItemWidth();
        ImGui::End();
    }
    question_part(m, requests);
    said(m);
    const bool pressed = ImGui::IsAnyItemActive();
    if (pressed && !m.pressed) ++m.drag;
    m.pressed = pressed;
    requests.drag = m.drag;
    return requests;
}

}  // namespace knead
