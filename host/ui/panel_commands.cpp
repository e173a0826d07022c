#include "host/ui/panel_commands.h"

namespace knead {

SetHands hands_command(const HandSettings& to)
{
    return {{to.present[left], to.held[left]}, {to.present[right], to.held[right]}, to.zoom, to.at};
}

}  // namespace knead
