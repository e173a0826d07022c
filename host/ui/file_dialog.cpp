#include "host/ui/file_dialog.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>

#include "host/session/session_file.h"
#include "host/ui/export_formats.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

template <std::size_t size>
void set(char (&to)[size], const std::string& from)
{
    to[from.copy(to, size - 1)] = 0;
}

std::vector<std::string> endings_of(Control control)
{
    if (control == Control::open) return openable_endings();
    if (control == Control::save_as) return {session_ending};
    return export_endings();
}

std::string size_text(std::uint64_t bytes)
{
    if (bytes < 1000) return fmt::format("{} B", bytes);
    if (bytes < 1000000) return fmt::format("{:.1f} kB", 1e-3 * double(bytes));
    return fmt::format("{:.1f} MB", 1e-6 * double(bytes));
}

}  // namespace

void FileDialog::begin(Control of, const PanelModel& model)
{
    control = of, begins = true, replaces = false;
    const fs::path suggested = of == Control::save_as ? model.saves_as
                               : of == Control::open  ? ""
                                                      : model.exports_as;
    set(name, suggested.filename().string());
    const std::string at = suggested.has_parent_path() ? suggested.parent_path().string()
                           : of == Control::open       ? model.folder
                                                       : "";
    go(at.empty() ? "." : at);
}

void FileDialog::go(const std::string& to)
{
    list = list_files(to, endings_of(control));
    set(folder, list.folder);
    replaces = false;
}

std::string FileDialog::path() const
{
    fs::path file(name);
    if (control == Control::save_as && file.extension() != session_ending) file += session_ending;
    return file.is_absolute() ? file.string() : (fs::path(list.folder) / file).string();
}

// A folder is entered; a file is chosen, and replaced only by a second press.
void FileDialog::choose(PanelWidgets& widgets)
{
    if (!*name) return;
    const std::string file = path();
    std::error_code problem;
    if (fs::is_directory(file, problem)) {
        go(file);
        return set(name, "");
    }
    if (writes() && !replaces && fs::exists(file, problem)) {
        replaces = refocus = true;
        return;
    }
    widgets.event({control, 0}, file);
    ImGui::CloseCurrentPopup();
}

void FileDialog::entries(PanelWidgets& widgets, float height)
{
    ImGui::BeginChild("entries", {0, height}, true);
    std::string enter;
    ImGuiListClipper clipper;
    clipper.Begin(int(list.entries.size()));
    while (clipper.Step())
        for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
            const FileEntry& one = list.entries[std::size_t(i)];
            ImGui::PushID(i);
            const std::string text = one.is_folder ? one.name + "/" : one.name;
            if (widgets.row(
                    text, one.name == name,
                    ImGuiSelectableFlags_AllowDoubleClick | ImGuiSelectableFlags_DontClosePopups)) {
                set(name, one.name), replaces = false;
                if (one.is_folder)
                    enter = (fs::path(list.folder) / one.name).string();
                else if (ImGui::IsMouseDoubleClicked(0))
                    choose(widgets);
            }
            widgets.placed({control, 0}, i);
            if (!one.is_folder) {
                const std::string size = size_text(one.size);
                ImGui::SameLine(ImGui::GetWindowContentRegionMax().x -
                                ImGui::CalcTextSize(size.c_str()).x);
                ImGui::TextDisabled("%s", size.c_str());
            }
            ImGui::PopID();
        }
    if (list.entries.empty() && list.error.empty()) ImGui::TextDisabled("nothing of this kind");
    for (const std::string& one : {list.error, list.note})
        if (!one.empty()) ImGui::TextWrapped("%s", one.c_str());
    ImGui::EndChild();
    if (!enter.empty()) go(enter), set(name, "");
}

