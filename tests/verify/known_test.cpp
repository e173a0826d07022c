// The file of known failures, and what report.md says of what failed.
#include "host/verify/known.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/verify/verify.h"
#include "tests/folder.h"

namespace knead {
namespace {

// The page's part from `head` to the next part.
std::string part_of(const std::string& page, const std::string& head)
{
    const std::size_t from = page.find(head);
    return from == page.npos ? "" : page.substr(from, page.find("\n## ", from) - from);
}

TEST(Known, TheOnesThatComeWithTheProgramHaveReasonsOfMoreThanAWord)
{
    const KnownFailures known = read_known("");
    EXPECT_EQ(known.problem, "");
    ASSERT_GE(known.why.size(), 20u);
    for (const auto& [name, why] : known.why) {
        EXPECT_GT(why.size(), 60u) << name;
        EXPECT_EQ(why.back(), '.') << name;
        EXPECT_EQ(why.find("  "), why.npos) << name;
    }
    EXPECT_EQ(known.why.count("dam, 24 cells wide: front at t sqrt(2g/a) = 0.832"), 1u);
}

class KnownFile : public InFolder {
  protected:
    // What is said of a file of this text; "" if it is read.
    std::string said_of(const std::string& text)
    {
        write_whole(path("known.json"), text);
        try {
            read_known(folder);
        } catch (const InputError& e) {
            return e.what();
        }
        return "";
    }
};

TEST_F(KnownFile, LinesOfAReasonAreOneText)
{
    EXPECT_EQ(said_of(R"({"schema": "knead.known/1", "failures": [
        {"why": ["Because", "of it."], "checks": ["a: b", "c"]},
        {"why": ["Other."], "checks": ["d"]}]})"),
              "");
    const KnownFailures known = read_known(folder);
    EXPECT_EQ(known.why,
              (std::map<std::string, std::string>{
                  {"a: b", "Because of it."}, {"c", "Because of it."}, {"d", "Other."}}));
}

TEST_F(KnownFile, WhatIsWrongIsSaidWithItsPlace)
{
    const std::string head = R"({"schema": "knead.known/1", "failures": )";
    EXPECT_NE(said_of(R"({"schema": "knead.known/2", "failures": []})").find("knead.known/1"),
              std::string::npos);
    EXPECT_NE(said_of(head + "{}}").find("/failures"), std::string::npos);
    for (const char* one :
         {R"({"checks": ["a"]})", R"({"why": [], "checks": ["a"]})", R"({"why": ["b"]})",
          R"({"why": [""], "checks": ["a"]})", R"({"why": ["b"], "checks": [7]})",
          R"({"why": "b", "checks": ["a"]})", R"({"why": ["b"], "checks": ["a"], "more": 1})",
          R"({"why": ["b"], "checks": ["a", "a"]})"})
        EXPECT_NE(said_of(head + "[" + one + "]}").find("/failures/0"), std::string::npos) << one;
}

TEST_F(KnownFile, NoFileIsNoFaultAndIsSaid)
{
    const KnownFailures none = read_known(folder);
    EXPECT_TRUE(none.why.empty());
    EXPECT_NE(none.problem.find("no file " + path("known.json")), std::string::npos);
}

// A check that is known to fail, one that is not, one that passes though it is known to fail.
TEST_F(KnownFile, WhatNobodyKnowsAReasonForStandsOut)
{
    write_whole(path("known.json"), R"({"schema": "knead.known/1", "failures": [
        {"why": ["Too few cells."], "checks": ["known one", "mended one"]}]})");
    VerifyOptions o;
    o.device = "cpu", o.quiet = true, o.data = folder;
    Verification v(o);
    v.add(near("known one", 2, 1, 0.5, "m", "refine"));
    v.add(near("new one", 3, 1, 0.5, "", ""));
    v.add(near("mended one", 1, 1, 0.5, ""));
    v.add(near("sound one", 1, 1, 0.5, ""));

    const std::string page = verify_page(v), bad = part_of(page, "## FAILED, and nobody"),
                      rest = part_of(page, "## What failed, why");
    EXPECT_NE(bad.find("**new one**: 3, expected 1 +- 0.5\n  Why: not known yet\n"), bad.npos);
    EXPECT_EQ(bad.find("known one"), bad.npos);
    EXPECT_NE(rest.find("**known one**: 2 m, expected 1 +- 0.5\n  Why: Too few cells.\n"
                        "  What to do: refine.\n"),
              rest.npos);
    EXPECT_EQ(rest.find("new one"), rest.npos);
    EXPECT_LT(page.find("nobody knows why"), page.find("## What failed, why"));
    EXPECT_EQ(page.find("**mended"), page.npos);
    EXPECT_EQ(page.find("**sound"), page.npos);

    const Json checks = verify_json(v)["checks"];
    EXPECT_EQ(checks[0]["why"], "Too few cells.");
    EXPECT_TRUE(checks[1]["why"].is_null());
    EXPECT_EQ(checks[2]["why"], "");
    const char* known[] = {"known", "not known", "passes now", ""};
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(checks[i]["known"], known[i]);
    EXPECT_NE(verify_csv(v).find(",not known\n"), std::string::npos);
    EXPECT_NE(verify_summary(v).find("2 FAILED, 1 of them for no known reason"), std::string::npos);
}

TEST(Known, WhereAllPassedThePageHasNoPartOfFailures)
{
    EXPECT_EQ(failed_page({near("sound", 1, 1, 0.5, "")}), "");
}

}  // namespace
}  // namespace knead
