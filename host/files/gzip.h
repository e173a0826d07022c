// Files of gzip (RFC 1952), through zlib.
#pragma once
#include <string>

namespace knead {

bool begins_gzip(const std::string& start);

// The first bytes of what a gzip file holds, as many as there are up to `most`; fewer, without a
// word, where it is damaged.
std::string gunzipped_start(const std::string& bytes, std::size_t most);
// All of it. Throws InputError with the path where it is damaged or short, holds more than `most`
// bytes, or something follows. Memory grows with what comes out, not with what is promised.
std::string gunzipped(const std::string& bytes, const std::string& path, std::size_t most);

// The same bytes on every run: it carries no time and no name.
std::string gzipped(const std::string& bytes);

}  // namespace knead
