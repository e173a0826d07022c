// Checks that fail today, each with the reason: profiling/known.json.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "host/verify/check.h"

namespace knead {

struct KnownFailures {
    std::map<std::string, std::string> why;  // by the check's name
    std::string problem;                     // why there is no such file; "" if there is
};

// known.json of `folder`; "": that which comes with the program. A file that is not there is no
// fault. Throws InputError with file and place for one that is wrong, or that names a check twice.
KnownFailures read_known(const std::string& folder);

// What stands beside a verdict: "known" or "not known" of one that failed, "passes now" of a check
// that the file says fails; else "".
const char* known_name(const Check& check);

// The part of report.md on what failed: first what nobody knows a reason for. "" where all passed.
std::string failed_page(const std::vector<Check>& checks);

}  // namespace knead
