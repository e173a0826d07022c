// Container of sessions: a sequence of chunks in groups, appended and never rewritten. A group is
// valid from its commit on; the last valid commit is the end of the file. The kinds of chunks are
// unknown here (host/session/session_file.h). Layout: docs/reference/formats.md.
//
//     head, 32 bytes: magic "knead.session\r\n\x1a", u32 version, u32 0, u64 random salt
//     chunk: header of 48 bytes, payload as stored
//         kind u32, flags u16, raw u40, stored u40, id u64, parent u64,
//         u64 XXH3 of the payload as stored, u64 XXH3 of the 40 bytes before, seeded by the salt
//     commit: a chunk of kind CMIT, whose id is its number from 1 and whose payload is
//         u64 count of chunks since the previous commit,
//         u64 XXH3 of the salt, the previous commit's (first: XXH3 of the head), and the hashes of
//         the chunks' headers
//
// All numbers are little-endian; u40 has five bytes. Sizes are at most longest_chunk.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace knead {

// Four letters, as in a file.
struct ChunkKind {
    std::uint32_t code = 0;
    constexpr ChunkKind() = default;
    constexpr ChunkKind(const char (&name)[5])
    {
        for (int i = 3; i >= 0; --i) code = code << 8 | std::uint8_t(name[i]);
    }
    explicit constexpr ChunkKind(std::uint32_t as_stored) : code(as_stored) {}
    std::string text() const;
    bool operator==(const ChunkKind&) const = default;
};

// Flags, 16 bits.
constexpr std::uint32_t chunk_ancillary = 1;   // a reader that does not know the kind skips it
constexpr std::uint32_t chunk_compressed = 2;  // zstd
// A payload with other flags cannot be read by this version.
constexpr std::uint32_t chunk_flags = chunk_ancillary | chunk_compressed;

constexpr std::uint64_t longest_chunk = std::uint64_t(1) << 36;  // raw or stored [bytes]

struct ChunkHead {
    ChunkKind kind;
    std::uint32_t flags = 0;
    std::uint64_t id = 0, parent = 0;   // given by the writer of the kind; 0: none
    std::uint64_t raw = 0, stored = 0;  // bytes
    std::uint64_t hash = 0;             // XXH3 of the payload as stored
    std::uint64_t at = 0;               // offset of the payload in the file
    bool ancillary() const { return flags & chunk_ancillary; }
    bool readable() const { return (flags & ~chunk_flags) == 0; }
};

// A chunk to be written. Thread-safe to make: compresses in the caller's thread.
struct Chunk {
    ChunkKind kind;
    std::uint32_t flags = 0;
    std::uint64_t id = 0, parent = 0;
    std::uint64_t raw = 0;
    std::string stored;
    std::size_t bytes() const { return stored.size() + 48; }
};
// Compressed by zstd level 1 if that is smaller. Throws std::length_error for more than
// longest_chunk.
Chunk chunk_of(ChunkKind kind, std::string_view payload, std::uint64_t id = 0,
               std::uint64_t parent = 0, std::uint32_t flags = 0);

// Whether the first bytes of a file, at least 16, are those of a session.
bool begins_session(std::string_view start);

// A file of valid groups, read by offset. Copies share the descriptor.
class ChunkFile {
  public:
    // Reads the headers up to the last valid commit. Throws InputError for a file that is no
    // session, is of a newer version, or has no valid commit. Allocates in proportion to the number
    // of headers in the file, never by sizes that it states.
    explicit ChunkFile(const std::string& file);

    const std::string& path() const;
    // In the order of the file, without commits. Those of kinds a reader does not know included.
    const std::vector<ChunkHead>& chunks() const;
    std::uint64_t end() const;   // bytes up to and with the last valid commit
    std::uint64_t size() const;  // of the file, when it was opened
    std::uint64_t salt() const;
    int version() const;
    long commits() const;
    // Why the rest of the file is not valid, with its place; "": nothing is left.
    const std::string& broken_by() const;
    // Payload, uncompressed. Checks its hash. Throws InputError if it is damaged, MemoryError if it
    // is larger than what is free. Memory grows with the actual output, up to head.raw.
    std::string payload(const ChunkHead& head) const;
    // The chunk as it can be added to another file. Checks its hash. Throws as payload().
    Chunk stored(const ChunkHead& head) const;
    // Checks and uncompresses all payloads, in pieces; with flags of a newer version checks the
    // hash alone. Returns early if `stop` returns true. Throws InputError at the first that is
    // damaged.
    void verify(const std::function<bool()>& stop = {}) const;

  private:
    friend class ChunkWriter;
    friend void copy_chunks(const std::string&, std::uint64_t, const std::vector<Chunk>&,
                            const std::string&);
    struct Open;
    explicit ChunkFile(std::shared_ptr<const Open> opened) : open(std::move(opened)) {}
    std::shared_ptr<const Open> open;
};

// Appends to a session file, which is locked meanwhile: by flock(2), and by a FolderLock of its
// name, which tells other processes the holder. All members throw OutputError with the path and the
// reason; after a failure nothing of the group counts, add() and commit() throw again, and retry()
// goes on behind the last commit.
class ChunkWriter {
  public:
    // A new file, which must not exist, readable by its owner alone. It appears with a commit of no
    // chunks, so that any file of that name is valid.
    explicit ChunkWriter(const std::string& file);
    // Appends to a file behind its last valid commit: the rest is cut off. `onto` must be opened
    // from that file as it is; a file that another process has changed since is refused.
    ChunkWriter(const std::string& file, const ChunkFile& onto);
    ~ChunkWriter();
    ChunkWriter(const ChunkWriter&) = delete;

    void add(const Chunk& chunk);
    // Ends the group: flushes its chunks to disk, then the commit. Nothing added: no effect.
    void commit();
    // Cuts off what follows the last commit; the chunks since are lost.
    void retry();
    std::uint64_t committed() const;  // bytes up to and with the last commit
    std::uint64_t last_at() const;    // offset of the last added chunk's payload
    const std::string& path() const;
    int descriptor() const;
    void remove();  // deletes the file, if its path still names it; never throws

  private:
    struct Open;
    std::unique_ptr<Open> open;
};

// Copies the first `bytes` of a session file, which must end at a commit, into another, atomically
// (PartialFile), and appends `more` as a last group if there is any. The copy has the same salt and
// can be appended to. Throws OutputError, and InputError if the source is damaged.
void copy_chunks(const std::string& from, std::uint64_t bytes, const std::vector<Chunk>& more,
                 const std::string& to);

// Writes the chunks as one group into a new file with a salt of its own, atomically (PartialFile).
// Throws OutputError.
void write_chunks(const std::vector<Chunk>& chunks, const std::string& to);

// Writes the chunks for which `keep` is true, and `more`, as one group into a new file with a salt
// of its own, atomically. Throws as copy_chunks().
void rewrite_chunks(const ChunkFile& from, const std::function<bool(const ChunkHead&)>& keep,
                    const std::vector<Chunk>& more, const std::string& to);

}  // namespace knead
