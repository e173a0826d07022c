// What a container allows its processes: the limits of control groups, version 1 and 2.
#pragma once
#include <cstddef>
#include <optional>
#include <string>

namespace knead {

struct ContainerLimits {
    std::optional<std::size_t>
        memory;                       // the least limit of the group and of those above it [bytes]
    std::optional<std::size_t> free;  // what the group can still take of it [bytes]
    std::optional<double> cpus;       // CPU time per wall time
};

// `root` is the folder that proc/ and sys/ are in: "" for this machine's. Nothing where a limit is
// not set or cannot be read.
ContainerLimits container_limits(const std::string& root = "");

}  // namespace knead
