#include "host/ui/panel_drawing.h"

#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <utility>

#include "host/base/errors.h"
#include "host/base/font_file.h"
#include "host/document/command_table.h"
#include "host/picture/font.h"
#include "host/ui/file_dialog.h"
#include "host/ui/panel_widgets.h"
#include "render/gl.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

constexpr float window_text = 15;   // height of a line of text of the window at scale 1 [pixels]
constexpr float panel_width = 300;  // of the window's panel at scale 1 [pixels]

// Latin, Greek, Cyrillic; punctuation.
constexpr ImWchar letters[] = {0x20, 0x24f, 0x370, 0x52f, 0x2010, 0x2026, 0x20ac, 0x20ac, 0};

ImFont* add_font(float height)
{
    ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
    atlas.Clear();
    const std::string file = font_file();
    ImFont* font = nullptr;
    if (!file.empty()) font = atlas.AddFontFromFileTTF(file.c_str(), height, nullptr, letters);
    if (!font) {
        ImFontConfig config;
        config.SizePixels = 13 * std::max(1.f, std::round(height / 13));  // pixels of a bitmap
        font = atlas.AddFontDefault(&config);
    }
    unsigned char* texels = nullptr;
    int width = 0, rows = 0;
    atlas.GetTexDataAsRGBA32(&texels, &width, &rows);  // builds it
    return font;
}

