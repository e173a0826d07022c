// gzip files (RFC 1952), through zlib.
#pragma once
#include <functional>
#include <string>

#include "host/base/outputs.h"

namespace knead {

bool begins_gzip(const std::string& start);

// Returns the first bytes of the decompressed content, at most `most`; fewer, without an error, if
// the file is damaged.
std::string gunzipped_start(const std::string& bytes, std::size_t most);
// Returns the whole content. Throws InputError with the path if the file is damaged or truncated,
// has more than `most` bytes of content, or trailing data. Memory grows with the actual output, not
// with the declared size.
std::string gunzipped(const std::string& bytes, const std::string& path, std::size_t most);

// Deterministic: stores no time and no name.
std::string gzipped(const std::string& bytes);
// The same of part(0), part(1), ... one after another, passed on in parts of a few MiB.
void gzip_parts(const std::function<std::string(std::size_t k)>& part, std::size_t parts,
                const AddBytes& add);

}  // namespace knead
