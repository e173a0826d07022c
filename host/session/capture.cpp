#include "host/session/capture.h"

#include <fmt/format.h>
#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "host/base/errors.h"

namespace knead {
namespace {

constexpr int level = 1;                    // higher ones save less than a tenth of the bytes
constexpr std::size_t large_plane = 50000;  // numbers: by its time, not by its bytes
constexpr std::size_t most_expansion = 256, word = sizeof(std::uint32_t);

// A Gaussian is read as this many numbers of 32 bits: x, F, object, sides.
constexpr std::size_t gaussian_words = 14, gaussian_object = 12;
static_assert(sizeof(Gaussian<float>) == gaussian_words * word &&
              std::is_trivially_copyable_v<Gaussian<float>> &&
              offsetof(Gaussian<float>, object) == gaussian_object * word);

constexpr std::uint64_t letters(const char (&name)[9])
{
    std::uint64_t code = 0;
    for (int i = 7; i >= 0; --i) code = code << 8 | std::uint8_t(name[i]);
    return code;
}
constexpr std::uint64_t whole_rows = letters("clay.1\r\n"), of_two_rows = letters("step.1\r\n"),
                        whole_quantised = letters("clay.2\r\n"),
                        of_two_quantised = letters("step.2\r\n");

struct Head {
    std::uint64_t kind, particles, gaussians;
    std::uint64_t from, to;  // hashes of the rows; of whole rows: both are theirs
};
// Of quantised bytes, behind the head; followed by the step of e of each object.
struct StepHead {
    std::uint64_t multiples;  // by plane, from the lowest bit: its numbers are multiples
    float x;                  // step of positions [m]
    std::uint32_t objects;    // how many have a step of e
};
static_assert(sizeof(StepHead) == 16);

// Which step the numbers of a plane have.
enum class Unit { none, x, e, k, F };

// Numbers of 32 bits in memory, `stride` bytes apart.
template <class Byte>
struct Plane {
    Byte* at;
    std::size_t stride, count;
    Unit unit;
};

// All planes of the rows; without `objects`, those that may differ between rows of the same
// members. Otherwise the particles' objects are the plane before e with `objects_first`, else the
// one behind k.
template <class Byte, class Rows>
std::vector<Plane<Byte>> planes_of(Rows& rows, bool objects, bool objects_first)
{
    std::vector<Plane<Byte>> all;
    const auto add = [&](auto* numbers, std::size_t stride, std::size_t count, Unit unit) {
        all.push_back({reinterpret_cast<Byte*>(numbers), stride, count, unit});
    };
    const auto add_objects = [&] { add(rows.object.data(), word, rows.count, Unit::none); };
    for (std::size_t p = 0; p < clay_planes; ++p) {
        if (p == 3 && objects && objects_first) add_objects();
        add(rows.planes.data() + p * rows.count, word, rows.count,
            p < 3   ? Unit::x
            : p < 9 ? Unit::e
                    : Unit::k);
    }
    if (objects && !objects_first) add_objects();
    add(rows.sides.data(), word, rows.count, Unit::none);
    if (rows.gaussians.empty()) return all;
    for (std::size_t w = 0; w < gaussian_words; ++w) {
        if (!objects && w == gaussian_object) continue;
        add(rows.gaussians.data(), sizeof(Gaussian<float>), rows.gaussians.size(),
            w < 3                 ? Unit::x
            : w < gaussian_object ? Unit::F
                                  : Unit::none);
        all.back().at += w * word;
    }
    return all;
}
std::size_t longest_plane(const ClayRows& rows)
{
    return std::max(rows.count, rows.gaussians.size());
}

void check(const ClayRows& rows)
{
    if (rows.planes.size() != clay_planes * rows.count || rows.object.size() != rows.count ||
        rows.sides.size() != rows.count)
        throw std::invalid_argument("rows of clay: each particle needs a number in each plane");
}

constexpr std::size_t chunk = 1024;  // numbers at a time, which stay in the first cache
using Numbers = std::array<std::uint32_t, chunk>;

void load(Numbers& to, const Plane<const char>& from, std::size_t first, std::size_t n)
{
    const char* at = from.at + first * from.stride;
    if (from.stride == word) {
        std::memcpy(to.data(), at, n * word);
        return;
    }
    for (std::size_t i = 0; i < n; ++i) std::memcpy(&to[i], at + i * from.stride, word);
}
void store(const Numbers& from, const Plane<char>& to, std::size_t first, std::size_t n)
{
    char* at = to.at + first * to.stride;
    if (to.stride == word) {
        std::memcpy(at, from.data(), n * word);
        return;
    }
    for (std::size_t i = 0; i < n; ++i) std::memcpy(at + i * to.stride, &from[i], word);
}

// The loops below are vectorised, but for sums().

// Bits of floats as integers in the order of the floats, so that close floats are close integers;
// and back. One to one for all bits.
void order(Numbers& numbers, std::size_t n)
{
    for (std::size_t i = 0; i < n; ++i)
        numbers[i] ^= std::uint32_t(std::int32_t(numbers[i]) >> 31) | 1u << 31;
}
void as_floats(Numbers& numbers, std::size_t n)
{
    for (std::size_t i = 0; i < n; ++i)
        numbers[i] ^= ~std::uint32_t(std::int32_t(numbers[i]) >> 31) | 1u << 31;
}
void subtract(Numbers& a, const Numbers& b, std::size_t n)
{
    for (std::size_t i = 0; i < n; ++i) a[i] -= b[i];
}
void add(Numbers& a, const Numbers& b, std::size_t n)
{
    for (std::size_t i = 0; i < n; ++i) a[i] += b[i];
}

// Steps of a chunk of numbers, and how many of them are in one.
struct ChunkSteps {
    std::array<float, chunk> size, per;
    void fill(float all) { size.fill(all), per.fill(1 / all); }
};

// Floats as multiples of their steps. Returns whether they are such: as_numbers() gives them back.
bool as_multiples(Numbers& numbers, const ChunkSteps& steps, std::size_t n)
{
    std::uint32_t others = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const QuantStep step{steps.size[i], steps.per[i]};
        const int multiple = multiple_of(std::bit_cast<float>(numbers[i]), step);
        others |= std::bit_cast<std::uint32_t>(number_of(multiple, step)) ^ numbers[i];
        numbers[i] = std::uint32_t(multiple);
    }
    return others == 0;
}
// Returns whether as_multiples() gives the multiples back.
bool as_numbers(Numbers& multiples, const ChunkSteps& steps, std::size_t n)
{
    std::uint32_t others = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const QuantStep step{steps.size[i], steps.per[i]};
        const float number = number_of(std::int32_t(multiples[i]), step);
        others |= std::uint32_t(multiple_of(number, step)) ^ multiples[i];
        multiples[i] = std::bit_cast<std::uint32_t>(number);
    }
    return others == 0;
}

