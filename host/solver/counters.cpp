#include "host/solver/counters.h"

#include <stdexcept>

#ifdef KNEAD_HAS_CUPTI
#include <cupti_profiler_host.h>
#include <cupti_profiler_target.h>
#include <cupti_range_profiler.h>
#include <cupti_result.h>
#include <cupti_target.h>
#include <dlfcn.h>

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#endif

namespace knead {

DeviceWork& DeviceWork::operator+=(const DeviceWork& more)
{
    instructions += more.instructions;
    memory_bytes += more.memory_bytes, cache_bytes += more.cache_bytes;
    cycles += more.cycles, seconds += more.seconds;
    return *this;
}

DeviceWork operator*(double factor, const DeviceWork& c)
{
    return {factor * c.instructions, factor * c.memory_bytes, factor * c.cache_bytes,
            factor * c.cycles, factor * c.seconds};
}

#ifndef KNEAD_HAS_CUPTI
std::vector<StageWork> counted(const std::function<void(const StageObserver&)>&)
{
    throw std::runtime_error("counters: this build has none (it found no CUPTI 12.6 or newer)");
}
#else
namespace {

// Supported by every card with its own memory from Turing to Blackwell, in a single pass.
const std::array<const char*, 5> metrics{"smsp__inst_executed.sum", "dram__bytes.sum",
                                         "lts__t_bytes.sum", "sm__cycles_elapsed.max",
                                         "gpu__time_duration.sum"};
constexpr std::size_t max_ranges = 256;

template <class Parameters>
Parameters sized(std::size_t bytes)
{
    Parameters p{};
    p.structSize = bytes;
    return p;
}

// CUPTI, loaded at run time: it is part of the toolkit, not of the driver.
class Library {
  public:
    Library()
    {
        const std::string name = "libcupti.so." + std::to_string(CUDA_VERSION / 1000);
        for (const char* folder : {"", "/usr/local/cuda/extras/CUPTI/lib64/",
                                   "/usr/local/cuda/lib64/", "/usr/lib/x86_64-linux-gnu/"})
            if (!opened) opened = dlopen((folder + name).c_str(), RTLD_NOW | RTLD_LOCAL);
        if (!opened)
            throw std::runtime_error("counters: " + name +
                                     " was not found; it is part of the CUDA toolkit, and may be "
                                     "named by LD_LIBRARY_PATH");
    }
    Library(const Library&) = delete;  // never closed: it stays attached to the driver

    template <class Parameters>
    CUptiResult ask(const char* name, Parameters& parameters) const
    {
        const auto call = reinterpret_cast<CUptiResult (*)(Parameters*)>(dlsym(opened, name));
        return call ? call(&parameters) : CUPTI_ERROR_NOT_SUPPORTED;
    }
    template <class Parameters>
    void call(const char* name, Parameters& parameters) const
    {
        const CUptiResult result = ask(name, parameters);
        if (result == CUPTI_SUCCESS) return;
        throw std::runtime_error(std::string("counters: ") + name + ": " + said(result));
    }