// The format is the name's ending; unit and objects are controls of their own.
void FileDialog::export_options(const PanelModel& model, PanelWidgets& widgets)
{
    const fs::path file(name);
    const std::vector<std::string> all = export_endings();
    const std::string now = file.extension().string();
    if (ImGui::BeginCombo("Format", export_format_text(now).c_str())) {
        list_open = true;
        for (const std::string& one : all)
            if (ImGui::Selectable(export_format_text(one).c_str(), one == now))
                set(name, file.stem().string() + one), replaces = false;
        ImGui::EndCombo();
    }
    for (const Control each : {Control::export_what, Control::export_unit, Control::export_chosen})
        if (const ControlState* const state = model.find({each, 0})) widgets.control(*state);
    const ControlState* const unit = model.find({Control::export_unit, 0});
    if (unit && std::get<int>(unit->value) > 1 && file.extension() == ".glb")
        ImGui::TextDisabled("Programs that read glTF expect metres.");
}

void FileDialog::folder_lines(const PanelModel& model, PanelWidgets& widgets)
{
    if (ImGui::Button("Up")) go(fs::path(list.folder).parent_path().string());
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-1);
    if (ImGui::InputText("##folder", folder, sizeof folder, ImGuiInputTextFlags_EnterReturnsTrue))
        go(folder);
    if (control == Control::open && !model.files.empty() &&
        ImGui::BeginCombo("Recent and nearby", "")) {
        list_open = true;
        for (const std::string& one : model.files) {
            ImGui::PushID(&one);
            if (widgets.row(one, false)) {
                go(fs::path(one).parent_path().string());
                set(name, fs::path(one).filename().string());
            }
            ImGui::PopID();
        }
        ImGui::EndCombo();
    }
}

// Returns whether the dialog is cancelled.
bool FileDialog::name_lines(PanelWidgets& widgets)
{
    // Enter again replaces the file.
    if (ImGui::IsWindowAppearing() || std::exchange(refocus, false)) ImGui::SetKeyboardFocusHere();
    ImGui::SetNextItemWidth(-1);
    const bool entered = ImGui::InputTextWithHint(
        "##name", "name", name, sizeof name,
        ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll);
    if (ImGui::IsItemEdited()) replaces = false;
    const char* const verb = control == Control::open      ? "Open"
                             : replaces                    ? "Replace the file"
                             : control == Control::save_as ? "Save"
                                                           : "Export";
    const bool pressed = ImGui::Button(verb);
    widgets.placed({control, 0}, -2);
    ImGui::SameLine();
    const bool cancelled = ImGui::Button("Cancel");
    if (replaces) {
        ImGui::SameLine();
        ImGui::TextUnformatted("There is such a file.");
    }
    if (entered || pressed) choose(widgets);
    return cancelled;
}

void FileDialog::frame(const PanelModel& model, PanelWidgets& widgets, float scale)
{
    const std::string title = fmt::format("{}###files", row_of(control).label);
    if (std::exchange(begins, false)) {
        ImGui::OpenPopup("###files");
        // A unit that was chosen for one format is not meant for the next.
        if (control == Control::export_file) widgets.event({Control::export_unit, 0}, 0);
    }
    const ImVec2 screen = ImGui::GetIO().DisplaySize;
    const float wide = std::min(560 * scale, screen.x - 20),
                high = std::min(460 * scale, screen.y - 20);
    ImGui::SetNextWindowPos({screen.x / 2, screen.y / 2}, ImGuiCond_Appearing, {0.5f, 0.5f});
    ImGui::SetNextWindowSize({wide, high}, ImGuiCond_Appearing);
    bool stays = true;
    shown = ImGui::BeginPopupModal(title.c_str(), &stays, ImGuiWindowFlags_NoSavedSettings);
    if (!shown) return;
    const bool list_was_open = std::exchange(list_open, false) || widgets.list_open();
    folder_lines(model, widgets);
    const float line = ImGui::GetFrameHeightWithSpacing();
    const float below = (control == Control::export_file ? 7.3f : 2.2f) * line;
    entries(widgets, std::max(3 * line, ImGui::GetContentRegionAvail().y - below));
    if (control == Control::export_file) export_options(model, widgets);
    // Escape closes a list first.
    const bool escaped =
        ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false) && !list_was_open;
    const bool cancelled = name_lines(widgets) || escaped;
    if (cancelled || !stays) ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
}

}  // namespace knead
