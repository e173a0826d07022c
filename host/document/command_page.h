// Texts for readers, made from the table of commands (command_table.h).
#pragma once
#include <string>

namespace knead {

std::string commands_help();  // for a terminal, 80 columns: `knead help commands`
// The generated part of docs/reference/commands.md, in Markdown, 100 columns.
std::string commands_page();

}  // namespace knead