  private:
    std::string said(CUptiResult result) const
    {
        if (result == CUPTI_ERROR_INSUFFICIENT_PRIVILEGES)
            return "only root may count here; the driver's option "
                   "NVreg_RestrictProfilingToAdminUsers=0 lets everyone";
        const char* text = nullptr;
        const auto name = reinterpret_cast<CUptiResult (*)(CUptiResult, const char**)>(
            dlsym(opened, "cuptiGetResultString"));
        if (name && name(result, &text) == CUPTI_SUCCESS && text) return text;
        return "error " + std::to_string(int(result));
    }
    void* opened = nullptr;
};

// Context and device of the calling thread.
struct Current {
    CUcontext context = nullptr;
    CUdevice device = 0;
    Current()
    {
        void* const driver = dlopen("libcuda.so.1", RTLD_NOW | RTLD_LOCAL);
        if (!driver) return;
        const auto ask = [&](const char* name, auto* answer) {
            const auto call = reinterpret_cast<CUresult (*)(decltype(answer))>(dlsym(driver, name));
            return call && call(answer) == CUDA_SUCCESS;
        };
        if (!ask("cuCtxGetCurrent", &context) || !ask("cuCtxGetDevice", &device)) context = nullptr;
    }
};

// Metrics of one chip: creates the counter configuration and evaluates counter images.
class Evaluation {
  public:
    Evaluation(const Library& library, const Current& current) : cupti(library)
    {
        auto chip =
            sized<CUpti_Device_GetChipName_Params>(CUpti_Device_GetChipName_Params_STRUCT_SIZE);
        chip.deviceIndex = std::size_t(current.device);
        cupti.call("cuptiDeviceGetChipName", chip);
        auto counters = sized<CUpti_Profiler_GetCounterAvailability_Params>(
            CUpti_Profiler_GetCounterAvailability_Params_STRUCT_SIZE);
        counters.ctx = current.context;
        cupti.call("cuptiProfilerGetCounterAvailability", counters);
        available.resize(counters.counterAvailabilityImageSize);
        counters.pCounterAvailabilityImage = available.data();
        cupti.call("cuptiProfilerGetCounterAvailability", counters);
        auto made = sized<CUpti_Profiler_Host_Initialize_Params>(
            CUpti_Profiler_Host_Initialize_Params_STRUCT_SIZE);
        made.profilerType = CUPTI_PROFILER_TYPE_RANGE_PROFILER;
        made.pChipName = chip.pChipName;
        made.pCounterAvailabilityImage = available.data();
        cupti.call("cuptiProfilerHostInitialize", made);
        host = made.pHostObject;
    }
    Evaluation(const Evaluation&) = delete;
    ~Evaluation()
    {
        auto end = sized<CUpti_Profiler_Host_Deinitialize_Params>(
            CUpti_Profiler_Host_Deinitialize_Params_STRUCT_SIZE);
        end.pHostObject = host;
        cupti.ask("cuptiProfilerHostDeinitialize", end);
    }
    std::vector<std::uint8_t> configuration()
    {
        auto wanted = sized<CUpti_Profiler_Host_ConfigAddMetrics_Params>(
            CUpti_Profiler_Host_ConfigAddMetrics_Params_STRUCT_SIZE);
        wanted.pHostObject = host;
        wanted.ppMetricNames = names.data(), wanted.numMetrics = names.size();
        cupti.call("cuptiProfilerHostConfigAddMetrics", wanted);
        auto size = sized<CUpti_Profiler_Host_GetConfigImageSize_Params>(
            CUpti_Profiler_Host_GetConfigImageSize_Params_STRUCT_SIZE);
        size.pHostObject = host;
        cupti.call("cuptiProfilerHostGetConfigImageSize", size);
        std::vector<std::uint8_t> bytes(size.configImageSize);
        auto image = sized<CUpti_Profiler_Host_GetConfigImage_Params>(
            CUpti_Profiler_Host_GetConfigImage_Params_STRUCT_SIZE);
        image.pHostObject = host;
        image.configImageSize = bytes.size(), image.pConfigImage = bytes.data();
        cupti.call("cuptiProfilerHostGetConfigImage", image);
        return bytes;
    }
    DeviceWork of(const std::vector<std::uint8_t>& counters, std::size_t range)
    {
        std::array<double, metrics.size()> value{};
        auto range_of = sized<CUpti_Profiler_Host_EvaluateToGpuValues_Params>(
            CUpti_Profiler_Host_EvaluateToGpuValues_Params_STRUCT_SIZE);
        range_of.pHostObject = host;
        range_of.pCounterDataImage = counters.data();
        range_of.counterDataImageSize = counters.size(), range_of.rangeIndex = range;
        range_of.ppMetricNames = names.data(), range_of.numMetrics = names.size();
        range_of.pMetricValues = value.data();
        cupti.call("cuptiProfilerHostEvaluateToGpuValues", range_of);
        for (double v : value)
            if (!std::isfinite(v) || v < 0) throw std::runtime_error("counters: no values");
        return {value[0], value[1], value[2], value[3], 1e-9 * value[4]};
    }
    std::array<const char*, metrics.size()> names = metrics;

