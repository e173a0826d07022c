// ZIP archives (PKWARE APPNOTE): entries that are stored or deflated; no encryption, no ZIP64.
#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace knead {

bool begins_zip(const std::string& start);

// The entries of an archive, by its central directory.
class ZipReader {
  public:
    // Throws InputError with the path and the place for a directory outside the file. Keeps a
    // reference to both.
    ZipReader(const std::string& bytes, const std::string& path);

    std::vector<std::string> names() const;
    bool has(const std::string& name) const { return find(name) != nullptr; }
    // Throws InputError for an entry that is missing, has more than `most` bytes, is damaged, or is
    // compressed by another method. The size is known before anything is allocated.
    std::string read(const std::string& name, std::size_t most) const;

  private:
    struct Entry {
        std::string name;
        std::uint32_t method, checksum, packed, size, header;
    };
    const Entry* find(const std::string& name) const;
    [[noreturn]] void fail(const std::string& where, const std::string& expected,
                           const std::string& found) const;

    const std::string& bytes;
    const std::string& path;
    std::vector<Entry> entries;
};

// An archive of stored entries, without times; deterministic. Throws OutputError with `path` for
// more than the 4 GiB of the format.
std::string zip_bytes(const std::vector<std::pair<std::string, std::string>>& entries,
                      const std::string& path);

}  // namespace knead
