#include "host/verify/known.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/base/json_reader.h"
#include "host/base/paths.h"

namespace knead {
namespace {

// A list of non-empty strings.
std::vector<std::string> texts(ObjectReader& r, const std::string& key)
{
    const char* const expected = "a list of texts, one or more";
    const Json& list = r.required(key, expected);
    if (!list.is_array() || list.empty()) r.fail(key, expected, described(list));
    std::vector<std::string> all;
    for (const Json& text : list) {
        if (!text.is_string() || text.get<std::string>().empty())
            r.fail(key, expected, described(text));
        all.push_back(text.get<std::string>());
    }
    return all;
}

void read_reason(ObjectReader& r, KnownFailures& known)
{
    std::string why;
    for (const std::string& line : texts(r, "why")) why += (why.empty() ? "" : " ") + line;
    for (const std::string& name : texts(r, "checks"))
        if (!known.why.emplace(name, why).second)
            r.fail("checks", "names that are in no other list", "\"" + name + "\"");
}

std::string told_failure(const Check& c)
{
    std::string text = fmt::format("- **{}**: {}\n", c.name, measured_text(c));
    if (!c.note.empty()) text += "  " + c.note + ".\n";
    text += "  Why: " + (c.why.empty() ? "not known yet" : c.why) + "\n";
    return text + "  What to do: " + (c.advice.empty() ? "report it" : c.advice) + ".\n";
}

}  // namespace

KnownFailures read_known(const std::string& folder)
{
    KnownFailures known;
    const std::string own = "profiling/known.json", found = shipped(own),
                      file = !folder.empty()
                                 ? (std::filesystem::path(folder) / "known.json").string()
                             : found.empty() ? own
                                             : found;
    if (!std::filesystem::exists(file)) {
        known.problem = "no file " + file + " (--data says where): no reason of any failure";
        return known;
    }
    const Json root = read_json(file);
    ObjectReader::read(root, file, "", [&](ObjectReader& r) {
        r.required("schema", "\"knead.known/1\"");
        const std::string schema = r.text("schema", "");
        if (schema != "knead.known/1") r.fail("schema", "\"knead.known/1\"", "\"" + schema + "\"");
        const Json& list = r.required("failures", "a list of objects");
        if (!list.is_array()) r.fail("failures", "a list of objects", described(list));
        for (std::size_t i = 0; i < list.size(); ++i)
            ObjectReader::read(list[i], file, r.pointer("failures") + "/" + std::to_string(i),
                               [&](ObjectReader& one) { read_reason(one, known); });
    });
    return known;
}

const char* known_name(const Check& c)
{
    if (c.verdict == Verdict::passed) return c.why.empty() ? "" : "passes now";
    return c.why.empty() ? "not known" : "known";
}

std::string failed_page(const std::vector<Check>& checks)
{
    std::string unknown, known;
    for (const Check& c : checks)
        if (c.verdict == Verdict::failed) (c.why.empty() ? unknown : known) += told_failure(c);
    std::string text;
    if (!unknown.empty())
        text +=
            "\n## FAILED, and nobody knows why\n\nNo reason for these is in `known.json`: "
            "either they passed before, or this machine differs.\n\n" +
            unknown;
    if (!known.empty()) text += "\n## What failed, why, and what to do\n\n" + known;
    return text;
}

}  // namespace knead