  private:
    const Library& cupti;
    std::vector<std::uint8_t> available;
    CUpti_Profiler_Host_Object* host = nullptr;
};

// Device side: counts between the two ends of a range.
class Ranges {
  public:
    Ranges(const Library& library, const Current& current, Evaluation& evaluation)
        : cupti(library), configuration(evaluation.configuration())
    {
        auto enabled =
            sized<CUpti_RangeProfiler_Enable_Params>(CUpti_RangeProfiler_Enable_Params_STRUCT_SIZE);
        enabled.ctx = current.context;
        cupti.call("cuptiRangeProfilerEnable", enabled);
        object = enabled.pRangeProfilerObject;
        try {
            make_room(evaluation);
        } catch (...) {
            disable();
            throw;
        }
    }
    Ranges(const Ranges&) = delete;
    ~Ranges() { disable(); }

    // Repeats `work` for every pass; returns the counter image.
    const std::vector<std::uint8_t>& count(const std::function<void()>& work)
    {
        for (bool all = false; !all;) {
            call<CUpti_RangeProfiler_Start_Params>("cuptiRangeProfilerStart",
                                                   CUpti_RangeProfiler_Start_Params_STRUCT_SIZE);
            work();
            all = call<CUpti_RangeProfiler_Stop_Params>("cuptiRangeProfilerStop",
                                                        CUpti_RangeProfiler_Stop_Params_STRUCT_SIZE)
                      .isAllPassSubmitted;
        }
        if (call<CUpti_RangeProfiler_DecodeData_Params>(
                "cuptiRangeProfilerDecodeData", CUpti_RangeProfiler_DecodeData_Params_STRUCT_SIZE)
                .numOfRangeDropped)
            throw std::runtime_error("counters: more stages than there is room for");
        return counters;
    }
    void around(const std::string& name, const std::function<void()>& run)
    {
        auto begin = sized<CUpti_RangeProfiler_PushRange_Params>(
            CUpti_RangeProfiler_PushRange_Params_STRUCT_SIZE);
        begin.pRangeProfilerObject = object, begin.pRangeName = name.c_str();
        cupti.call("cuptiRangeProfilerPushRange", begin);
        run();
        call<CUpti_RangeProfiler_PopRange_Params>("cuptiRangeProfilerPopRange",
                                                  CUpti_RangeProfiler_PopRange_Params_STRUCT_SIZE);
    }
    std::size_t ranges() const
    {
        auto info = sized<CUpti_RangeProfiler_GetCounterDataInfo_Params>(
            CUpti_RangeProfiler_GetCounterDataInfo_Params_STRUCT_SIZE);
        info.pCounterDataImage = counters.data(), info.counterDataImageSize = counters.size();
        cupti.call("cuptiRangeProfilerGetCounterDataInfo", info);
        return info.numTotalRanges;
    }
    std::string name(std::size_t range) const
    {
        auto info = sized<CUpti_RangeProfiler_CounterData_GetRangeInfo_Params>(
            CUpti_RangeProfiler_CounterData_GetRangeInfo_Params_STRUCT_SIZE);
        info.pCounterDataImage = counters.data(), info.counterDataImageSize = counters.size();
        info.rangeIndex = range, info.rangeDelimiter = "/";
        cupti.call("cuptiRangeProfilerCounterDataGetRangeInfo", info);
        return info.rangeName ? info.rangeName : "";
    }