// The smallest font with capitals of that height [pixels].
void choose_font(float capital)
{
    float height = capital / 0.62f;
    for (int tries = 0; tries < 8; ++tries) {
        const float has = capital_of(*add_font(height));
        if (has >= capital) return;
        height = std::ceil(height * std::max(1.02f, capital / std::max(has, 1.f)));
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

void times_part(const TimeGraph& graph, const std::vector<std::string>& facts, float height)
{
    bars(graph, {ImGui::GetContentRegionAvail().x, height});
    ImGui::Text("highest bar: %.1f ms", 1e3 * graph.longest());
    if (ImGui::BeginTable("stages", 2)) {
        for (std::size_t i = 0; i < graph.names().size(); ++i) {
            ImGui::TableNextColumn();
            ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(colour_of(i)), "%s",
                               graph.names()[i].c_str());
            ImGui::TableNextColumn();
            ImGui::Text("%.2f ms", 1e3 * graph.mean(i));
        }
        ImGui::EndTable();
    }
    for (const std::string& fact : facts) ImGui::TextWrapped("%s", fact.c_str());
}

struct Menu {
    const char* title;
    std::vector<Control> controls;
};
const std::vector<Menu>& menus()
{
    static const std::vector<Menu> all{
        {"File",
         {Control::new_scene, Control::open, Control::save, Control::save_as, Control::export_file,
          Control::quit}},
        {"Edit",
         {Control::undo, Control::redo, Control::choose_all, Control::rename, Control::remove}},
        {"Object",
         {Control::move, Control::turn, Control::scale, Control::on_surface, Control::duplicate,
          Control::merge, Control::split, Control::centre, Control::reset_object, Control::place}},
        {"Simulation", {Control::pause, Control::advance, Control::reset}},
        {"View",
         {Control::frame_view, Control::frame_all, Control::mouse_hand, Control::panels,
          Control::screenshot, Control::film}},
        {"Help", {Control::help}}};
    return all;
}

// In the menus alone.
bool only_in_menu(Control control)
{
    switch (control) {
        case Control::new_scene:
        case Control::open:
        case Control::save_as:
        case Control::export_file:
        case Control::quit:
        case Control::help:
        case Control::panels:
        case Control::screenshot:
        case Control::choose_all:
        case Control::place:
            return true;
        default:
            return false;
    }
}

bool in_export_dialog(Control control)
{
    return control == Control::export_what || control == Control::export_unit ||
           control == Control::export_chosen;
}

const PanelSection* section_of(const PanelModel& model, PanelPart part)
{
    for (const PanelSection& one : model.sections)
        if (one.part == part) return &one;
    return nullptr;
}

class DearImGuiPanel final : public PanelDrawing {
  public:
    explicit DearImGuiPanel(const PanelDrawingOptions& options);
    ~DearImGuiPanel() override;
    DearImGuiPanel(const DearImGuiPanel&) = delete;

    std::vector<ControlEvent> frame(const PanelModel& model, const TimeGraph& times,
                                    const PanelInput& input, int width, int height) override;
    void draw(unsigned framebuffer) override;
    bool mouse_taken() const override { return mouse_taken_; }
    bool keys_taken() const override { return keys_taken_ || begins_ || dialog_.open(); }
    bool popup_open() const override { return popup_open_; }
    bool moves() const override { return widgets_.moves() || keys_taken_ || settling_ > 0; }
    bool shows_times() const override { return shows_times_; }
    int covered() const override { return covered_; }
    void begin(Control control) override { begins_ = control; }
    std::optional<PanelRect> place_of(ControlId id, int item) const override
    {
        return widgets_.place_of(id, item);
    }
    float capital() const override { return capital_; }
    int picture_width() const override { return options_.width; }
    int picture_height() const override { return options_.height + options_.palm_height; }

  private:
    void take(const PanelInput& input, int width, int height);
    void style();
    // The window's layout.
    void menu(const PanelModel& model);
    void menu_item(const PanelModel& model, Control control);
    void panel(const PanelModel& model, const TimeGraph& times);
    void section(const PanelModel& model, const PanelSection& one);
    void object_list(const PanelModel& model, const PanelSection& one);
    void steps(const PanelModel& model, const ControlState& one);
    void all_steps(const ControlState& one);
    void recover(const PanelModel& model);
    void keys_window();
    void question(const PanelModel& model);
    void notice(const PanelModel& model);
    void beside_pointer(const std::string& text, ImVec2 pointer) const;
    // For a finger.
    void touch_panel(const PanelModel& model, const TimeGraph& times);
    void touch_controls(const PanelModel& model, const PanelSection& one);
    void touch_files(const PanelModel& model, const ControlState& one);
    void palm(const PanelModel& model);
    void translate(std::vector<ControlEvent>& events, const PanelModel& model);
    unsigned texture_of(const std::shared_ptr<const Image>& picture);

    const PanelDrawingOptions options_;
    ImGuiContext* const context_;
    PanelWidgets widgets_;
    FileDialog dialog_;
    std::map<std::shared_ptr<const Image>, Texture> pictures_;
    std::optional<Control> begins_;
    float capital_ = 0, scale_ = 1, bar_ = 0;
    int width_ = 0, height_ = 0, covered_ = 0, settling_ = 3;
    ImVec2 panel_at_{}, panel_size_{}, panel_screen_{};  // as the user made it; of that screen
    bool mouse_taken_ = false, keys_taken_ = false, popup_open_ = false, shows_times_ = false;
    std::shared_ptr<const std::vector<StepInfo>> steps_;  // of the model,
    std::vector<const StepInfo*> line_;                   // those that undo and redo reach,
    int step_at_ = 0;                                     // and the current one of these
    int chosen_ = 0;                                      // object to which their list was scrolled
    bool scrolls_ = false;                                // the list of steps, to the current one
    std::string question_;                                // that is shown
    std::string notice_;
    int part_ = 1, file_at_ = 0;  // of touch: chosen part; file that can be opened
    std::string clipboard_;
};

DearImGuiPanel::DearImGuiPanel(const PanelDrawingOptions& options)
    : options_(options), context_(ImGui::CreateContext()), widgets_(options.touch)
{
    ImGui::SetCurrentContext(context_);
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;  // no imgui.ini file
    io.BackendPlatformName = "knead";
    if (options.set_clipboard) {
        io.ClipboardUserData = this;
        io.GetClipboardTextFn = [](void* self) -> const char* {
            auto& of = *static_cast<DearImGuiPanel*>(self);
            of.clipboard_ = of.options_.clipboard();
            return of.clipboard_.c_str();
        };
        io.SetClipboardTextFn = [](void* self, const char* text) {
            static_cast<DearImGuiPanel*>(self)->options_.set_clipboard(text);
        };
    }
    scale_ = std::max(0.5f, options.scale);
    if (options.touch)
        choose_font(options.capital);
    else
        add_font(std::round(window_text * scale_));
    capital_ = capital_of(*io.Fonts->Fonts[0]);
    style();
    widgets_.open_dialog = [this](Control control) { begins_ = control; };
    constexpr int keys[] = {ImGuiKey_Tab,        ImGuiKey_Backspace, ImGuiKey_Delete,
                            ImGuiKey_Enter,      ImGuiKey_Escape,    ImGuiKey_LeftArrow,
                            ImGuiKey_RightArrow, ImGuiKey_UpArrow,   ImGuiKey_DownArrow,
                            ImGuiKey_Home,       ImGuiKey_End,       ImGuiKey_A,
                            ImGuiKey_C,          ImGuiKey_V,         ImGuiKey_X,
                            ImGuiKey_Y,          ImGuiKey_Z};
    static_assert(std::size(keys) == panel_key_count);
    for (std::size_t k = 0; k < panel_key_count; ++k) io.KeyMap[keys[k]] = int(k);
    if (!options.gl) return;
    if (!ImGui_ImplOpenGL3_Init("#version 450 core"))
        throw ResourceError("the panels cannot be drawn with this OpenGL");
    ImGui_ImplOpenGL3_NewFrame();  // makes its objects, so that frame() needs no context
}

DearImGuiPanel::~DearImGuiPanel()
{
    ImGui::SetCurrentContext(context_);
    pictures_.clear();
    if (options_.gl) ImGui_ImplOpenGL3_Shutdown();
    ImGui::DestroyContext(context_);
}

void DearImGuiPanel::style()
{
    ImGui::StyleColorsDark();
    ImGuiStyle& style = ImGui::GetStyle();
    style.WindowRounding = style.FrameRounding = style.PopupRounding = 4;
    style.Colors[ImGuiCol_WindowBg].w = 0.9f;
    style.Colors[ImGuiCol_PopupBg].w = 0.97f;
    if (!options_.touch) return style.ScaleAllSizes(scale_);
    // An item for a finger is twice as high as its letters.
    style.FramePadding = {0.5f * capital_, 0.36f * capital_};
    style.ItemSpacing = {0.3f * capital_, 0.26f * capital_};
    style.WindowPadding = {0.4f * capital_, 0.3f * capital_};
    style.WindowBorderSize = style.PopupBorderSize = 0;
    style.WindowRounding = 0;
    style.GrabMinSize = 1.2f * capital_;
    style.ScrollbarSize = 1.5f * capital_;
    style.Colors[ImGuiCol_WindowBg] = style.Colors[ImGuiCol_PopupBg] = {0.10f, 0.11f, 0.13f, 1};
    style.Colors[ImGuiCol_Button] = {0.24f, 0.26f, 0.30f, 1};
    style.Colors[ImGuiCol_ButtonActive] =
        style.Colors[ImGuiCol_SliderGrab] = {0.38f, 0.55f, 0.38f, 1};
    style.Colors[ImGuiCol_FrameBg] = {0.20f, 0.22f, 0.26f, 1};
    style.Colors[ImGuiCol_Text] = {0.93f, 0.93f, 0.91f, 1};
}

void DearImGuiPanel::take(const PanelInput& input, int width, int height)
{
    ImGuiIO& io = ImGui::GetIO();
    width_ = width, height_ = height;
    io.DisplaySize = {float(width), float(height)};
    io.DeltaTime = float(std::clamp(input.seconds, 1e-4, 1.0));
    io.MousePos = input.pointer ? ImVec2(input.x, input.y) : ImVec2(-FLT_MAX, -FLT_MAX);
    for (std::size_t b = 0; b < input.down.size(); ++b) io.MouseDown[b] = input.down[b];
    io.MouseWheel = input.wheel;
    std::copy(input.keys.begin(), input.keys.end(), io.KeysDown);
    io.KeyCtrl = input.control, io.KeyShift = input.shift;
    // A decimal comma.
    for (const int letter : input.typed)
        io.AddInputCharacter(unsigned(letter == ',' && widgets_.types_number() ? '.' : letter));
}

std::vector<ControlEvent> DearImGuiPanel::frame(const PanelModel& model, const TimeGraph& times,
                                                const PanelInput& input, int width, int height)
{
    ImGui::SetCurrentContext(context_);
    take(input, width, height);
    ImGui::NewFrame();
    std::erase_if(pictures_, [](const auto& one) { return one.first.use_count() == 1; });
    widgets_.begin_frame(input.seconds);
    covered_ = 0, bar_ = 0;
    popup_open_ = shows_times_ = false;
    if (options_.touch) {
        touch_panel(model, times);
        if (options_.palm_height > 0) palm(model);
    } else {
        if (model.open) menu(model), panel(model, times);
        if (model.help) keys_window();
        if (begins_ && *begins_ != Control::rename) dialog_.begin(*begins_, model);
        if (begins_ != Control::rename) begins_.reset();
        dialog_.frame(model, widgets_, scale_);
        question(model);
        notice(model);
        if (!model.pointing.empty() && input.pointer && !ImGui::GetIO().WantCaptureMouse)
            beside_pointer(model.pointing, {input.x, input.y});
    }
    popup_open_ = popup_open_ || ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopup);
    const ImGuiIO& io = ImGui::GetIO();
    mouse_taken_ = io.WantCaptureMouse, keys_taken_ = io.WantTextInput;
    std::vector<ControlEvent> events = widgets_.end_frame();
    if (options_.touch) translate(events, model);
    const bool pressed = input.down[0] || input.down[1] || input.wheel != 0;
    settling_ =
        !events.empty() || pressed || model.notice != notice_ ? 3 : std::max(0, settling_ - 1);
    notice_ = model.notice;
    ImGui::Render();
    return events;
}