// How the floats of a plane are taken as integers: as multiples of their steps, or, without
// `quantisation`, in their order.
class Integers {
  public:
    // `rows`: whose objects the particles are of.
    Integers(const Quantisation* quantisation, Unit of, const ClayRows& rows)
        : by(of == Unit::none ? nullptr : quantisation), unit(of), objects(rows.object.data())
    {
        if (!by || unit == Unit::e) return;
        steps.fill(unit == Unit::x ? by->x : unit == Unit::k ? k_step : F_step);
    }
    // The numbers of the plane from number `first` on. False: there are others than multiples.
    bool of(Numbers& numbers, std::size_t first, std::size_t n)
    {
        if (!by) return order(numbers, n), true;
        find_steps(first, n);
        return as_multiples(numbers, steps, n);
    }
    // False: of() would not give these integers back.
    bool back(Numbers& numbers, std::size_t first, std::size_t n)
    {
        if (!by) return as_floats(numbers, n), true;
        find_steps(first, n);
        return as_numbers(numbers, steps, n);
    }

  private:
    void find_steps(std::size_t first, std::size_t n)
    {
        if (unit != Unit::e || first == found) return;
        found = first;
        const std::int32_t* const of = objects + first;
        int others = 0;
        for (std::size_t i = 1; i < n; ++i) others |= of[i] ^ of[0];
        if (others == 0) return steps.fill(by->of_object(of[0]));
        for (std::size_t i = 0; i < n; ++i) steps.size[i] = by->of_object(of[i]);
        for (std::size_t i = 0; i < n; ++i) steps.per[i] = 1 / steps.size[i];
    }

