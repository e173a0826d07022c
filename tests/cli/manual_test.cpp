// Pages of the manual and completion, made of a program of two verbs.
#include "host/cli/manual.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "tests/folder.h"

namespace knead {
namespace {

class Manual : public InFolder {
  protected:
    Manual()
    {
        app.footer(".5 is\nno request");
        CLI::App* run = app.add_subcommand("run", "Runs it: [all] don't ask");
        run->add_option("SCENE", scene, "what to run")->required();
        run->add_option("-o,--out-dir", out, "a folder; C:\\x")->default_str("here");
        run->add_flag("--quiet", quiet, "says nothing");
        app.add_subcommand("list", "Lists");
    }
    static bool has(const std::string& text, const std::string& part)
    {
        return text.find(part) != std::string::npos;
    }
    CLI::App app{"Shapes clay", "knead"};
    std::string scene, out;
    bool quiet = false;
};

TEST_F(Manual, APageOfAVerbShowsItsWordsAndOptions)
{
    const std::string page = manual_page(app, "run");
    EXPECT_EQ(page.find(".TH KNEAD\\-RUN 1 "), 0u) << page;
    for (const char* part :
         {"knead\\-run \\- Runs it: [all] don't ask\n",
          ".B knead run\n[\\fIOPTIONS\\fR] \\fISCENE\\fR\n", ".TP\n\\fISCENE\\fR\nwhat to run\n",
          "\\fB\\-o, \\-\\-out\\-dir\\fR \\fI", "a folder; C:\\ex [here]\n",
          "\\fB\\-\\-quiet\\fR\nsays nothing\n"})
        EXPECT_TRUE(has(page, part)) << part << " in\n" << page;
    EXPECT_THROW(manual_page(app, "rum"), UsageError);
}

TEST_F(Manual, ThePageOfTheProgramNamesItsVerbsAndHidesNoLine)
{
    const std::string page = manual_page(app, "");
    for (const char* part :
         {".TP\n.B run\n", ".TP\n.B list\nLists\n", ".BR knead\\-run (1),\n.BR knead\\-list (1)\n",
          ".SH EXIT STATUS\n\\&.5 is\nno request\n"})
        EXPECT_TRUE(has(page, part)) << part << " in\n" << page;
}

TEST_F(Manual, CompletionQuotesWhatAShellWouldRead)
{
    const std::string bash = completion(app, "bash"), zsh = completion(app, "zsh");
    EXPECT_TRUE(has(bash, "compgen -W 'run list --help --version'")) << bash;
    EXPECT_TRUE(has(bash, "--out-dir --quiet'")) << bash;
    EXPECT_TRUE(has(bash, "words=\"presets materials gestures scenes\"")) << bash;
    EXPECT_TRUE(has(zsh, "'run:Runs it\\: \\[all\\] don'\\''t ask'")) << zsh;
    EXPECT_TRUE(has(zsh, "'--out-dir[a folder; C\\:\\\\x]:value:_files'")) << zsh;
    EXPECT_TRUE(has(zsh, "'--quiet[says nothing]'")) << zsh;
    EXPECT_THROW(completion(app, "fish"), UsageError);
}

TEST_F(Manual, AllPagesAreWritten)
{
    write_pages(app, folder.string());
    const auto whole = [&](const char* name) { return read_text(path(name), 1 << 20); };
    EXPECT_EQ(whole("man/knead.1"), manual_page(app, ""));
    EXPECT_EQ(whole("man/knead-run.1"), manual_page(app, "run"));
    EXPECT_EQ(whole("man/knead-list.1"), manual_page(app, "list"));
    EXPECT_EQ(whole("knead.bash"), completion(app, "bash"));
    EXPECT_EQ(whole("_knead"), completion(app, "zsh"));
}

}  // namespace
}  // namespace knead