void DearImGuiPanel::draw(unsigned framebuffer)
{
    ImGui::SetCurrentContext(context_);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(0, 0, width_, height_);
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

unsigned DearImGuiPanel::texture_of(const std::shared_ptr<const Image>& picture)
{
    if (!options_.gl) return 0;
    Texture& made = pictures_[picture];
    if (made) return made;
    made = texture(GL_TEXTURE_2D);
    glTextureStorage2D(made, 1, GL_RGB8, picture->width, picture->height);
    glTextureParameteri(made, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTextureSubImage2D(made, 0, 0, 0, picture->width, picture->height, GL_RGB, GL_UNSIGNED_BYTE,
                        picture->rgb.data());
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    return made;
}

void DearImGuiPanel::menu_item(const PanelModel& model, Control control)
{
    const ControlState* const one = model.find({control, 0});
    if (!one) return;
    const ControlRow& row = one->row();
    const bool* const on = std::get_if<bool>(&one->value);
    const std::string keys(row.keys, std::string_view(row.keys).find(' ') == std::string_view::npos
                                         ? std::string_view(row.keys).size()
                                         : std::string_view(row.keys).find(' '));
    const bool is_path = std::holds_alternative<std::string>(one->value);
    const std::string label = one->label == row.label || is_path ? row.label : one->label;
    const bool chosen =
        ImGui::MenuItem(label.c_str(), keys.c_str(), on && *on, one->why_not.empty());
    widgets_.placed(one->id, -3);
    widgets_.tooltip(*one);
    if (!chosen) return;
    if (is_path)
        begins_ = control;
    else if (on)
        widgets_.event(one->id, !*on);
    else
        widgets_.event(one->id, std::monostate());
}

void DearImGuiPanel::menu(const PanelModel& model)
{
    if (!ImGui::BeginMainMenuBar()) return;
    bar_ = ImGui::GetWindowSize().y;
    for (const Menu& one : menus()) {
        if (!ImGui::BeginMenu(one.title)) continue;
        for (const Control control : one.controls) menu_item(model, control);
        ImGui::EndMenu();
    }
    if (!model.session.empty()) {
        const float wide = ImGui::CalcTextSize(model.session.c_str()).x;
        const float right = ImGui::GetWindowWidth() - wide - ImGui::GetStyle().ItemSpacing.x;
        ImGui::SameLine(std::max(right, ImGui::GetCursorPosX() + 8));
        ImGui::TextDisabled("%s", model.session.c_str());
    }
    ImGui::EndMainMenuBar();
}

void DearImGuiPanel::object_list(const PanelModel& model, const PanelSection& one)
{
    std::vector<const ControlState*> objects;
    for (const ControlState& state : one.controls)
        if (state.id.control == Control::object) objects.push_back(&state);
    if (objects.empty()) return ImGui::TextDisabled("No objects.");
    constexpr int most = 5;  // lines
    const float line = ImGui::GetTextLineHeightWithSpacing();
    const float high =
        line * float(std::min(int(objects.size()), most)) + 2 * ImGui::GetStyle().WindowPadding.y;
    ImGui::BeginChild("objects", {0, high}, true);
    for (const ControlState* object : objects) {
        ImGui::PushID(object->id.index);
        const bool chosen = std::get<bool>(object->value);
        const bool several = ImGui::GetIO().KeyCtrl || ImGui::GetIO().KeyShift;
        if (widgets_.row(object->label, chosen))
            widgets_.event(object->id, several ? ControlValue(!chosen) : std::monostate());
        widgets_.placed(object->id);
        if (object->id.index == model.active && model.active != chosen_) {
            chosen_ = model.active;
            ImGui::SetScrollHereY();
        }
        ImGui::PopID();
    }
    ImGui::EndChild();
}

std::string label_of(const StepInfo& step) { return step.id == 0 ? "Beginning" : step.label; }

// A slider over the steps that undo and redo reach, and the list of all.
void DearImGuiPanel::steps(const PanelModel& model, const ControlState& one)
{
    widgets_.end_row();
    if (!model.steps) return;
    if (model.steps != steps_) {
        steps_ = model.steps;
        line_.clear(), step_at_ = 0;
        for (const StepInfo& step : *steps_) {
            if (step.current) step_at_ = int(line_.size());
            if (step.on_line || step.current) line_.push_back(&step);
        }
        scrolls_ = true;
    }
    if (line_.empty()) return;
    // Also without a step, so that nothing moves when the first one comes.
    ImGui::BeginDisabled(!one.why_not.empty() || line_.size() < 2);
    int to = step_at_;
    std::string text =
        fmt::format("{} of {}: {}", to, line_.size() - 1, label_of(*line_[std::size_t(to)]));
    std::replace(text.begin(), text.end(), '%', ' ');  // it is a format
    ImGui::SetNextItemWidth(-1);
    if (ImGui::SliderInt("##steps", &to, 0, std::max(1, int(line_.size()) - 1), text.c_str(),
                         ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoInput) &&
        to != step_at_)
        widgets_.event(one.id, int(line_[std::size_t(to)]->id), 1);
    widgets_.placed(one.id);
    widgets_.tooltip(one);
    if (!options_.touch && ImGui::TreeNode("All steps")) {
        all_steps(one);
        ImGui::TreePop();
    }
    ImGui::EndDisabled();
}

void DearImGuiPanel::all_steps(const ControlState& one)
{
    constexpr int most = 6;  // lines
    const int count = int(steps_->size());
    const float high = ImGui::GetTextLineHeightWithSpacing();
    ImGui::BeginChild("steps", {0, high * float(std::min(count, most))});
    ImGuiListClipper clipper;
    clipper.Begin(count, high);
    while (clipper.Step())
        for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
            const StepInfo& step = (*steps_)[std::size_t(i)];
            ImGui::PushID(int(step.id));
            if (!step.on_line)
                ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetColorU32(ImGuiCol_TextDisabled));
            if (widgets_.row(label_of(step), step.current) && !step.current)
                widgets_.event(one.id, int(step.id));
            if (!step.on_line) ImGui::PopStyleColor();
            widgets_.placed(one.id, int(step.id));
            ImGui::PopID();
        }
    for (int i = 0; i < count && scrolls_; ++i)
        if ((*steps_)[std::size_t(i)].current) ImGui::SetScrollY(high * float(i - most / 2));
    scrolls_ = false;
    ImGui::EndChild();
}

