// knead record: writes hands to a file; without a headset, those of a scripted gesture.
#include <fmt/format.h>

#include "host/base/errors.h"
#include "host/base/outputs.h"
#include "host/base/paths.h"
#include "host/base/print.h"
#include "host/cli/verbs.h"
#include "host/hands/gesture.h"
#include "host/hands/recording.h"

namespace knead {

int record_verb(const RecordOptions& o)
{
    if (o.live || o.gesture == "live" || o.gesture == "headset") {
        const std::string named = o.out.empty() && o.live ? o.gesture : o.out;
        throw UsageError(
            "knead record makes the hands of a gesture; hands in a headset are recorded by\n"
            "  knead vr SCENE --record " +
            (named.empty() ? "FILE" : named) + "\nand --hands-only leaves the simulation out");
    }
    if (o.gesture.empty() || o.out.empty())
        throw UsageError("knead record needs a GESTURE and a file OUT (knead list gestures)");
    const std::string form = ending(o.out);
    if (form != ".hands" && form != ".jsonl")
        throw UsageError("OUT: expected a file ending in .hands or .jsonl, found \"" + o.out +
                         "\"");
    GestureOptions options;
    options.rate = o.rate, options.seconds = o.seconds, options.jitter = o.jitter;
    options.dropouts = o.dropouts, options.latency = o.latency;
    options.radius = o.radius, options.depth = o.depth, options.seed = o.seed;
    const Recording made = generate(o.gesture, options);
    prepare_file(o.out, o.overwrite);
    write_recording(o.out, made);
    if (!o.quiet)
        print(fmt::format("{}: {}, {} frames, {:.4g} s at {:.4g} frames/s\n", o.out, made.name,
                          made.frames.size(), made.frames.back().time, made.rate));
    return exit_ok;
}

}  // namespace knead
