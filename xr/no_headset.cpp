// Takes the place of the room where OpenXR's headers were not found.
#include "xr/headset.h"

namespace knead {

std::unique_ptr<Headset> Headset::open(const HeadsetRule&)
{
    throw HeadsetError(
        "this program was built without OpenXR (the package libopenxr-dev was not there)");
}

RuntimeFacts runtime_facts()
{
    RuntimeFacts facts;
    facts.reason = "this program was built without OpenXR (libopenxr-dev was not there)";
    return facts;
}

}  // namespace knead
