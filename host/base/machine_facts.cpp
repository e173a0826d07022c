#include <nlohmann/json.hpp>

#include "host/base/machine.h"

namespace knead {

nlohmann::json machine_facts(bool gpu)
{
    nlohmann::json facts = {{"date", utc_now()},
                            {"host_name", host_name()},
                            {"num_cpus", cpu_count()},
                            {"cpu", cpu_name()},
#ifdef NDEBUG
                            {"library_build_type", "release"},
#else
                            {"library_build_type", "debug"},
#endif
                            {"knead_version", knead_version()},
                            {"commit", knead_commit()},
                            {"compiler", compiler_name()}};
    if (!gpu) return facts;
    if (const std::optional<GpuState> state = gpu_state(gpu_bus()))
        facts["gpu"] = {{"name", state->name},
                        {"driver", state->driver},
                        {"clock_MHz", state->clock},
                        {"most_clock_MHz", state->max_clock},
                        {"memory_clock_MHz", state->memory_clock},
                        {"power_limit_W", state->power_limit}};
    else
        facts["gpu"] = {{"driver", "unknown"}};
    return facts;
}

}  // namespace knead
