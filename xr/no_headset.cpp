// Replaces this room in builds without the OpenXR headers.
#include "xr/headset.h"
#include "xr/sound.h"

namespace knead {

std::unique_ptr<Headset> Headset::open(const HeadsetOptions&)
{
    throw HeadsetError(
        "this program was built without OpenXR (the package libopenxr-dev was not there)");
}

std::unique_ptr<SoundOut> SoundOut::open(std::string& why)
{
    why = "this program was built without OpenXR";
    return nullptr;
}

RuntimeInfo runtime_facts(double)
{
    RuntimeInfo facts;
    facts.reason = "this program was built without OpenXR (libopenxr-dev was not there)";
    return facts;
}

}  // namespace knead