    const Quantisation* const by;
    const Unit unit;
    const std::int32_t* const objects;
    ChunkSteps steps;
    std::size_t found = ~std::size_t(0);  // the chunk whose steps these are
};

// Each number less the one before it, with the sign as lowest bit: 0 -1 1 -2 become 0 1 2 3. `last`
// is the number before the first.
void differences(Numbers& of, const Numbers& numbers, std::uint32_t& last, std::size_t n)
{
    const auto folded = [](std::uint32_t d) {
        return d << 1 ^ std::uint32_t(std::int32_t(d) >> 31);
    };
    of[0] = folded(numbers[0] - last);
    for (std::size_t i = 1; i < n; ++i) of[i] = folded(numbers[i] - numbers[i - 1]);
    last = numbers[n - 1];
}
void sums(Numbers& numbers, std::uint32_t& last, std::size_t n)
{
    for (std::size_t i = 0; i < n; ++i) numbers[i] = numbers[i] >> 1 ^ (~(numbers[i] & 1) + 1);
    for (std::size_t i = 0; i < n; ++i) last += numbers[i], numbers[i] = last;
}

// Planes of bytes, `count` apart.
void split(const Numbers& numbers, std::uint8_t* bytes, std::size_t count, std::size_t n)
{
    for (std::size_t b = 0; b < word; ++b) {
        std::uint8_t* const to = bytes + b * count;
        for (std::size_t i = 0; i < n; ++i) to[i] = std::uint8_t(numbers[i] >> (8 * b));
    }
}
void join(Numbers& numbers, const std::uint8_t* bytes, std::size_t count, std::size_t n)
{
    for (std::size_t i = 0; i < n; ++i)
        numbers[i] = std::uint32_t(bytes[i]) | std::uint32_t(bytes[count + i]) << 8 |
                     std::uint32_t(bytes[2 * count + i]) << 16 |
                     std::uint32_t(bytes[3 * count + i]) << 24;
}

struct Free {
    void operator()(ZSTD_CCtx* c) const { ZSTD_freeCCtx(c); }
    void operator()(ZSTD_DCtx* c) const { ZSTD_freeDCtx(c); }
};
using Bytes = std::unique_ptr<std::uint8_t[]>;
Bytes uninitialised(std::size_t n) { return std::make_unique_for_overwrite<std::uint8_t[]>(n); }

// The integers of a plane, or by how much they change up to `to`, as planes of bytes. False: not
// all are multiples of their steps.
bool split_plane(const Plane<const char>* from, const Plane<const char>& to, Integers&& integers,
                 std::uint8_t* bytes)
{
    Numbers a, b, folded;
    std::uint32_t last = 0;
    for (std::size_t i = 0; i < to.count; i += chunk) {
        const std::size_t some = std::min(chunk, to.count - i);
        load(b, to, i, some);
        if (!integers.of(b, i, some)) return false;
        if (from) {
            load(a, *from, i, some);
            if (!integers.of(a, i, some)) return false;
            subtract(b, a, some);
        }
        differences(folded, b, last, some);
        split(folded, bytes + i, to.count, some);
    }
    return true;
}

// Of large clay, low bytes of multiples are noise, in which a smaller table finds as little in half
// of the time: at most 4 % more bytes.
std::unique_ptr<ZSTD_CCtx, Free> context_for(bool large_noise)
{
    std::unique_ptr<ZSTD_CCtx, Free> context(ZSTD_createCCtx());
    if (!context) throw std::bad_alloc();
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, level);
    if (!large_noise) return context;
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_minMatch, 7);
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_hashLog, 8);
    return context;
}