void DearImGuiPanel::section(const PanelModel& model, const PanelSection& one)
{
    if (std::ranges::all_of(one.controls,
                            [](const ControlState& c) { return only_in_menu(c.id.control); }))
        return;
    const ImGuiTreeNodeFlags flags =
        one.part == PanelPart::view ? 0 : ImGuiTreeNodeFlags_DefaultOpen;
    if (!ImGui::CollapsingHeader(part_titles[std::size_t(one.part)], flags)) return;
    widgets_.end_row();
    if (one.part == PanelPart::clay) object_list(model, one);
    bool fingers = true, shows_fingers = false;
    for (const ControlState& state : one.controls) {
        const Control control = state.id.control;
        if (only_in_menu(control) || in_export_dialog(control) || control == Control::object)
            continue;
        if (control == Control::curl) {
            if (std::exchange(fingers, false)) shows_fingers = ImGui::TreeNode("Fingers");
            if (!shows_fingers) continue;
        }
        if (control == Control::rename && begins_ == Control::rename)
            ImGui::SetKeyboardFocusHere(), begins_.reset();
        control == Control::go_to ? steps(model, state) : widgets_.control(state);
    }
    if (shows_fingers) ImGui::TreePop();
}

void DearImGuiPanel::recover(const PanelModel& model)
{
    if (model.recoverable.empty()) return;
    if (!ImGui::CollapsingHeader("Recover", ImGuiTreeNodeFlags_DefaultOpen)) return;
    const float across = 96 * scale_;  // of a picture [pixels]
    for (int i = 0; i < int(model.recoverable.size()); ++i) {
        const RecoverRow& row = model.recoverable[std::size_t(i)];
        ImGui::PushID(i);
        if (const Image* picture = row.picture.get()) {
            const float larger = float(std::max(picture->height, picture->width));
            ImGui::Image(reinterpret_cast<void*>(std::uintptr_t(texture_of(row.picture))),
                         {across * float(picture->width) / larger,
                          across * float(picture->height) / larger});
            ImGui::SameLine();
        }
        ImGui::BeginGroup();
        ImGui::TextWrapped("%s", row.name.c_str());
        ImGui::TextWrapped("%s", row.text.c_str());
        for (const Control control : {Control::recover, Control::discard_log}) {
            ControlState state;
            state.id = {control, i}, state.label = row_of(control).label;
            widgets_.control(state);
        }
        widgets_.end_row();
        ImGui::EndGroup();
        ImGui::PopID();
    }
    ControlState later;
    later.id = {Control::hide_recoverable, 0}, later.label = row_of(later.id.control).label;
    widgets_.control(later);
    widgets_.end_row();
}

