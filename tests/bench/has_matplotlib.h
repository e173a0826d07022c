// Whether the python3 on the PATH has matplotlib.
#pragma once
#include "host/base/child.h"

namespace knead {

inline bool has_matplotlib()
{
    std::string said;
    return output_of(
               {"python3", "-c", "exec('try: import matplotlib\\nexcept ImportError: exit(3)')"},
               said) == 0;
}

}  // namespace knead