// Of the planes of `rows` or, with `other`, of their difference.
std::string compressed(const Head& head, const ClayRows& rows, const ClayRows* other,
                       const Quantisation* steps)
{
    const std::vector<Plane<const char>> from = planes_of<const char>(rows, !other, steps),
                                         to = planes_of<const char>(other ? *other : rows, !other,
                                                                    steps);
    StepHead of_steps{};
    const std::size_t e_bytes = steps ? steps->e.size() * word : 0;
    std::size_t size = sizeof head + (steps ? sizeof of_steps + e_bytes : 0), bound = size;
    for (const auto& plane : from) bound += word * ZSTD_compressBound(plane.count);
    const std::unique_ptr<ZSTD_CCtx, Free> context =
        context_for(steps && longest_plane(rows) > large_plane);
    const Bytes all = uninitialised(bound), bytes = uninitialised(word * longest_plane(rows));
    for (std::size_t p = 0; p < from.size(); ++p) {
        const auto split_as = [&](const Quantisation* by) {
            return split_plane(other ? &from[p] : nullptr, to[p], {by, to[p].unit, rows},
                               bytes.get());
        };
        if (steps && to[p].unit != Unit::none && split_as(steps))
            of_steps.multiples |= std::uint64_t(1) << p;
        else
            split_as(nullptr);
        const std::size_t n = to[p].count;
        for (std::size_t k = 0; k < word && n > 0; ++k) {
            const std::size_t added = ZSTD_compress2(context.get(), all.get() + size, bound - size,
                                                     bytes.get() + k * n, n);
            if (ZSTD_isError(added)) throw std::bad_alloc();  // nothing else can go wrong
            size += added;
        }
    }
    std::memcpy(all.get(), &head, sizeof head);
    if (steps) {
        of_steps.x = steps->x, of_steps.objects = std::uint32_t(steps->e.size());
        std::memcpy(all.get() + sizeof head, &of_steps, sizeof of_steps);
        if (e_bytes > 0)
            std::memcpy(all.get() + sizeof head + sizeof of_steps, steps->e.data(), e_bytes);
    }
    return {reinterpret_cast<const char*>(all.get()), size};
}

// Reads the planes of bytes of compressed(), one after the other.
class Frames {
  public:
    // `longest`: numbers of a plane. `start`: of the first frame.
    Frames(const std::string& bytes, std::size_t longest, std::size_t start)
        : all(bytes),
          planes(uninitialised(word * longest)),
          context(ZSTD_createDCtx()),
          begin(start),
          at(start)
    {
        if (!context) throw std::bad_alloc();
    }
    void restart() { at = begin; }
    // The four planes of bytes of `n` numbers, n apart; null: these bytes are no such frames.
    const std::uint8_t* next(std::size_t n)
    {
        for (std::size_t k = 0; k < word && n > 0; ++k) {
            const char* const from = all.data() + at;
            const std::size_t size = ZSTD_findFrameCompressedSize(from, all.size() - at);
            if (ZSTD_isError(size) || ZSTD_getFrameContentSize(from, size) != n) return nullptr;
            if (ZSTD_decompressDCtx(context.get(), planes.get() + k * n, n, from, size) != n)
                return nullptr;
            at += size;
        }
        return planes.get();
    }
    std::size_t place() const { return at; }
    // Whether nothing but zeros follows, up to `least` bytes in all.
    bool complete(std::size_t least) const
    {
        return all.size() == std::max(at, least) &&
               all.find_first_not_of('\0', at) == std::string::npos;
    }

  private:
    const std::string& all;
    const Bytes planes;
    const std::unique_ptr<ZSTD_DCtx, Free> context;
    const std::size_t begin;
    std::size_t at;
};

[[noreturn]] void damaged(std::size_t at)
{
    throw InputError(fmt::format("clay of a step: damaged at byte {}", at));
}

// What is before the frames.
struct Beginning {
    Head head;
    std::optional<Quantisation> steps{};
    std::uint64_t multiples = 0;
    std::size_t end = sizeof(Head);
    // For numbers of plane p, whose unit is this.
    Integers integers(std::size_t p, Unit unit, const ClayRows& rows) const
    {
        return {(multiples >> p & 1) != 0 ? &*steps : nullptr, unit, rows};
    }
};

