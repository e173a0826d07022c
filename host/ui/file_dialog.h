// A dialog of the window that chooses a file: to open, to save as, to export. Precondition of
// frame(): within ImGui::NewFrame() and Render().
#pragma once
#include <string>

#include "host/ui/file_list.h"
#include "host/ui/panel_widgets.h"

namespace knead {

class FileDialog {
  public:
    // `control`: open, save_as or export_file.
    void begin(Control control, const PanelModel& model);
    // Gives an event of the control with the path, when one was chosen.
    void frame(const PanelModel& model, PanelWidgets& widgets, float scale);
    bool open() const { return shown; }

  private:
    void go(const std::string& folder);
    void entries(PanelWidgets& widgets, float height);
    void folder_lines(const PanelModel& model, PanelWidgets& widgets);
    bool name_lines(PanelWidgets& widgets);
    void export_options(const PanelModel& model, PanelWidgets& widgets);
    void choose(PanelWidgets& widgets);
    std::string path() const;
    bool writes() const { return control != Control::open; }

    Control control = Control::open;
    bool begins = false, shown = false, replaces = false, refocus = false;
    bool list_open = false;  // in the last frame
    FileList list;
    char name[256] = {};
    char folder[1024] = {};
};

}  // namespace knead
