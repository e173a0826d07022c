// Diagnosis of the OpenXR installation: loader, manifest, extensions, headset.
#include <memory>
#include <mutex>

#include "host/base/abandonable.h"
#include "xr/advice.h"
#include "xr/extensions.h"
#include "xr/headset.h"
#include "xr/instance.h"

namespace knead {
namespace {

// Calls `found` with the results so far after each step: any step may block forever.
void probe_runtime(RuntimeInfo facts, const std::function<void(const RuntimeInfo&)>& found)
{
    try {
        const auto entry = xr::loader();
        facts.loader = true;
        found(facts);
#ifndef _WIN32
        if (facts.manifest.empty())
            throw HeadsetError("no OpenXR runtime is active: " + xr::start_advice());
#endif
        const std::vector<std::string> offered = xr::offered_extensions(entry);
        const xr::Enabled has = xr::enabled_of(offered);
        facts.runtime = true;
        facts.used = has.names(), facts.missing = has.missing();
        found(facts);
        const xr::Instance instance(entry, offered, "");
        facts.headset = instance.system_name;
        facts.reason.clear();
        found(facts);
    } catch (const std::exception& e) {
        facts.reason = e.what();
        found(facts);
    }
}

}  // namespace

RuntimeInfo runtime_facts(double patience)
{
    struct Known {
        std::mutex lock;
        RuntimeInfo facts;
    };
    const auto known = std::make_shared<Known>();
    known->facts.built = true;
    known->facts.manifest = xr::runtime_manifest();
    known->facts.reason = xr::no_answer(patience);
    AbandonableThread thread([known, first = known->facts] {
        probe_runtime(first, [&](const RuntimeInfo& found) {
            const std::lock_guard held(known->lock);
            known->facts = found;
        });
    });
    thread.finished_within(patience);
    const std::lock_guard held(known->lock);
    return known->facts;
}

}  // namespace knead