void DearImGuiPanel::panel(const PanelModel& model, const TimeGraph& times)
{
    const ImVec2 screen = ImGui::GetIO().DisplaySize;
    const float edge = 8 * scale_, top = bar_ + edge;
    const float wide = panel_width * scale_;
    const float high = std::max(50.f, screen.y - top - edge);
    if (panel_size_.x <= 0) panel_at_ = {edge, top}, panel_size_ = {wide, high};
    // A window that becomes small for a while leaves the panel as the user made it.
    if (screen.x != panel_screen_.x || screen.y != panel_screen_.y) {
        panel_screen_ = screen;
        ImGui::SetNextWindowPos(panel_at_);
        ImGui::SetNextWindowSize({panel_size_.x, std::min(panel_size_.y, high)});
    }
    ImGui::SetNextWindowSizeConstraints({0.6f * wide, 0}, {std::max(0.6f * wide, screen.x), high});
    bool stays = true;
    if (ImGui::Begin("Knead###panel", &stays)) {
        // A window that has become smaller, or a drag, leaves enough of the panel to hold it.
        const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
        const ImVec2 inside{
            std::clamp(at.x, 40 * scale_ - size.x, std::max(0.f, screen.x - 40 * scale_)),
            std::clamp(at.y, bar_, std::max(bar_, screen.y - 40 * scale_))};
        if (inside.x != at.x || inside.y != at.y) ImGui::SetWindowPos(inside);
        if (at.x <= 2 * edge) covered_ = int(at.x + size.x);
        if (ImGui::IsMouseDown(0)) panel_at_ = at, panel_size_ = size;
        ImGui::PushItemWidth(0.56f * ImGui::GetWindowContentRegionMax().x);
        recover(model);
        for (const PanelSection& one : model.sections) section(model, one);
        shows_times_ = ImGui::CollapsingHeader("Times");
        if (shows_times_) times_part(times, model.facts, 60 * scale_);
        ImGui::PopItemWidth();
    }
    ImGui::End();
    if (!stays) widgets_.event({Control::panels, 0}, false);
}