  private:
    template <class Parameters>
    Parameters call(const char* name, std::size_t size) const
    {
        auto p = sized<Parameters>(size);
        p.pRangeProfilerObject = object;
        cupti.call(name, p);
        return p;
    }
    void make_room(Evaluation& evaluation)
    {
        auto size = sized<CUpti_RangeProfiler_GetCounterDataSize_Params>(
            CUpti_RangeProfiler_GetCounterDataSize_Params_STRUCT_SIZE);
        size.pRangeProfilerObject = object;
        size.pMetricNames = evaluation.names.data(), size.numMetrics = evaluation.names.size();
        size.maxNumOfRanges = max_ranges, size.maxNumRangeTreeNodes = max_ranges;
        cupti.call("cuptiRangeProfilerGetCounterDataSize", size);
        counters.resize(size.counterDataSize);
        auto room = sized<CUpti_RangeProfiler_CounterDataImage_Initialize_Params>(
            CUpti_RangeProfiler_CounterDataImage_Initialize_Params_STRUCT_SIZE);
        room.pRangeProfilerObject = object;
        room.counterDataSize = counters.size(), room.pCounterData = counters.data();
        cupti.call("cuptiRangeProfilerCounterDataImageInitialize", room);
        auto set = sized<CUpti_RangeProfiler_SetConfig_Params>(
            CUpti_RangeProfiler_SetConfig_Params_STRUCT_SIZE);
        set.pRangeProfilerObject = object;
        set.configSize = configuration.size(), set.pConfig = configuration.data();
        set.counterDataImageSize = counters.size(), set.pCounterDataImage = counters.data();
        set.range = CUPTI_UserRange, set.replayMode = CUPTI_UserReplay;
        set.maxRangesPerPass = max_ranges;
        set.numNestingLevels = 1, set.minNestingLevel = 1, set.targetNestingLevel = 1;
        cupti.call("cuptiRangeProfilerSetConfig", set);
    }
    void disable()
    {
        auto end = sized<CUpti_RangeProfiler_Disable_Params>(
            CUpti_RangeProfiler_Disable_Params_STRUCT_SIZE);
        end.pRangeProfilerObject = object;
        cupti.ask("cuptiRangeProfilerDisable", end);
    }

    const Library& cupti;
    CUpti_RangeProfiler_Object* object = nullptr;
    std::vector<std::uint8_t> configuration, counters;
};

// CUPTI is attached to the driver during the lifetime of this object.
struct Hook {
    const Library& cupti;
    explicit Hook(const Library& library) : cupti(library)
    {
        auto begin =
            sized<CUpti_Profiler_Initialize_Params>(CUpti_Profiler_Initialize_Params_STRUCT_SIZE);
        cupti.call("cuptiProfilerInitialize", begin);
    }
    Hook(const Hook&) = delete;
    ~Hook()
    {
        auto end = sized<CUpti_Profiler_DeInitialize_Params>(
            CUpti_Profiler_DeInitialize_Params_STRUCT_SIZE);
        cupti.ask("cuptiProfilerDeInitialize", end);
    }
};

}  // namespace

std::vector<StageWork> counted(const std::function<void(const StageObserver&)>& work)
{
    const Current current;
    if (!current.context) throw std::runtime_error("counters: this thread uses no CUDA device");
    static const Library cupti;
    const Hook hook(cupti);
    Evaluation evaluation(cupti, current);
    Ranges ranges(cupti, current, evaluation);
    std::vector<StageWork> stages;
    const std::vector<std::uint8_t> counters = ranges.count([&] {
        stages.clear();
        work([&](const char* stage, const std::function<void()>& run) {
            ranges.around(std::to_string(stages.size()), run);
            stages.push_back({stage, {}});
        });
    });
    std::size_t found = 0;
    for (std::size_t r = 0; r < ranges.ranges(); ++r) {
        const std::string name = ranges.name(r);
        std::size_t stage = stages.size();
        std::from_chars(name.data(), name.data() + name.size(), stage);
        if (stage >= stages.size()) continue;
        stages[stage].work = evaluation.of(counters, r);
        ++found;
    }
    if (found != stages.size())
        throw std::runtime_error("counters: of " + std::to_string(stages.size()) + " stages " +
                                 std::to_string(found) + " were counted");
    return stages;
}
#endif

}  // namespace knead
