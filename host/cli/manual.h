// Pages of the manual and completion for shells, made of the options that the program has.
#pragma once
#include <string>

namespace CLI {
class App;
}

namespace knead {

// man(7): of the program, or of the verb of that name, e.g. "run". Throws UsageError for no verb.
std::string manual_page(const CLI::App& app, const std::string& verb);
// All pages (man/knead.1, man/knead-run.1, ...), knead.bash and _knead into a folder that is there.
// Throws OutputError.
void write_pages(const CLI::App& app, const std::string& folder);
// Of "bash" or "zsh"; throws UsageError for another.
std::string completion(const CLI::App& app, const std::string& shell);

}  // namespace knead
