// The bytes of sessions (host/files/chunk_file.h), for files that no writer would write.
#pragma once
#include <xxhash.h>

#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "host/files/chunk_file.h"

namespace knead {

constexpr std::size_t session_head = 32, chunk_header_size = 48;

inline std::uint64_t number_in(const std::string& bytes, std::size_t at, std::size_t size = 8)
{
    std::uint64_t value = 0;
    std::memcpy(&value, bytes.data() + at, size);
    return value;
}
inline void put_number(std::string& bytes, std::size_t at, std::uint64_t value,
                       std::size_t size = 8)
{
    std::memcpy(bytes.data() + at, &value, size);
}

// Offsets of headers, as far as sizes say so; of the last one the payload may be cut off.
inline std::vector<std::size_t> chunk_places(const std::string& bytes)
{
    std::vector<std::size_t> all;
    for (std::size_t at = session_head; at + chunk_header_size <= bytes.size();) {
        all.push_back(at);
        const std::size_t stored = number_in(bytes, at + 11, 5);
        if (stored > bytes.size() - at - chunk_header_size) break;
        at += chunk_header_size + stored;
    }
    return all;
}

inline bool is_commit(const std::string& bytes, std::size_t at)
{
    return number_in(bytes, at, 4) == ChunkKind("CMIT").code;
}

// With the hashes, the counts and the chain of what the file has.
inline std::string rehashed(std::string bytes)
{
    if (bytes.size() < session_head) return bytes;
    const std::uint64_t salt = number_in(bytes, 24);
    std::uint64_t chain = XXH3_64bits(bytes.data(), session_head), commits = 0;
    std::vector<std::uint64_t> group = {salt, chain};
    for (const std::size_t at : chunk_places(bytes)) {
        const std::size_t payload = at + chunk_header_size, stored = number_in(bytes, at + 11, 5);
        if (is_commit(bytes, at) && stored == 16 && payload + 16 <= bytes.size()) {
            chain = XXH3_64bits(group.data(), group.size() * 8);
            put_number(bytes, payload, group.size() - 2);
            put_number(bytes, payload + 8, chain);
            put_number(bytes, at + 16, ++commits);
            group = {salt, chain};
        }
        if (stored <= bytes.size() - payload)
            put_number(bytes, at + 32, XXH3_64bits(bytes.data() + payload, stored));
        put_number(bytes, at + 40, XXH3_64bits_withSeed(bytes.data() + at, 40, salt));
        if (!is_commit(bytes, at)) group.push_back(number_in(bytes, at + 40));
    }
    return bytes;
}

inline std::string bytes_in(const std::string& file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}
inline void put_bytes(const std::string& file, const std::string& bytes)
{
    std::ofstream(file, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
}

}  // namespace knead