void DearImGuiPanel::keys_window()
{
    const ImVec2 screen = ImGui::GetIO().DisplaySize;
    const float wide = std::min(620 * scale_, screen.x - 20),
                high = std::min(560 * scale_, screen.y - 40);
    ImGui::SetNextWindowPos({screen.x / 2, screen.y / 2}, ImGuiCond_Appearing, {0.5f, 0.5f});
    ImGui::SetNextWindowSize({wide, high}, ImGuiCond_Appearing);
    bool stays = true;
    if (ImGui::Begin("Keys and gestures", &stays)) {
        if (ImGui::BeginTable("keys", 2,
                              ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingStretchProp)) {
            ImGui::TableSetupColumn("input", 0, 1);
            ImGui::TableSetupColumn("effect", 0, 2);
            const auto row = [](const char* input, const char* effect) {
                ImGui::TableNextColumn();
                ImGui::TextWrapped("%s", input);
                ImGui::TableNextColumn();
                ImGui::TextWrapped("%s", effect);
            };
            for (const GestureRow& one : gesture_rows) row(one.input, one.effect);
            for (const ControlRow& one : control_rows)
                if (*one.keys) row(one.keys, fmt::format("{}. {}", one.label, one.help).c_str());
            ImGui::EndTable();
        }
    }
    ImGui::End();
    if (!stays) widgets_.event({Control::help, 0}, false);
}

