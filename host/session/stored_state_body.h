// The state of a running scene in files, as in checkpoints and in stored states: one list of its
// facts, one of its arrays and, for each type of element, one of its numbers. Writing, reading and
// measuring all follow these lists. `S` has the members `state`, `splats` and `local`.
#pragma once
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "host/base/json_reader.h"
#include "host/paging/local_state.h"
#include "host/solver/editable_simulator.h"
#include "host/splats/carried.h"

namespace knead {

static_assert(std::endian::native == std::endian::little, "files are written as memory is");

// For the facts.
inline void to_json(Json& to, const Int3& n) { to = {n.x, n.y, n.z}; }
inline void from_json(const Json& from, Int3& n) { n = {from.at(0), from.at(1), from.at(2)}; }

// Calls fact(key, value) for each fact except the lengths of the arrays.
template <class S, class Visit>
void each_state_fact(S& of, Visit&& fact)
{
    auto& state = of.state;
    auto& splats = of.splats;
    auto& local = of.local;
    fact("quiet_low", state.quiet_low);
    fact("quiet_stored", state.quiet_stored);
    fact("speed_squared", state.speed_squared);
    fact("stiffness", state.stiffness);
    fact("drift", state.drift);
    fact("covered", state.covered);
    fact("splat_degree", splats.cloud.degree);
    fact("antialiased", splats.cloud.antialiased);
    fact("clay", local.clay);
    fact("objects", local.objects);
}
// Call once the facts are read: both clouds are of one kind.
template <class S>
void copy_cloud_facts(S& of)
{
    of.local.cloud.degree = of.splats.cloud.degree;
    of.local.cloud.antialiased = of.splats.cloud.antialiased;
}

// Calls section(name, array) for each array in the order of the file. `name` is the key of the fact
// that holds its length. Arrays with the same name have the same length.
template <class S, class Visit>
void each_section(S& of, Visit&& section)
{
    auto& state = of.state;
    auto& splats = of.splats;
    auto& local = of.local;
    section("particles", state.contents.particles);
    section("particles", state.order);
    section("quiet", state.quiet);
    section("sliding", state.sliding);
    section("gaussians", state.contents.gaussians);
    section("splats", splats.cloud);
    section("splats", splats.extent);
    section("still", local.cloud);
    section("still", local.active);
    section("still", local.normal);
    section("home", local.slot_of);
}

template <class T, class Kind>
concept Is = std::same_as<std::remove_const_t<T>, Kind>;

// Calls io(number) or, if it must be finite, io.finite(number) for each number of an element in the
// order of the file. Doubles are written as floats without loss: solvers that can be saved compute
// in floats.
template <class T, class Io>
requires std::is_arithmetic_v<T>
void each_number(T& number, Io& io)
{
    if constexpr (Is<T, float>)
        io.finite(number);
    else
        io(number);
}
template <class V, class Io>
requires Is<V, Vec3<float>>
void each_number(V& v, Io& io) { io.finite(v.x), io.finite(v.y), io.finite(v.z); }
template <class V, class Io>
requires Is<V, Vec3<double>>
void each_number(V& v, Io& io) { io(v.x), io(v.y), io(v.z); }
template <class P, class Io>
requires Is<P, Particle<double>>
void each_number(P& p, Io& io)
{
    for (auto* v : {&p.x, &p.v, &p.C.a, &p.C.b, &p.C.c}) each_number(*v, io);
    for (auto* e : {&p.e.xx, &p.e.yy, &p.e.zz, &p.e.xy, &p.e.xz, &p.e.yz, &p.k}) io(*e);
    io(p.object), io(p.sides);
}
template <class G, class Io>
requires Is<G, Gaussian<double>>
void each_number(G& g, Io& io)
{
    for (auto* v : {&g.x, &g.F.a, &g.F.b, &g.F.c}) each_number(*v, io);
    io(g.object), io(g.sides);
}
template <class S, class Io>
requires Is<S, SlidingNode>
void each_number(S& n, Io& io) { io(n.place), io(n.force), io(n.time), io(n.impulse_deficit); }

// Length of an array, and the numbers of its element i.
template <class T>
std::size_t count_of(const std::vector<T>& array)
{
    return array.size();
}
inline std::size_t count_of(const SplatCloud& cloud) { return cloud.count(); }
template <class T>
void resize(std::vector<T>& array, std::size_t count)
{
    array.resize(count);
}
template <class Array, class Io>
void each_number_of(Array& array, std::size_t i, Io& io)
{
    each_number(array[i], io);
}
template <class Cloud, class Io>
requires Is<Cloud, SplatCloud>
void each_number_of(Cloud& c, std::size_t i, Io& io)
{
    each_number(c.centre[i], io), each_number(c.scale[i], io);
    auto& q = c.rotation[i];
    for (auto* number : {&q.w, &q.x, &q.y, &q.z}) io.finite(*number);
    io.finite(c.opacity[i]);
    const auto count = std::size_t(harmonics(c.degree));
    for (std::size_t k = 0; k < count; ++k) each_number(c.sh[i * count + k], io);
}

struct NumberWriter {
    std::string& to;

