#include "host/base/errors.h"

#include <cstdio>
#include <new>
#include <string>

namespace knead {

int run_and_report(const std::function<int()>& action)
{
    const auto say = [](const char* text, int code) {
        std::fprintf(stderr, "knead: %s\n", text);
        return code;
    };
    try {
        return action();
    } catch (const UsageError& e) {
        return say(e.what(), exit_usage);
    } catch (const MemoryError& e) {
        return say(e.what(), exit_resource);
    } catch (const InputError& e) {
        return say(e.what(), exit_input);
    } catch (const ResourceError& e) {
        return say(e.what(), exit_resource);
    } catch (const OutputError& e) {
        return say(e.what(), exit_output);
    } catch (const DeviceLost& e) {
        return say(e.what(), exit_device);
    } catch (const std::bad_alloc&) {
        return say("out of memory", exit_resource);
    } catch (const std::exception& e) {
        return say((std::string("internal error: ") + e.what()).c_str(), exit_check);
    }
}

}  // namespace knead