void DearImGuiPanel::question(const PanelModel& model)
{
    if (model.question.text.empty()) {
        question_.clear();
        return;
    }
    const bool appears = question_ != model.question.text;
    question_ = model.question.text;
    const ImVec2 screen = ImGui::GetIO().DisplaySize;
    // In the free part of the window, if it fits there.
    const float needed = std::min(30 * ImGui::GetFontSize(), screen.x - 16);
    const bool beside = screen.x - float(covered_) > needed + 16;
    const float left = beside ? float(covered_) : 0, across = screen.x - left - 16;
    ImGui::SetNextWindowPos({left + 8 + across / 2, screen.y / 3}, ImGuiCond_Always, {0.5f, 0.5f});
    ImGui::SetNextWindowSizeConstraints({0, 0}, {across, std::max(60.f, screen.y - 16)});
    if (appears) ImGui::SetNextWindowFocus();
    ImGui::Begin("question", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoNav);
    ImGui::PushTextWrapPos(
        std::min(across - 2 * ImGui::GetStyle().WindowPadding.x, 30 * ImGui::GetFontSize()));
    ImGui::TextUnformatted(model.question.text.c_str());
    ImGui::PopTextWrapPos();
    const std::vector<std::string>& answers = model.question.answers;
    for (int i = 0; i < int(answers.size()); ++i) {
        // Below each other where they do not fit.
        const float right = ImGui::GetItemRectMax().x + ImGui::GetStyle().ItemSpacing.x +
                            ImGui::CalcTextSize(answers[std::size_t(i)].c_str()).x +
                            2 * ImGui::GetStyle().FramePadding.x;
        if (i > 0 && right < ImGui::GetWindowPos().x + across) ImGui::SameLine();
        if (widgets_.button({Control::answer, i}, answers[std::size_t(i)].c_str(), false))
            widgets_.event({Control::answer, i}, std::monostate());
    }
    ImGui::End();
    popup_open_ = true;
}

// Error and notice, at the lower edge. It takes neither input nor focus, so that a list that is
// open stays.
void DearImGuiPanel::beside_pointer(const std::string& text, ImVec2 pointer) const
{
    ImDrawList* const draw = ImGui::GetForegroundDrawList();
    const float pad = 3 * scale_;
    const ImVec2 size = ImGui::CalcTextSize(text.c_str()),
                 at{pointer.x + 16 * scale_, pointer.y + 12 * scale_};
    draw->AddRectFilled({at.x - pad, at.y - pad}, {at.x + size.x + pad, at.y + size.y + pad},
                        IM_COL32(0, 0, 0, 150), pad);
    draw->AddText(at, IM_COL32(255, 255, 255, 255), text.c_str());
}

void DearImGuiPanel::notice(const PanelModel& model)
{
    if (model.failure.empty() && model.notice.empty()) return;
    const ImVec2 screen = ImGui::GetIO().DisplaySize;
    // In the free part of the window, unless that is narrow.
    const float free = screen.x - float(covered_);
    const bool beside = free > 20 * ImGui::GetFontSize();
    const float left = beside ? float(covered_) : 0, across = screen.x - left;
    ImGui::SetNextWindowPos({left + across / 2, screen.y - 12}, ImGuiCond_Always, {0.5f, 1});
    ImGui::SetNextWindowSizeConstraints({std::min(200.f, across), 0}, {across - 8, screen.y});
    ImGui::Begin("notice", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                     ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoNav |
                     ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoBringToFrontOnFocus);
    ImGui::PushTextWrapPos(std::min(0.9f * across, 45 * ImGui::GetFontSize()));
    if (!model.failure.empty()) {
        ImGui::TextColored({1, 0.5f, 0.4f, 1}, "The simulation has ended: %s",
                           model.failure.c_str());
        ImGui::TextUnformatted("Reset begins it anew.");
    }
    if (!model.notice.empty()) ImGui::TextUnformatted(model.notice.c_str());
    ImGui::PopTextWrapPos();
    ImGui::End();
}

// The files that can be opened as a list, and the button to hold.
void DearImGuiPanel::touch_files(const PanelModel& model, const ControlState& one)
{
    if (model.files.empty()) return;
    file_at_ = std::clamp(file_at_, 0, int(model.files.size()) - 1);
    const auto name = [&](int i) {
        return fs::path(model.files[std::size_t(i)]).filename().string();
    };
    ControlState list;
    list.id = {Control::open, 1}, list.label = "File", list.value = file_at_;
    for (int i = 0; i < int(model.files.size()); ++i) list.choices.push_back(name(i));
    widgets_.control(list);
    ControlState button = one;
    button.value = std::monostate(), button.label = "Open " + name(file_at_);
    widgets_.control(button);
}

void DearImGuiPanel::touch_controls(const PanelModel& model, const PanelSection& one)
{
    ControlState objects;
    for (const ControlState& state : one.controls) {
        if (state.id.control != Control::object) continue;
        if (state.id.index == model.active) objects.value = int(objects.choices.size());
        objects.choices.push_back(state.label);
    }
    if (!objects.choices.empty()) {
        objects.id = {Control::object, 0}, objects.label = "Object";
        if (std::holds_alternative<std::monostate>(objects.value)) objects.value = -1;
        widgets_.control(objects);
    } else if (one.part == PanelPart::clay) {
        ImGui::TextUnformatted("No objects.");
    }
    for (const ControlState& state : one.controls) {
        if (state.id.control == Control::object || in_export_dialog(state.id.control)) continue;
        if (state.id.control == Control::go_to)
            steps(model, state);
        else if (state.id.control == Control::open)
            touch_files(model, state);
        else if (state.id.control == Control::export_file) {
            ControlState button = state;
            button.value = std::monostate();
            widgets_.control(button);
        } else
            widgets_.control(state);
    }
}

