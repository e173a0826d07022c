// A library under the name of the GPU driver's own (NVML) that knows one card. The call that the
// environment names in KNEAD_FAKE_REFUSES is answered with an error.
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

int answer(const char* call)
{
    const char* const refused = std::getenv("KNEAD_FAKE_REFUSES");
    return refused && std::strcmp(refused, call) == 0 ? 3 : 0;
}

int card;
int of_card(const void* unit, const char* call) { return unit == &card ? answer(call) : 2; }

}  // namespace

extern "C" {

int nvmlInit_v2() { return answer("init"); }
int nvmlShutdown() { return 0; }
int nvmlDeviceGetHandleByPciBusId_v2(const char* bus, void** unit)
{
    *unit = &card;
    return std::strcmp(bus, "0000:41:00.0") == 0 ? answer("handle") : 6;
}
int nvmlDeviceGetName(void* unit, char* text, unsigned size)
{
    std::snprintf(text, size, "a card");
    return of_card(unit, "name");
}
int nvmlSystemGetDriverVersion(char* text, unsigned size)
{
    std::snprintf(text, size, "570.1");
    return answer("driver");
}
int nvmlDeviceGetClockInfo(void* unit, int which, unsigned* clock)
{
    *clock = which == 1 ? 1755 : which == 2 ? 2619 : 0;
    return of_card(unit, "clock");
}
int nvmlDeviceGetMaxClockInfo(void* unit, int which, unsigned* clock)
{
    *clock = which == 1 ? 1980 : 0;
    return of_card(unit, "max_clock");
}
int nvmlDeviceGetPowerManagementLimit(void* unit, unsigned* milliwatts)
{
    *milliwatts = 699500;
    return of_card(unit, "power");
}

}  // extern "C"
