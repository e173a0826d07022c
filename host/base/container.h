// Resource limits of a container: control groups, version 1 and 2.
#pragma once
#include <cstddef>
#include <optional>
#include <string>

namespace knead {

struct ContainerLimits {
    std::optional<std::size_t> memory;  // lowest limit of the group and its ancestors [bytes]
    std::optional<std::size_t> free;    // available to the group below that limit [bytes]
    std::optional<double> cpus;         // CPU time per wall time [1]
};

// `root`: folder of proc/ and sys/; "" for this machine. A limit is empty if unset or unreadable.
ContainerLimits container_limits(const std::string& root = "");

}  // namespace knead
