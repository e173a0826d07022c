#include "host/cli/manual.h"

#include <CLI/CLI.hpp>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/machine.h"
#include "host/base/outputs.h"

namespace knead {
namespace {

using Verbs = std::vector<const CLI::App*>;
Verbs verbs_of(const CLI::App& app)
{
    return app.get_subcommands([](const CLI::App*) { return true; });
}

// Escapes text for roff.
std::string roff(const std::string& text)
{
    std::string out;
    for (const char c : text) {
        if (c == '\\')
            out += "\\e";
        else if (c == '-')
            out += "\\-";
        else if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n'))
            out += std::string("\\&") + c;
        else
            out += c;
    }
    return out;
}

bool takes_value(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

// "-q, --quiet".
std::string names_of(const CLI::Option& option)
{
    std::string names;
    for (const std::string& name : option.get_snames())
        names += (names.empty() ? "-" : ", -") + name;
    for (const std::string& name : option.get_lnames())
        names += (names.empty() ? "--" : ", --") + name;
    return names;
}

bool is_place(const CLI::Option& option)  // a positional argument
{
    return option.get_lnames().empty() && option.get_snames().empty();
}

std::string use(const CLI::App& verb)
{
    std::string text = ".B knead " + roff(verb.get_name()) + "\n[\\fIOPTIONS\\fR]";
    for (const CLI::Option* option : verb.get_options()) {
        if (!is_place(*option)) continue;
        const std::string word = "\\fI" + roff(option->get_name(true)) + "\\fR";
        const std::string more = option->get_items_expected_max() > 1 ? " ..." : "";
        text += option->get_required() ? " " + word + more : " [" + word + more + "]";
    }
    return text + "\n";
}

std::string options_of(const CLI::App& verb)
{
    std::string text;
    for (const CLI::Option* option : verb.get_options()) {
        text += ".TP\n";
        if (is_place(*option)) {
            text += "\\fI" + roff(option->get_name(true)) + "\\fR\n";
        } else {
            text += "\\fB" + roff(names_of(*option)) + "\\fR";
            if (takes_value(*option)) text += " \\fI" + roff(option->get_type_name()) + "\\fR";
            text += "\n";
        }
        text += roff(option->get_description());
        const std::string usual = option->get_default_str();
        if (!usual.empty() && takes_value(*option)) text += " [" + roff(usual) + "]";
        text += "\n";
    }
    return text;
}

std::string heading(const std::string& name, const std::string& what)
{
    std::string upper = name;
    for (char& c : upper) c = char(std::toupper(static_cast<unsigned char>(c)));
    return ".TH " + roff(upper) + " 1 \"\" \"knead " + roff(knead_version()) +
           "\" \"User Commands\"\n.SH NAME\n" + roff(name) + " \\- " + roff(what) + "\n";
}

const CLI::App& verb_of(const CLI::App& app, const std::string& name)
{
    std::vector<std::string> names;
    for (const CLI::App* verb : verbs_of(app)) {
        if (verb->get_name() == name) return *verb;
        names.push_back(verb->get_name());
    }
    requested_names("verb", {name}, names);
    throw UsageError("no verb " + name);
}

// Escapes text inside shell quotes.
std::string shell_text(const std::string& text)
{
    std::string out;
    for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out;
}

std::string long_names(const CLI::App& verb)
{
    std::string all;
    for (const CLI::Option* option : verb.get_options())
        for (const std::string& name : option->get_lnames())
            all += (all.empty() ? "--" : " --") + name;
    return all;
}

// Shell words that list the possible arguments of a verb.
std::string words_of(const CLI::App& app, const std::string& verb)
{
    if (verb == "list") return "presets materials gestures scenes";
    if (verb == "record") return "$(knead list gestures 2>/dev/null | cut -d' ' -f1)";
    if (verb == "run" || verb == "info" || verb == "view" || verb == "vr")
        return "$(knead list scenes 2>/dev/null | cut -d' ' -f1)";
    std::string names;
    if (verb == "help") {
        for (const CLI::App* one : verbs_of(app)) names += one->get_name() + " ";
        names += "commands keys ";
    }
    return names;
}

std::string for_bash(const CLI::App& app)
{
    std::string names, cases;
    for (const CLI::App* verb : verbs_of(app)) {
        const std::string name = verb->get_name();
        names += (names.empty() ? "" : " ") + name;
        cases += "        " + name + ")\n            options='" + long_names(*verb) +
                 "'\n            words=\"" + words_of(app, name) + "\"\n            ;;\n";
    }
    return "# Completion of knead for bash.\n_knead() {\n"
           "    local word=${COMP_WORDS[COMP_CWORD]} options='' words=''\n"
           "    if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
           "        COMPREPLY=($(compgen -W '" +
           names +
           " --help --version' -- \"$word\"))\n        return\n    fi\n"
           "    case ${COMP_WORDS[1]} in\n" +
           cases +
           "    esac\n    case $word in\n"
           "        -*) COMPREPLY=($(compgen -W \"$options\" -- \"$word\")) ;;\n"
           "        *) COMPREPLY=($(compgen -W \"$words\" -- \"$word\") "
           "$(compgen -f -- \"$word\")) ;;\n"
           "    esac\n}\ncomplete -o filenames -F _knead knead\n";
}

std::string for_zsh(const CLI::App& app)
{
    const auto described = [](const std::string& text) {
        std::string out;
        for (const char c : text) {
            if (c == '[' || c == ']' || c == ':' || c == '\\') out += '\\';
            out += c;
        }
        return shell_text(out);
    };
    std::string verbs, cases;
    for (const CLI::App* verb : verbs_of(app)) {
        verbs += "        '" + verb->get_name() + ":" + described(verb->get_description()) + "'\n";
        cases += "        " + verb->get_name() + ") _arguments";
        for (const CLI::Option* option : verb->get_options())
            for (const std::string& name : option->get_lnames())
                cases += " \\\n            '--" + name + "[" +
                         described(option->get_description()) + "]" +
                         (takes_value(*option) ? ":value:_files'" : "'");
        const std::string words = shell_text(words_of(app, verb->get_name()));
        cases += " \\\n            '*:word:" +
                 (words.empty() ? "_files'" : "{ _files; compadd " + words + " }'") + " ;;\n";
    }
    return "#compdef knead\n# Completion of knead for zsh.\nlocal -a verbs\nverbs=(\n" + verbs +
           ")\nif (( CURRENT == 2 )); then\n    _describe verb verbs\nelse\n"
           "    local verb=$words[2]\n    shift words\n    (( CURRENT-- ))\n"
           "    case $verb in\n" +
           cases + "    esac\nfi\n";
}

}  // namespace

std::string manual_page(const CLI::App& app, const std::string& verb)
{
    if (!verb.empty()) {
        const CLI::App& one = verb_of(app, verb);
        return heading("knead-" + verb, one.get_description()) + ".SH SYNOPSIS\n" + use(one) +
               ".SH OPTIONS\n" + options_of(one) + ".SH SEE ALSO\n.BR knead (1)\n";
    }
    std::string page = heading("knead", app.get_description()) + ".SH SYNOPSIS\n";
    std::string also;
    for (const CLI::App* one : verbs_of(app)) page += use(*one) + ".br\n";
    page += ".SH VERBS\n";
    for (const CLI::App* one : verbs_of(app)) {
        page += ".TP\n.B " + roff(one->get_name()) + "\n" + roff(one->get_description()) + "\n";
        also += (also.empty() ? "" : ",\n") + std::string(".BR knead\\-") + roff(one->get_name()) +
                " (1)";
    }
    return page + ".SH EXIT STATUS\n" + roff(app.get_footer()) + "\n.SH SEE ALSO\n" + also + "\n";
}

void write_pages(const CLI::App& app, const std::string& folder)
{
    const std::string man = folder + "/man";
    const FolderLock lock = prepare_folder(folder, {}, true),
                     man_lock = prepare_folder(man, {}, true);
    write_whole(man + "/knead.1", manual_page(app, ""));
    for (const CLI::App* one : verbs_of(app))
        write_whole(man + "/knead-" + one->get_name() + ".1", manual_page(app, one->get_name()));
    write_whole(folder + "/knead.bash", for_bash(app));
    write_whole(folder + "/_knead", for_zsh(app));
}

std::string completion(const CLI::App& app, const std::string& shell)
{
    if (shell == "bash") return for_bash(app);
    if (shell == "zsh") return for_zsh(app);
    throw UsageError("--completion: expected bash or zsh, found \"" + shell + "\"");
}

}  // namespace knead
