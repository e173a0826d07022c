#include "host/base/machine.h"

#include <dlfcn.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <memory>
#include <thread>

#include "host/base/container.h"

#if __has_include("knead_commit.h")
#include "knead_commit.h"
#endif

namespace knead {
namespace {

struct Unload {
    void operator()(void* library) const { dlclose(library); }
};

// NVML, the driver's management library, loaded at run time: available without CUDA.
class Driver {
  public:
    Driver() : library(dlopen("libnvidia-ml.so.1", RTLD_NOW | RTLD_LOCAL))
    {
        good = library && ask("nvmlInit_v2");
    }
    Driver(const Driver&) = delete;
    ~Driver()
    {
        if (good) ask("nvmlShutdown");
    }
    explicit operator bool() const { return good; }
    // True if the function exists and returns 0 (success).
    template <class... A>
    bool ask(const char* name, A... arguments) const
    {
        const auto call = reinterpret_cast<int (*)(A...)>(dlsym(library.get(), name));
        return call && call(arguments...) == 0;
    }

  private:
    std::unique_ptr<void, Unload> library;
    bool good = false;
};

}  // namespace

std::string host_name()
{
    char name[256] = {};
    return gethostname(name, sizeof name - 1) == 0 ? name : "unknown";
}

std::string cpu_name()
{
    std::ifstream in("/proc/cpuinfo");
    for (std::string line; std::getline(in, line);)
        if (line.starts_with("model name")) {
            const std::size_t colon = line.find(": ");
            if (colon != std::string::npos) return line.substr(colon + 2);
        }
    return "unknown";
}

int cpu_count()
{
    const int all = std::max(1, int(std::thread::hardware_concurrency()));
    const std::optional<double> quota = container_limits().cpus;
    // Round up: a fraction of a processor is one that is throttled.
    return quota && *quota < all ? std::max(1, int(std::ceil(*quota))) : all;
}

std::size_t total_memory()
{
    const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGE_SIZE);
    const std::size_t all = pages > 0 && page > 0 ? std::size_t(pages) * std::size_t(page) : 0;
    return std::min(all, container_limits().memory.value_or(all));
}

std::size_t available_memory()
{
    std::size_t all = std::size_t(4) << 30;  // if unknown: a conservative value
    std::ifstream in("/proc/meminfo");
    std::string key, unit;
    for (std::size_t kib; in >> key >> kib; std::getline(in, unit))
        if (key == "MemAvailable:") {
            all = kib * 1024;
            break;
        }
    return std::min(all, container_limits().free.value_or(all));
}

std::string compiler_name() { return "g++ or compatible " __VERSION__; }

std::string knead_version()
{
#ifdef KNEAD_VERSION
    return KNEAD_VERSION;
#else
    return "0.1.0";
#endif
}

std::string knead_commit()
{
#ifdef KNEAD_COMMIT
    return KNEAD_COMMIT;
#else
    return "unknown";
#endif
}

std::optional<GpuState> gpu_state(const std::string& bus)
{
    using Unit = struct Opaque*;
    constexpr int multiprocessor = 1, memory = 2;  // clock types of NVML
    const Driver driver;
    Unit unit = nullptr;
    if (bus.empty() || !driver ||
        !driver.ask("nvmlDeviceGetHandleByPciBusId_v2", bus.c_str(), &unit))
        return {};
    GpuState state;
    char text[128] = {};
    const auto size = unsigned(sizeof text - 1);
    unsigned milliwatts = 0;
    if (driver.ask("nvmlDeviceGetName", unit, text, size)) state.name = text;
    if (driver.ask("nvmlSystemGetDriverVersion", text, size)) state.driver = text;
    driver.ask("nvmlDeviceGetClockInfo", unit, multiprocessor, &state.clock);
    driver.ask("nvmlDeviceGetMaxClockInfo", unit, multiprocessor, &state.max_clock);
    driver.ask("nvmlDeviceGetClockInfo", unit, memory, &state.memory_clock);
    if (driver.ask("nvmlDeviceGetPowerManagementLimit", unit, &milliwatts))
        state.power_limit = 1e-3 * milliwatts;
    return state;
}

std::string utc_now()
{
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    gmtime_r(&now, &parts);
    char text[32];
    std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
    return text;
}

double wall_seconds()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

void default_variable(const char* name, const char* value) { ::setenv(name, value, 0); }

double thread_seconds()
{
    timespec used{};
    if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used) != 0) return 0;
    return double(used.tv_sec) + 1e-9 * double(used.tv_nsec);
}

double process_seconds()
{
    rusage used{};
    if (getrusage(RUSAGE_SELF, &used) != 0) return 0;
    const auto seconds = [](const timeval& t) {
        return double(t.tv_sec) + 1e-6 * double(t.tv_usec);
    };
    return seconds(used.ru_utime) + seconds(used.ru_stime);
}

}  // namespace knead
