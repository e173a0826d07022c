// When a panel is laid out again: what it shows has changed, somebody acts on it, or it moves.
#pragma once
#include <algorithm>
#include <utility>

#include "host/ui/panel_drawing.h"

namespace knead {

class PanelRefresh {
  public:
    void again() { frames = 3; }
    // Called once a frame, `period` [s] after the last call. `busy`: pointer or keys act on the
    // panel. If true, it has to be laid out with this model.
    bool due(const PanelModel& model, bool busy, const PanelDrawing& panel, double period)
    {
        passed += period;
        if (busy || panel.moves()) again();
        if (model != shown) frames = std::max(frames, 2), shown = model;
        // Times change in every frame: a few times a second are enough.
        const bool graph = panel.shows_times() && passed > 0.2;
        if (frames == 0 && !graph) return false;
        frames = std::max(0, frames - 1);
        return true;
    }
    // Since it was laid out, for the frame that is now [s].
    double take_passed() { return std::exchange(passed, 0); }

  private:
    PanelModel shown;
    int frames = 3;  // to lay out even if nothing changes: sizes follow contents a frame later
    double passed = 0;
};

}  // namespace knead