Beginning beginning_of(const std::string& bytes, bool whole)
{
    Beginning all;
    Head& head = all.head;
    if (bytes.size() < sizeof head)
        throw InputError(fmt::format("clay of a step: expected at least {} bytes, found {}",
                                     sizeof head, bytes.size()));
    std::memcpy(&head, bytes.data(), sizeof head);
    const bool quantised = head.kind == (whole ? whole_quantised : of_two_quantised);
    if (!quantised && head.kind != (whole ? whole_rows : of_two_rows))
        throw InputError(fmt::format("clay of a step: expected {}, found something else",
                                     whole ? "whole rows" : "a difference"));
    if (!quantised) return all;
    StepHead steps;
    if (bytes.size() < all.end + sizeof steps) damaged(bytes.size());
    std::memcpy(&steps, bytes.data() + all.end, sizeof steps);
    all.end += sizeof steps;
    if (steps.objects > (bytes.size() - all.end) / word) damaged(all.end);
    all.steps.emplace();
    all.multiples = steps.multiples;
    all.steps->x = steps.x, all.steps->e.resize(steps.objects);
    if (steps.objects > 0)
        std::memcpy(all.steps->e.data(), bytes.data() + all.end, steps.objects * word);
    all.end += steps.objects * word;
    return all;
}

}  // namespace

std::uint64_t hash(const ClayRows& rows)
{
    const std::uint64_t counts[] = {rows.count, rows.gaussians.size()};
    std::uint64_t h = XXH3_64bits(counts, sizeof counts);
    const auto add = [&](const auto& numbers) {
        h = XXH3_64bits_withSeed(numbers.data(), numbers.size() * sizeof numbers[0], h);
    };
    add(rows.planes), add(rows.object), add(rows.sides), add(rows.gaussians);
    return h;
}

std::size_t bytes_of(const ClayRows& rows)
{
    return word * (rows.planes.size() + rows.object.size() + rows.sides.size() +
                   gaussian_words * rows.gaussians.size());
}

std::string encoded(const ClayRows& rows, const Quantisation* steps)
{
    check(rows);
    const std::uint64_t h = hash(rows);
    std::string bytes =
        compressed({steps ? whole_quantised : whole_rows, rows.count, rows.gaussians.size(), h, h},
                   rows, nullptr, steps);
    bytes.resize(std::max(bytes.size(), bytes_of(rows) / most_expansion));
    return bytes;
}

ClayRows decoded(const std::string& bytes)
{
    const Beginning beginning = beginning_of(bytes, true);
    const Head& head = beginning.head;
    constexpr std::uint64_t most = std::numeric_limits<int>::max();  // they are numbered by int
    const std::uint64_t of_particle = (clay_planes + 2) * word;
    if (head.particles > most || head.gaussians > most ||
        (head.particles * of_particle + head.gaussians * sizeof(Gaussian<float>)) / most_expansion >
            bytes.size())
        throw InputError(
            fmt::format("clay of a step: {} particles and {} Gaussians cannot be in {} bytes",
                        head.particles, head.gaussians, bytes.size()));
    ClayRows rows;
    rows.count = head.particles;
    rows.planes.resize(clay_planes * rows.count);
    rows.object.resize(rows.count), rows.sides.resize(rows.count);
    rows.gaussians.resize(head.gaussians);
    Frames frames(bytes, longest_plane(rows), beginning.end);
    Numbers numbers;
    const std::vector<Plane<char>> planes =
        planes_of<char>(rows, true, beginning.steps.has_value());
    for (std::size_t p = 0; p < planes.size(); ++p) {
        const Plane<char>& plane = planes[p];
        const std::uint8_t* const four = frames.next(plane.count);
        if (!four) damaged(frames.place());
        Integers integers = beginning.integers(p, plane.unit, rows);
        std::uint32_t last = 0;
        for (std::size_t i = 0; i < plane.count; i += chunk) {
            const std::size_t some = std::min(chunk, plane.count - i);
            join(numbers, four + i, plane.count, some), sums(numbers, last, some);
            if (!integers.back(numbers, i, some)) damaged(frames.place());
            store(numbers, plane, i, some);
        }
    }
    if (!frames.complete(bytes_of(rows) / most_expansion)) damaged(frames.place());
    if (hash(rows) != head.to || head.from != head.to)
        throw InputError("clay of a step: its hash is not that of its rows");
    return rows;
}

