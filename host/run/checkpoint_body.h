// Serialization of numbers and splats in the body of a checkpoint.
#pragma once
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>

#include "cuda/splats/gaussian.h"
#include "host/paging/local_state.h"

namespace knead {

template <class T>
requires std::is_arithmetic_v<T>
void append(std::string& to, const T& value)
{
    to.append(reinterpret_cast<const char*>(&value), sizeof value);
}

inline std::size_t splat_bytes(int degree)
{
    return (11 + 3 * std::size_t(harmonics(degree))) * sizeof(float);
}
// Bytes of a slot of local clay besides its splat.
constexpr std::size_t local_bytes = 3 * sizeof(float) + sizeof(char);

// Calls visit(number) for every number of splat i.
template <class Cloud, class Visit>
void each_float_of(Cloud& c, std::size_t i, Visit&& visit)
{
    const auto vector = [&](auto& v) { visit(v.x), visit(v.y), visit(v.z); };
    vector(c.centre[i]), vector(c.scale[i]);
    visit(c.rotation[i].w), visit(c.rotation[i].x), visit(c.rotation[i].y), visit(c.rotation[i].z);
    visit(c.opacity[i]);
    const auto count = std::size_t(harmonics(c.degree));
    for (std::size_t k = 0; k < count; ++k) vector(c.sh[i * count + k]);
}

inline void append(std::string& to, const SplatCloud& cloud)
{
    for (std::size_t i = 0; i < cloud.count(); ++i)
        each_float_of(cloud, i, [&](float number) { append(to, number); });
}

inline void append(std::string& to, const LocalState& s)
{
    append(to, s.cloud);
    for (const char away : s.active) append(to, away);
    for (const Vec3<float>& n : s.normal) append(to, n.x), append(to, n.y), append(to, n.z);
    for (const int slot : s.slot_of) append(to, slot);
}

// Reads values sequentially. Precondition: enough bytes remain; nothing is checked here.
struct Taker {
    const char* at;

    template <class T>
    requires std::is_arithmetic_v<T>
    void take(T& value) { std::memcpy(&value, at, sizeof value), at += sizeof value; }
    // Throws std::out_of_range if it is not finite.
    void take_finite(float& number)
    {
        take(number);
        if (!std::isfinite(number)) throw std::out_of_range("splats");
    }
    // Reads `count` splats. Precondition: c.degree is set.
    void take(SplatCloud& c, std::size_t count)
    {
        c.centre.resize(count), c.rotation.resize(count), c.scale.resize(count);
        c.opacity.resize(count), c.sh.resize(count * std::size_t(harmonics(c.degree)));
        for (std::size_t i = 0; i < count; ++i)
            each_float_of(c, i, [&](float& number) { take_finite(number); });
    }
    void take(LocalState& s, std::size_t count, std::size_t home)
    {
        take(s.cloud, count);
        s.active.resize(count), s.normal.resize(count), s.slot_of.resize(home);
        for (char& away : s.active) take(away);
        for (Vec3<float>& n : s.normal) take_finite(n.x), take_finite(n.y), take_finite(n.z);
        for (int& slot : s.slot_of) take(slot);
    }
};

}  // namespace knead
