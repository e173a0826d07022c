// knead session: sessions that can be recovered; checks a session's file, and makes it smaller.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/interrupt.h"
#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/base/print.h"
#include "host/cli/verbs.h"
#include "host/session/session_file.h"
#include "host/ui/session_line.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

int list(const SessionVerbOptions& o)
{
    Json all = Json::array();
    for (const Recoverable& one : recoverable_sessions()) {
        all.push_back({{"file", one.file},
                       {"scene", one.scene},
                       {"age_s", std::round(one.age)},
                       {"steps", one.steps},
                       {"picture", !one.picture.empty()}});
        if (!o.json)
            print(fmt::format("{}\n    of {}, {} steps, {} ago\n", one.file, one.scene, one.steps,
                              duration_text(one.age)));
    }
    if (o.json) print(all.dump(2) + "\n");
    if (!o.json && all.empty()) print("nothing to recover\n");
    return exit_ok;
}

int verify(const SessionVerbOptions& o)
{
    const SessionFile file(o.file);
    watch_interrupts();
    verify_session(file, [] { return interrupted() != 0; });
    if (interrupted()) return 128 + interrupted();
    const std::string& tail = file.chunks().broken_by();
    if (o.json) {
        print(Json{{"valid", true},
                   {"bytes", file.chunks().end()},
                   {"frames", file.frames()},
                   {"steps", file.steps()},
                   {"cut", tail}}
                  .dump() +
              "\n");
    } else {
        print(fmt::format("{}: valid; {} frames, {} steps, {} bytes\n", o.file, file.frames(),
                          file.steps(), file.chunks().end()));
        if (!tail.empty()) print(fmt::format("what follows is left out: {}\n", tail));
    }
    return exit_ok;
}

int compact(const SessionVerbOptions& o)
{
    const SessionFile file(o.file);
    const std::string to = o.out.empty() ? o.file : o.out;
    if (!o.out.empty()) prepare_file(o.out, o.overwrite);
    compact_session(file, to);
    if (!o.quiet)
        print(fmt::format("{}: {} bytes of {}; it cannot be replayed\n", to, fs::file_size(to),
                          file.chunks().size()));
    return exit_ok;
}

}  // namespace

int session_verb(const SessionVerbOptions& o)
{
    if (o.action == "list") return list(o);
    if (o.file.empty()) throw UsageError("knead session " + o.action + " needs a FILE");
    if (!o.out.empty() && o.action != "compact") throw UsageError("--out: only with compact");
    return o.action == "verify" ? verify(o) : compact(o);
}

}  // namespace knead
