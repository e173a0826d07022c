#include "tests/fuzz/mutate.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace knead {
namespace {

template <class T>
std::string bytes_of(T value)
{
    return {reinterpret_cast<const char*>(&value), sizeof value};
}

// Numbers at the ends of what a field can hold, as its bytes.
std::string extreme_field(std::uint64_t drawn)
{
    using F = std::numeric_limits<float>;
    using D = std::numeric_limits<double>;
    const std::uint64_t wholes[] = {0,          1,          2,          3,
                                    0x7f,       0x80,       0xff,       0x7fff,
                                    0xffff,     0x10000,    0x7fffffff, 0x80000000,
                                    0xfffffffe, 0xffffffff, 1000000000, std::uint64_t(1) << 40};
    const float floats[] = {0.f,      -1.f,          1e30f,          -1e30f,          F::max(),
                            F::min(), F::infinity(), F::quiet_NaN(), F::denorm_min(), 1e9f};
    const double doubles[] = {
        0,  -1, 1e300, -1e300, D::max(), D::min(), D::infinity(), D::quiet_NaN(), D::denorm_min(),
        1e9};
    const std::uint64_t which = drawn / 8;
    switch (drawn % 8) {
        case 0:
            return bytes_of(std::uint8_t(wholes[which % 16]));
        case 1:
            return bytes_of(std::uint16_t(wholes[which % 16]));
        case 2:
        case 3:
            return bytes_of(std::uint32_t(wholes[which % 16]));
        case 4:
            return bytes_of(which % 2 ? ~std::uint64_t(0) : wholes[which / 2 % 16]);
        case 5:
        case 6:
            return bytes_of(floats[which % 10]);
        default:
            return bytes_of(doubles[which % 10]);
    }
}

const char* const extreme_words[] = {"0",
                                     "-0",
                                     "-1",
                                     "1e999",
                                     "-1e308",
                                     "1e-320",
                                     "nan",
                                     "inf",
                                     "2147483647",
                                     "4294967296",
                                     "99999999999999999999",
                                     "0.5",
                                     "1e9",
                                     "true",
                                     "null",
                                     "\"\"",
                                     "[]",
                                     "{}",
                                     "65536",
                                     "0x10",
                                     "1e300",
                                     "1e-30",
                                     "8",
                                     "1024",
                                     "\"\\u0000\"",
                                     "-2147483648",
                                     "3"};

}  // namespace

void Mutator::set_bits(std::string& bytes)
{
    for (std::size_t n = 1 + below(4); n > 0 && !bytes.empty(); --n)
        bytes[below(bytes.size())] ^= char(1u << below(8));
}

void Mutator::set_field(std::string& bytes)
{
    std::string field = extreme_field(engine());
    if (bytes.size() < field.size()) return;
    if (below(4) == 0) std::reverse(field.begin(), field.end());  // of the other byte order
    // Heads hold what counts: half of the fields are set in the first 256 bytes.
    const std::size_t room = bytes.size() - field.size() + 1;
    std::size_t at = below(below(2) ? std::min<std::size_t>(room, 256) : room);
    if (below(2)) at -= at % field.size();
    bytes.replace(at, field.size(), field);
}

void Mutator::set_number(std::string& text)
{
    if (text.empty()) return;
    const std::size_t from = below(text.size());
    const std::size_t at = std::min(text.find_first_of("-0123456789", from), text.size());
    const std::size_t end = std::min(text.find_first_not_of("-+.0123456789eE", at), text.size());
    text.replace(at, end - at, extreme_words[below(std::size(extreme_words))]);
}

void Mutator::move_piece(std::string& bytes, const std::vector<std::string>& inputs)
{
    const std::string& from = below(2) ? bytes : inputs[below(inputs.size())];
    const std::size_t begin = below(from.size() + 1), most = below(8) ? 64 : from.size();
    const std::string piece = from.substr(begin, below(most + 1));
    const std::size_t at = below(bytes.size() + 1);
    bytes.replace(at, below(2) ? std::min(piece.size(), bytes.size() - at) : 0, piece);
}

// Takes a line of a text out, doubles it, or swaps it with the next.
void Mutator::change_line(std::string& text)
{
    const std::size_t somewhere = below(text.size() + 1);
    const std::size_t before = text.rfind('\n', somewhere);
    const std::size_t begin = before == std::string::npos ? 0 : before + 1;
    const std::size_t after = text.find('\n', begin);
    const std::size_t end = after == std::string::npos ? text.size() : after + 1;
    const std::string line = text.substr(begin, end - begin);
    switch (below(3)) {
        case 0:
            text.erase(begin, line.size());
            return;
        case 1:
            text.insert(begin, line);
            return;
        default:
            text.erase(begin, line.size());
            const std::size_t next = text.find('\n', begin);
            text.insert(next == std::string::npos ? text.size() : next + 1, line);
    }
}

void Mutator::change(std::string& bytes, const std::vector<std::string>& inputs)
{
    switch (below(12)) {
        case 0:
        case 1:
            return set_bits(bytes);
        case 2:
        case 3:
        case 4:
            return set_field(bytes);
        case 5:
        case 6:
            return set_number(bytes);
        case 7:
            return bytes.resize(below(bytes.size() + 1));
        case 8:
            bytes.erase(below(bytes.size() + 1), below(below(2) ? 8 : bytes.size() + 1));
            return;
        case 9:
            return change_line(bytes);
        case 10:
            bytes.insert(below(bytes.size() + 1), 1 + below(below(20) ? 20 : 20000),
                         "[{(\" ,0\n"[below(8)]);
            return;
        default:
            return move_piece(bytes, inputs);
    }
}

std::string Mutator::changed(const std::vector<std::string>& inputs, std::size_t longest)
{
    std::string bytes = inputs[below(inputs.size())];
    for (std::size_t n = below(2) ? 1 : 2 + below(5); n > 0; --n) change(bytes, inputs);
    if (bytes.size() > longest) bytes.resize(longest);
    return bytes;
}

}  // namespace knead