std::uint64_t hash_after(const std::string& bytes)
{
    Head head;
    if (bytes.size() < sizeof head) throw InputError("clay of a step: its head is cut off");
    std::copy_n(bytes.data(), sizeof head, reinterpret_cast<char*>(&head));
    return head.to;
}

bool same_members(const ClayRows& a, const ClayRows& b)
{
    return a.count == b.count && a.object == b.object &&
           std::equal(
               a.gaussians.begin(), a.gaussians.end(), b.gaussians.begin(), b.gaussians.end(),
               [](const auto& one, const auto& other) { return one.object == other.object; });
}

std::string difference(const ClayRows& a, const ClayRows& b, const Quantisation* steps)
{
    check(a), check(b);
    if (!same_members(a, b))
        throw std::invalid_argument("rows of clay: a difference needs the same particles");
    return compressed(
        {steps ? of_two_quantised : of_two_rows, a.count, a.gaussians.size(), hash(a), hash(b)}, a,
        &b, steps);
}

namespace {

// Of the numbers of all planes: those before number `in_plane` of plane `plane`.
struct Extent {
    std::size_t plane, in_plane;
};
constexpr Extent all_numbers{~std::size_t(0), 0};

// Adds the difference to the numbers of `extent`, or subtracts it. Returns to which: fewer if it is
// damaged. Those can be changed back.
Extent add_difference(ClayRows& rows, Frames& frames, const Beginning& beginning, Extent extent,
                      bool adds)
{
    const std::vector<Plane<char>> planes =
        planes_of<char>(rows, false, beginning.steps.has_value());
    Numbers a, b;
    frames.restart();
    for (std::size_t p = 0; p < planes.size() && p <= extent.plane; ++p) {
        const Plane<char>& plane = planes[p];
        const std::size_t count = p < extent.plane ? plane.count : extent.in_plane;
        const std::uint8_t* const four = count > 0 ? frames.next(plane.count) : nullptr;
        if (count > 0 && !four) return {p, 0};
        Integers integers = beginning.integers(p, plane.unit, rows);
        std::uint32_t last = 0;
        for (std::size_t i = 0; i < count; i += chunk) {
            const std::size_t some = std::min(chunk, count - i);
            load(a, {plane.at, plane.stride, plane.count, plane.unit}, i, some);
            join(b, four + i, plane.count, some), sums(b, last, some);
            if (!integers.of(a, i, some)) return {p, i};
            adds ? add(a, b, some) : subtract(a, b, some);
            if (!integers.back(a, i, some)) return {p, i};
            store(a, plane, i, some);
        }
    }
    return all_numbers;
}

}  // namespace

void apply_difference(ClayRows& rows, const std::string& bytes)
{
    const Beginning beginning = beginning_of(bytes, false);
    const Head& head = beginning.head;
    if (head.particles != rows.count || head.gaussians != rows.gaussians.size())
        throw InputError(fmt::format(
            "clay of a step: a difference of {} particles and {} Gaussians, expected {} and {}",
            head.particles, head.gaussians, rows.count, rows.gaussians.size()));
    const std::uint64_t before = hash(rows);
    const bool forward = before == head.from;
    if (before != head.from && before != head.to)
        throw InputError("clay of a step: a difference from other rows than these");
    Frames frames(bytes, longest_plane(rows), beginning.end);
    const Extent applied = add_difference(rows, frames, beginning, all_numbers, forward);
    const std::size_t place = frames.place();
    const bool whole = applied.plane == all_numbers.plane && frames.complete(0);
    if (whole && hash(rows) == (forward ? head.to : head.from)) return;
    add_difference(rows, frames, beginning, applied, !forward);  // the rows are as before
    if (!whole) damaged(place);
    throw InputError("clay of a step: its hash is not that of the rows that it leads to");
}

}  // namespace knead
