// File formats of the panel's dialogs.
#pragma once
#include <string>
#include <vector>

namespace knead {

std::vector<std::string> openable_endings();  // scenes, sessions, objects
std::vector<std::string> export_endings();    // the first is the usual one
// The ending with what it is for, for example ".stl: surface, for printers".
std::string export_format_text(const std::string& ending);

}  // namespace knead