void DearImGuiPanel::touch_panel(const PanelModel& model, const TimeGraph& times)
{
    const ImVec2 size{float(options_.width), float(options_.height)};
    ImGui::SetNextWindowPos({0, 0}), ImGui::SetNextWindowSize(size);
    widgets_.list_at = {0, 0}, widgets_.list_size = size;
    constexpr ImGuiWindowFlags fixed = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                       ImGuiWindowFlags_NoBringToFrontOnFocus;
    ImGui::Begin("panel", nullptr, fixed);
    // Two lines, so that nothing moves when a long text comes.
    const float line = ImGui::GetTextLineHeightWithSpacing();
    ImGui::BeginChild("line", {0, 2 * line}, false, ImGuiWindowFlags_NoScrollbar);
    if (!model.failure.empty())
        ImGui::TextColored({1, 0.5f, 0.4f, 1}, "Ended:"), ImGui::SameLine(),
            ImGui::TextWrapped("%s", model.failure.c_str());
    else if (!model.notice.empty())
        ImGui::TextWrapped("%s", model.notice.c_str());
    else if (!model.pointing.empty())
        ImGui::TextWrapped("%s", model.pointing.c_str());
    else
        ImGui::TextDisabled("Knead  %s", model.session.c_str());
    ImGui::EndChild();
    const int parts = int(part_titles.size());
    widgets_.per_row = parts;
    // As wide as their titles, and the rest in equal parts.
    float rest =
        ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x * float(parts - 1);
    for (const char* title : part_titles) rest -= ImGui::CalcTextSize(title).x;
    for (int i = 0; i < parts; ++i) {
        const char* const title = part_titles[std::size_t(i)];
        const float wide = ImGui::CalcTextSize(title).x + rest / float(parts);
        if (i > 0) ImGui::SameLine();
        if (widgets_.button({Control::panels, i}, title, false, wide, i == part_)) part_ = i;
    }
    widgets_.per_row = 3;
    widgets_.end_row();
    ImGui::BeginChild("part");
    if (const PanelSection* const one = section_of(model, PanelPart(part_)))
        touch_controls(model, *one);
    shows_times_ = PanelPart(part_) == PanelPart::view;
    if (shows_times_) times_part(times, model.facts, 3 * line);
    ImGui::EndChild();
    ImGui::End();
}

// Places in lists for a finger become what the window's items give.
void DearImGuiPanel::translate(std::vector<ControlEvent>& events, const PanelModel& model)
{
    std::erase_if(events, [&](ControlEvent& one) {
        const int* const at = std::get_if<int>(&one.value);
        if (one.id == ControlId{Control::open, 1}) {
            if (at) file_at_ = *at;
            return true;
        }
        if (one.id == ControlId{Control::open, 0}) {
            if (std::size_t(file_at_) >= model.files.size()) return true;
            one.value = model.files[std::size_t(file_at_)];
        }
        if (one.id.control == Control::export_file) one.value = model.exports_as;
        if (one.id.control == Control::object && at) {
            int place = *at;
            for (const PanelSection& section : model.sections)
                for (const ControlState& state : section.controls)
                    if (state.id.control == Control::object && place-- == 0)
                        one.id.index = state.id.index;
            one.value = std::monostate();
        }
        return false;
    });
}

void DearImGuiPanel::palm(const PanelModel& model)
{
    ImGui::SetNextWindowPos({0, float(options_.height)});
    ImGui::SetNextWindowSize({float(options_.palm_width), float(options_.palm_height)});
    ImGui::Begin("palm", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoBringToFrontOnFocus);
    widgets_.per_row = 1, widgets_.usual_item = on_palm_item;
    widgets_.end_row();
    for (const PanelSection& section : model.sections)
        for (const ControlState& one : section.controls)
            if (one.row().shown & on_palm) widgets_.control(one);
    widgets_.per_row = 3, widgets_.usual_item = PanelWidgets::whole_control;
    ImGui::End();
}

}  // namespace

std::unique_ptr<PanelDrawing> PanelDrawing::open(const PanelDrawingOptions& options)
{
    return std::make_unique<DearImGuiPanel>(options);
}

}  // namespace knead