    template <class T>
    void operator()(T number)
    {
        to.append(reinterpret_cast<const char*>(&number), sizeof number);
    }
    void operator()(double number) { (*this)(float(number)); }
    void finite(float number) { (*this)(number); }
};

// Precondition: enough bytes remain; nothing is checked here.
struct NumberReader {
    const char* at;

    template <class T>
    void operator()(T& number)
    {
        std::memcpy(&number, at, sizeof number), at += sizeof number;
    }
    void operator()(double& number)
    {
        float rounded;
        (*this)(rounded), number = rounded;
    }
    // Throws std::out_of_range if it is not finite.
    void finite(float& number)
    {
        (*this)(number);
        if (!std::isfinite(number)) throw std::out_of_range("splats");
    }
};

struct NumberSizes {
    std::size_t bytes = 0;

    template <class T>
    void operator()(T)
    {
        bytes += sizeof(T);
    }
    void operator()(double) { bytes += sizeof(float); }
    void finite(float) { bytes += sizeof(float); }
};

// Bytes of an element in the file. Precondition: a cloud's degree is valid.
template <class T>
std::size_t element_bytes(const std::vector<T>&)
{
    NumberSizes sizes;
    const T one{};
    each_number(one, sizes);
    return sizes.bytes;
}
inline std::size_t element_bytes(const SplatCloud& cloud)
{
    NumberSizes sizes;
    SplatCloud one;
    one.degree = cloud.degree, resize(one, 1);
    each_number_of(one, 0, sizes);
    return sizes.bytes;
}

// The facts of the lengths.
template <class S>
void write_lengths(const S& of, Json& facts)
{
    each_section(of, [&](const char* name, const auto& array) { facts[name] = count_of(array); });
}

template <class S>
std::size_t body_bytes(const S& of)
{
    std::size_t bytes = 0;
    each_section(of, [&](const char*, const auto& array) {
        bytes += count_of(array) * element_bytes(array);
    });
    return bytes;
}
// Appends all arrays.
template <class S>
void write_body(const S& of, std::string& to)
{
    NumberWriter write{to};
    each_section(of, [&](const char*, const auto& array) {
        for (std::size_t i = 0; i < count_of(array); ++i) each_number_of(array, i, write);
    });
}

// Throws InputError unless arrays of the lengths in `facts` fill exactly `bytes`. Allocates nothing
// of their size. Precondition: the other facts are read.
template <class S>
void check_lengths(const S& of, const Json& facts, std::uint64_t bytes, const std::string& file)
{
    const auto count = [&](const char* name) { return facts.at(name).get<std::uint64_t>(); };
    const int degree = of.splats.cloud.degree;
    bool fits = degree >= 0 && degree <= max_sh_degree;
    std::uint64_t left = bytes;
    if (fits)
        each_section(of, [&](const char* name, const auto& array) {
            const std::uint64_t n = count(name), each = element_bytes(array);
            fits = fits && n <= left / each;
            if (fits) left -= n * each;
        });
    if (fits && left == 0 && (count("splats") == 0 || count("splats") == count("gaussians")))
        return;
    throw InputError(fmt::format(
        "{}: expected {} particles, {} blocks, {} Gaussians and {} splats, "
        "found {} bytes of them",
        file, count("particles"), count("quiet"), count("gaussians"), count("splats"), bytes));
}
// Precondition: check_lengths(). Throws std::out_of_range for splats with invalid numbers.
template <class S>
void read_body(S& of, const Json& facts, const char* from)
{
    NumberReader read{from};
    each_section(of, [&](const char* name, auto& array) {
        resize(array, facts.at(name).get<std::uint64_t>());
        for (std::size_t i = 0; i < count_of(array); ++i) each_number_of(array, i, read);
    });
}

}  // namespace knead
