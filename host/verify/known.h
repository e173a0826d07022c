// Known failures of checks, each with the reason: profiling/known.json.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "host/verify/check.h"

namespace knead {

struct KnownFailures {
    std::map<std::string, std::string> why;  // by the check's name
    std::string problem;                     // why there is no file; "": read
};

// Reads known.json of `folder`; "": the bundled one. A missing file is not an error. Throws
// InputError with file and place for an invalid file or a duplicate check.
KnownFailures read_known(const std::string& folder);

// Remark beside a verdict: "known" or "not known" for a failure, "passes now" for a listed check
// that passes; else "".
const char* known_name(const Check& check);

// Section of report.md on failed checks, those without a known reason first; "": all passed.
std::string failed_page(const std::vector<Check>& checks);

}  // namespace knead
