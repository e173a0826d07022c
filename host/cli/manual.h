// Manual pages and shell completion, generated from the declared options.
#pragma once
#include <string>

namespace CLI {
class App;
}

namespace knead {

// Page in man(7) format of verb `verb`, e.g. "run", or of the program. Throws UsageError for an
// unknown verb.
std::string manual_page(const CLI::App& app, const std::string& verb);
// Writes all pages (man/knead.1, man/knead-run.1, ...), knead.bash and _knead into an existing
// folder. Throws OutputError.
void write_pages(const CLI::App& app, const std::string& folder);
// Completion script for "bash" or "zsh"; throws UsageError for other shells.
std::string completion(const CLI::App& app, const std::string& shell);

}  // namespace knead
