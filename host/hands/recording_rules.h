// Constraints on recordings, for both forms.
#pragma once
#include <fmt/format.h>

#include <cmath>
#include <string>

#include "host/base/errors.h"
#include "host/hands/recording.h"

namespace knead {

constexpr std::size_t longest_name = 100, longest_line = 1 << 16;

// A location in a file, for error messages: "at byte 12" or "in line 3".
struct Place {
    std::string path, at;
    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const
    {
        throw InputError(fmt::format("{}: {}: expected {}, found {}", path, at, expected, found));
    }
};

// Checks of each value, for both forms. Throw InputError.
inline void check_header(const Recording& r, const Place& place)
{
    if (r.name.empty() || r.name.size() > longest_name)
        place.refuse(fmt::format("a name of 1 to {} characters", longest_name),
                     fmt::format("{}", r.name.size()));
    for (const unsigned char letter : r.name)
        if (letter < 0x20 || letter > 0x7e)
            place.refuse("a name of printable ASCII", fmt::format("the byte {:#04x}", letter));
    if (!(r.rate > 0 && r.rate <= 1000))
        place.refuse("a rate above 0 and at most 1000 Hz", fmt::format("{}", r.rate));
    if (!(r.latency >= 0 && r.latency <= 10))
        place.refuse("a latency of 0 to 10 s", fmt::format("{}", r.latency));
}

inline void check_time(double time, double before, const Place& place)
{
    if (!(time >= 0 && time <= 1e5))
        place.refuse("a time of 0 to 100000 s", fmt::format("{}", time));
    if (!(time > before))
        place.refuse(fmt::format("a time after {} s", before), fmt::format("{} s", time));
}

inline void check_joint(const Joint<float>& joint, float radius, bool valid, const Place& place)
{
    for (const float x : {joint.p.x, joint.p.y, joint.p.z})
        if (!(std::abs(x) <= 100)) place.refuse("a position within 100 m", fmt::format("{}", x));
    const double w = joint.q.w, x = joint.q.x, y = joint.q.y, z = joint.q.z;
    const double square = w * w + x * x + y * y + z * z;
    const bool unseen = !valid && square == 0;
    if (!(std::abs(square - 1) <= 2e-3) && !unseen)
        place.refuse("a unit quaternion", fmt::format("({}, {}, {}, {})", w, x, y, z));
    if (!(radius >= 0 && radius <= 1))
        place.refuse("a radius of 0 to 1 m", fmt::format("{}", radius));
}

// Reads the JSON-lines form.
Recording from_lines(const std::string& bytes, const std::string& path);

}  // namespace knead
