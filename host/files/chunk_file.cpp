#include "host/files/chunk_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <new>
#include <random>
#include <stdexcept>
#include <utility>

#include "host/base/errors.h"
#include "host/base/folder_lock.h"
#include "host/base/interrupt.h"
#include "host/base/machine.h"
#include "host/base/outputs.h"

namespace knead {
namespace fs = std::filesystem;
namespace {

static_assert(std::endian::native == std::endian::little, "the file is written as memory is");

constexpr char session_magic[] = "knead.session\r\n\x1a";  // 16 bytes, without the 0
constexpr std::uint32_t session_version = 1;
constexpr std::size_t file_head_bytes = 32, chunk_header_bytes = 48, commit_bytes = 16;
constexpr ChunkKind commit_kind = "CMIT";
// A block of zstd makes at most 128 KiB of 4 bytes.
constexpr int zstd_most_log = 15;
// Of zstd's window when reading [log2 of bytes]: enough for all its levels but the "ultra" ones. A
// frame that demands more is refused, before it is allocated.
constexpr int zstd_window_log = 23;
constexpr std::size_t io_piece = std::size_t(1) << 20;            // [bytes]
constexpr std::uint64_t small_payload = std::uint64_t(16) << 20;  // is free anywhere [bytes]

template <class T>
T number_at(const char* from, std::size_t bytes = sizeof(T))
{
    T value = 0;
    std::memcpy(&value, from, bytes);
    return value;
}

template <class T>
void put_at(char* to, T value, std::size_t bytes = sizeof(T))
{
    std::memcpy(to, &value, bytes);
}

using ChunkHeader = std::array<char, chunk_header_bytes>;

ChunkHeader chunk_header(const ChunkHead& head, std::uint64_t salt)
{
    ChunkHeader bytes{};
    put_at(&bytes[0], head.kind.code);
    put_at(&bytes[4], std::uint16_t(head.flags));
    put_at(&bytes[6], head.raw, 5);
    put_at(&bytes[11], head.stored, 5);
    put_at(&bytes[16], head.id);
    put_at(&bytes[24], head.parent);
    put_at(&bytes[32], head.hash);
    put_at(&bytes[40], std::uint64_t(XXH3_64bits_withSeed(bytes.data(), 40, salt)));
    return bytes;
}
std::uint64_t header_hash(const char* header) { return number_at<std::uint64_t>(header + 40); }

// `at`: offset of the header in the file.
ChunkHead chunk_head(const char* header, std::uint64_t at)
{
    ChunkHead head;
    head.kind = ChunkKind(number_at<std::uint32_t>(header));
    head.flags = number_at<std::uint16_t>(header + 4);
    head.raw = number_at<std::uint64_t>(header + 6, 5);
    head.stored = number_at<std::uint64_t>(header + 11, 5);
    head.id = number_at<std::uint64_t>(header + 16);
    head.parent = number_at<std::uint64_t>(header + 24);
    head.hash = number_at<std::uint64_t>(header + 32);
    head.at = at + chunk_header_bytes;
    return head;
}

std::uint64_t payload_hash(std::string_view payload)
{
    return XXH3_64bits(payload.data(), payload.size());
}

// `hashes`: of the headers since the previous commit.
std::uint64_t chained(std::uint64_t salt, std::uint64_t previous,
                      const std::vector<std::uint64_t>& hashes)
{
    std::vector<std::uint64_t> all = {salt, previous};
    all.insert(all.end(), hashes.begin(), hashes.end());
    return XXH3_64bits(all.data(), all.size() * sizeof all[0]);
}

// Whether sizes can be those of a chunk. A small file cannot state a large payload.
bool believable(const ChunkHead& head)
{
    if (head.raw > longest_chunk || head.stored > longest_chunk) return false;
    return head.flags & chunk_compressed ? head.raw >> zstd_most_log <= head.stored
                                         : head.raw == head.stored;
}

// The first bytes of a file.
std::string new_head(std::uint64_t salt)
{
    std::string head(session_magic, 16);
    head.resize(file_head_bytes);
    put_at(&head[16], session_version);
    put_at(&head[24], salt);
    return head;
}

std::uint64_t new_salt()
{
    std::random_device random;
    return std::uint64_t(random()) << 32 | random();
}

// A header and the payload of a commit.
std::string commit_chunk(std::uint64_t number, std::uint64_t count, std::uint64_t chain,
                         std::uint64_t salt)
{
    char payload[commit_bytes];
    put_at(payload, count);
    put_at(payload + 8, chain);
    const std::string_view all(payload, sizeof payload);
    ChunkHead head{commit_kind, 0, number, 0, commit_bytes, commit_bytes, payload_hash(all)};
    const ChunkHeader header = chunk_header(head, salt);
    return std::string(header.data(), header.size()).append(all);
}

ChunkHead head_of(const Chunk& chunk)
{
    if (chunk.kind == commit_kind || chunk.flags > 0xffff)
        throw std::invalid_argument("no such kind or flags of chunks");
    ChunkHead head{chunk.kind,
                   chunk.flags,
                   chunk.id,
                   chunk.parent,
                   chunk.raw,
                   chunk.stored.size(),
                   payload_hash(chunk.stored)};
    if (!believable(head)) throw std::length_error("a chunk of impossible size");
    return head;
}

// Reads up to `size` bytes; fewer at the end of the file. Throws InputError.
std::size_t read_at(int file, const std::string& path, std::uint64_t at, char* to, std::size_t size)
{
    std::size_t done = 0;
    while (done < size) {
        const ssize_t got = ::pread(file, to + done, size - done, off_t(at + done));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) throw InputError(path + ": cannot be read: " + std::strerror(errno));
        if (got == 0) break;
        done += std::size_t(got);
    }
    return done;
}

// Returns 0 or errno.
int write_at(int file, std::uint64_t at, std::string_view bytes)
{
    for (std::size_t done = 0; done < bytes.size();) {
        const ssize_t step =
            ::pwrite(file, bytes.data() + done, bytes.size() - done, off_t(at + done));
        if (step < 0 && errno == EINTR) continue;
        if (step <= 0) return step == 0 ? ENOSPC : errno;
        done += std::size_t(step);
    }
    return 0;
}

// Waits until all written bytes are on disk. Returns 0 or errno.
int flush_data(int file)
{
    while (::fdatasync(file) != 0)
        if (errno != EINTR) return errno == EINVAL || errno == ENOTSUP ? 0 : errno;
    return 0;
}

// Puts names made or removed in the folder on disk; not all file systems can.
void flush_folder(const std::string& folder)
{
    const int opened = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (opened < 0) return;
    while (::fsync(opened) != 0 && errno == EINTR) {
    }
    ::close(opened);
}

// A zstd frame, uncompressed piece by piece.
class ZstdReader {
  public:
    ZstdReader() : context(ZSTD_createDCtx()), out(ZSTD_DStreamOutSize(), '\0')
    {
        if (!context) throw std::bad_alloc();
        ZSTD_DCtx_setParameter(context, ZSTD_d_windowLogMax, zstd_window_log);
    }
    ZstdReader(const ZstdReader&) = delete;
    ~ZstdReader() { ZSTD_freeDCtx(context); }

    // Returns why the frame is damaged, or null. `sink` gets at most `most` bytes in all.
    template <class Sink>
    const char* feed(std::string_view bytes, std::uint64_t most, const Sink& sink)
    {
        ZSTD_inBuffer from{bytes.data(), bytes.size(), 0};
        bool full = false;  // there may be more than the buffer took
        while (from.pos < from.size || full) {
            if (frame_ended) return "bytes after its end";
            ZSTD_outBuffer to{out.data(), out.size(), 0};
            const std::size_t answer = ZSTD_decompressStream(context, &to, &from);
            if (ZSTD_isError(answer)) return ZSTD_getErrorName(answer);
            if (to.pos > most - given) return "more bytes than its header states";
            sink(std::string_view(out.data(), to.pos));
            given += to.pos;
            frame_ended = answer == 0;
            full = to.pos == to.size && !frame_ended;
        }
        return nullptr;
    }
    bool ended(std::uint64_t raw) const { return frame_ended && given == raw; }

  private:
    ZSTD_DCtx* const context;
    std::string out;
    std::uint64_t given = 0;
    bool frame_ended = false;
};

}  // namespace

std::string ChunkKind::text() const
{
    std::string letters;
    for (int i = 0; i < 4; ++i) {
        const char letter = char(code >> 8 * i & 0xff);
        letters += letter > ' ' && letter <= '~' ? letter : '?';
    }
    return letters;
}

bool begins_session(std::string_view start)
{
    return start.starts_with(std::string_view(session_magic, 16));
}

Chunk chunk_of(ChunkKind kind, std::string_view payload, std::uint64_t id, std::uint64_t parent,
               std::uint32_t flags)
{
    if (payload.size() > longest_chunk) throw std::length_error("a chunk of impossible size");
    Chunk chunk{kind, flags & ~chunk_compressed, id, parent, payload.size(), {}};
    std::string packed(ZSTD_compressBound(payload.size()), '\0');
    const std::size_t size =
        ZSTD_compress(packed.data(), packed.size(), payload.data(), payload.size(), 1);
    if (!ZSTD_isError(size) && size < payload.size()) {
        chunk.flags |= chunk_compressed;
        chunk.stored.assign(packed, 0, size);
    } else {
        chunk.stored = payload;
    }
    return chunk;
}

struct ChunkFile::Open {
    // Up to `most` bytes; without the headers, for a copy.
    Open(const std::string& name, std::uint64_t most);
    explicit Open(const std::string& name) : Open(name, all_bytes) {}
    static constexpr std::uint64_t all_bytes = ~std::uint64_t(0);
    Open(const Open&) = delete;
    ~Open()
    {
        if (file >= 0) ::close(file);
    }

    // Pieces of a payload as stored. Throws InputError at the end if their hash is wrong.
    template <class Sink>
    void each_stored(const ChunkHead& head, const Sink& sink) const;
    // The same, uncompressed.
    template <class Sink>
    void each_raw(const ChunkHead& head, const Sink& sink) const;

    std::string path;
    int file = -1;
    struct stat named {};
    std::uint64_t size = 0, salt = 0;
    std::uint32_t version = 0;
    std::vector<ChunkHead> heads;
    std::uint64_t end = 0, commits = 0;
    std::uint64_t chain = 0;  // of the last commit
    std::string broken;

  private:
    void open_file();
    void read_head();
    bool next(std::uint64_t& at, std::vector<std::uint64_t>& hashes);
    bool at_commit(const ChunkHead& head, const char* payload, std::size_t group,
                   std::uint64_t expected) const;
    bool damaged(std::uint64_t at, const std::string& what)
    {
        broken = fmt::format("byte {}: {}", at, what);
        return false;
    }
    [[noreturn]] void refuse_chunk(const ChunkHead& head, const std::string& why) const
    {
        throw InputError(
            fmt::format("{}: byte {}: chunk {}: {}", path, head.at, head.kind.text(), why));
    }
};

ChunkFile::Open::Open(const std::string& name, std::uint64_t most) : path(name)
{
    try {
        open_file();
        size = std::min(size, most);
        read_head();
        std::vector<std::uint64_t> hashes;
        std::size_t valid = 0;
        for (std::uint64_t at = end, commit = 0; next(at, hashes);)
            if (commits > commit) {
                commit = commits;
                if (most != all_bytes) heads.clear();
                valid = heads.size();
            }
        if (commits == 0)
            throw InputError(path + ": has no valid group" + (broken.empty() ? "" : ": " + broken));
        if (broken.empty() && heads.size() > valid)
            broken = fmt::format("byte {}: {} chunks without a commit", end, heads.size() - valid);
        heads.resize(valid);
    } catch (...) {
        if (file >= 0) ::close(std::exchange(file, -1));
        throw;
    }
}

void ChunkFile::Open::open_file()
{
    do file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    while (file < 0 && errno == EINTR);
    if (file < 0 || ::fstat(file, &named) != 0)
        throw InputError(path + ": cannot be read: " + std::strerror(errno));
    if (!S_ISREG(named.st_mode)) throw InputError(path + ": is not a regular file");
    size = std::uint64_t(named.st_size);
}

void ChunkFile::Open::read_head()
{
    char head[file_head_bytes] = {};
    const std::size_t got = read_at(file, path, 0, head, sizeof head);
    if (!begins_session({head, got}))
        throw InputError(path + ": byte 0: expected a session, found something else");
    if (got < sizeof head || size < sizeof head)
        throw InputError(path + ": expected a session, found its beginning");
    version = number_at<std::uint32_t>(head + 16);
    if (version != session_version)
        throw InputError(fmt::format("{}: byte 16: expected version {}, found {}{}", path,
                                     session_version, version,
                                     version > session_version ? ", of a newer knead" : ""));
    salt = number_at<std::uint64_t>(head + 24);
    chain = payload_hash({head, sizeof head});
    end = sizeof head;
}

// Reads the chunk at `at`, whose header is checked, and moves behind it. `hashes`: of headers since
// the last commit. Returns false where the valid part of the file ends.
bool ChunkFile::Open::next(std::uint64_t& at, std::vector<std::uint64_t>& hashes)
{
    const std::uint64_t left = size - at;
    if (left == 0) return false;
    char bytes[chunk_header_bytes + commit_bytes] = {};
    const std::size_t got = left < chunk_header_bytes
                                ? 0
                                : read_at(file, path, at, bytes, std::min(left, sizeof bytes));
    if (got < chunk_header_bytes) return damaged(at, "the header of a chunk is cut off");
    if (XXH3_64bits_withSeed(bytes, 40, salt) != header_hash(bytes))
        return damaged(at, "expected a chunk of this session, found something else");
    const ChunkHead head = chunk_head(bytes, at);
    if (!believable(head)) return damaged(at, "a chunk of impossible size");
    if (head.stored > left - chunk_header_bytes)
        return damaged(at, fmt::format("expected a chunk of {} bytes, found {}", head.stored,
                                       left - chunk_header_bytes));
    at = head.at + head.stored;
    if (head.kind != commit_kind) {
        hashes.push_back(header_hash(bytes));
        heads.push_back(head);
        return true;
    }
    const std::uint64_t expected = chained(salt, chain, hashes);
    if (!at_commit(head, bytes + chunk_header_bytes, hashes.size(), expected))
        return damaged(at, "a commit of other chunks");
    ++commits;
    chain = expected;
    end = at;
    hashes.clear();
    return true;
}

bool ChunkFile::Open::at_commit(const ChunkHead& head, const char* payload, std::size_t group,
                                std::uint64_t expected) const
{
    return head.flags == 0 && head.id == commits + 1 && head.parent == 0 &&
           head.stored == commit_bytes && payload_hash({payload, commit_bytes}) == head.hash &&
           number_at<std::uint64_t>(payload) == group &&
           number_at<std::uint64_t>(payload + 8) == expected;
}

template <class Sink>
void ChunkFile::Open::each_stored(const ChunkHead& head, const Sink& sink) const
{
    std::string piece(std::size_t(std::min<std::uint64_t>(head.stored, io_piece)), '\0');
    XXH3_state_t hash;
    XXH3_64bits_reset(&hash);
    for (std::uint64_t done = 0; done < head.stored;) {
        const auto size_now = std::size_t(std::min<std::uint64_t>(head.stored - done, io_piece));
        if (read_at(file, path, head.at + done, piece.data(), size_now) < size_now)
            refuse_chunk(head, "the file ends before it");
        XXH3_64bits_update(&hash, piece.data(), size_now);
        sink(std::string_view(piece.data(), size_now));
        done += size_now;
    }
    if (XXH3_64bits_digest(&hash) != head.hash)
        refuse_chunk(head, "damaged: its checksum is not that of its bytes");
}

template <class Sink>
void ChunkFile::Open::each_raw(const ChunkHead& head, const Sink& sink) const
{
    if (!head.readable())
        refuse_chunk(head, fmt::format("flags {:#x}, of a newer knead", head.flags));
    if (!(head.flags & chunk_compressed)) return each_stored(head, sink);
    ZstdReader frame;
    each_stored(head, [&](std::string_view bytes) {
        if (const char* why = frame.feed(bytes, head.raw, sink))
            refuse_chunk(head, std::string("damaged: ") + why);
    });
    if (!frame.ended(head.raw)) refuse_chunk(head, "damaged: fewer bytes than its header states");
}

ChunkFile::ChunkFile(const std::string& file) : open(std::make_shared<const Open>(file)) {}

const std::string& ChunkFile::path() const { return open->path; }
const std::vector<ChunkHead>& ChunkFile::chunks() const { return open->heads; }
std::uint64_t ChunkFile::end() const { return open->end; }
std::uint64_t ChunkFile::size() const { return open->size; }
std::uint64_t ChunkFile::salt() const { return open->salt; }
int ChunkFile::version() const { return int(open->version); }
long ChunkFile::commits() const { return long(open->commits); }
const std::string& ChunkFile::broken_by() const { return open->broken; }

namespace {

void check_memory(const std::string& path, const ChunkHead& head, std::uint64_t bytes)
{
    if (bytes <= small_payload) return;
    const std::uint64_t available = available_memory();
    if (bytes > available)
        throw MemoryError(fmt::format("{}: chunk {} needs {:.1f} MiB, and {:.1f} MiB are free",
                                      path, head.kind.text(), double(bytes) / 0x1p20,
                                      double(available) / 0x1p20));
}

// Appends to `all`, whose capacity grows with what arrives, up to `most` bytes exactly.
void append_within(std::string& all, std::string_view bytes, std::uint64_t most)
{
    if (all.capacity() - all.size() < bytes.size()) {
        std::string larger;
        larger.reserve(std::size_t(std::min<std::uint64_t>(
            most, std::max(2 * all.capacity(), all.size() + bytes.size()))));
        larger.append(all);
        all.swap(larger);
    }
    all.append(bytes);
}

}  // namespace

std::string ChunkFile::payload(const ChunkHead& head) const
{
    check_memory(path(), head, head.raw);
    std::string all;
    open->each_raw(head, [&](std::string_view bytes) { append_within(all, bytes, head.raw); });
    return all;
}

Chunk ChunkFile::stored(const ChunkHead& head) const
{
    check_memory(path(), head, head.stored);
    Chunk chunk{head.kind, head.flags, head.id, head.parent, head.raw, {}};
    open->each_stored(
        head, [&](std::string_view bytes) { append_within(chunk.stored, bytes, head.stored); });
    return chunk;
}

void ChunkFile::verify(const std::function<bool()>& stop) const
{
    for (const ChunkHead& head : chunks()) {
        if (stop && stop()) return;
        const auto ignore = [](std::string_view) {};
        head.readable() ? open->each_raw(head, ignore) : open->each_stored(head, ignore);
    }
}

struct ChunkWriter::Open {
    explicit Open(const std::string& file);
    ~Open()
    {
        if (file >= 0) ::close(file);
    }
    void create();
    void go_on(const ChunkFile::Open& onto);
    void take_lock();
    void check_file();
    void write(std::string_view bytes);
    void write_commit();
    void call(int reason)
    {
        if (reason != 0) fail(std::string("cannot be written: ") + std::strerror(reason));
    }
    [[noreturn]] void fail(const std::string& why)
    {
        trouble = path + ": " + why;
        throw OutputError(trouble);
    }
    void check_working() const
    {
        if (!trouble.empty()) throw OutputError(trouble);
    }

    const std::string path, folder;
    FolderLock holder;  // released after the file is closed
    int file = -1;
    std::uint64_t salt = 0, chain = 0, commits = 0;
    std::uint64_t committed = 0, at = 0, last_at = 0;
    std::vector<std::uint64_t> hashes;  // of headers since the last commit
    std::string trouble;
};

ChunkWriter::Open::Open(const std::string& name)
    : path(name), folder(fs::path(name).parent_path().string())
{
    const std::string own = fs::path(name).filename().string();
    if (own.empty()) fail("is not the name of a file");
    holder = FolderLock(folder, own);
}

void ChunkWriter::Open::take_lock()
{
    if (!lock_open_file(file))
        fail("another process is writing there; wait until it has ended, or choose another name");
}

// The file gets its name when it is complete, where the file system has files without a name.
void ChunkWriter::Open::create()
{
    const EndHeld held;
    constexpr int flags = O_RDWR | O_CLOEXEC;
    file = ::open(folder.empty() ? "." : folder.c_str(), flags | O_TMPFILE, 0600);
    const bool nameless = file >= 0;
    if (!nameless) file = ::open(path.c_str(), flags | O_CREAT | O_EXCL, 0600);
    if (file < 0 && errno == EEXIST) fail("is there already");
    if (file < 0) call(errno);
    try {
        take_lock();
        salt = new_salt();
        const std::string head = new_head(salt);
        chain = payload_hash(head);
        write(head);
        write_commit();
        if (nameless) {
            const std::string link = "/proc/self/fd/" + std::to_string(file);
            if (::linkat(AT_FDCWD, link.c_str(), AT_FDCWD, path.c_str(), AT_SYMLINK_FOLLOW) != 0) {
                if (errno == EEXIST) fail("is there already");
                call(errno);
            }
        }
    } catch (...) {
        if (!nameless) ::unlink(path.c_str());
        throw;
    }
    flush_folder(folder.empty() ? "." : folder);
}

void ChunkWriter::Open::go_on(const ChunkFile::Open& onto)
{
    do file = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK);
    while (file < 0 && errno == EINTR);
    if (file < 0) call(errno);
    take_lock();
    struct stat now {};
    if (::fstat(file, &now) != 0) call(errno);
    if (now.st_dev != onto.named.st_dev || now.st_ino != onto.named.st_ino ||
        now.st_size != onto.named.st_size)
        fail("has changed since it was read");
    salt = onto.salt, chain = onto.chain, commits = onto.commits, committed = onto.end;
}

// Throws if another program has removed the file or cut it.
void ChunkWriter::Open::check_file()
{
    struct stat now {};
    if (::fstat(file, &now) != 0) call(errno);
    if (now.st_nlink == 0) fail("cannot be written: it was removed");
    if (std::uint64_t(now.st_size) < committed) fail("cannot be written: it was cut");
}

void ChunkWriter::Open::write(std::string_view bytes)
{
    call(write_at(file, at, bytes));
    at += bytes.size();
}

void ChunkWriter::Open::write_commit()
{
    // The chunks are on disk before the commit that counts them.
    if (!hashes.empty()) call(flush_data(file));
    const std::uint64_t next = chained(salt, chain, hashes);
    write(commit_chunk(commits + 1, hashes.size(), next, salt));
    call(flush_data(file));
    chain = next, committed = at, ++commits;
    hashes.clear();
}

ChunkWriter::ChunkWriter(const std::string& file) : open(std::make_unique<Open>(file))
{
    open->create();
}

ChunkWriter::ChunkWriter(const std::string& file, const ChunkFile& onto)
    : open(std::make_unique<Open>(file))
{
    open->go_on(*onto.open);
    retry();
}

ChunkWriter::~ChunkWriter() = default;

void ChunkWriter::add(const Chunk& chunk)
{
    const ChunkHead head = head_of(chunk);
    open->check_working();
    const ChunkHeader header = chunk_header(head, open->salt);
    open->hashes.push_back(header_hash(header.data()));
    open->write({header.data(), header.size()});
    open->last_at = open->at;
    open->write(chunk.stored);
}

void ChunkWriter::commit()
{
    open->check_working();
    if (open->hashes.empty()) return;
    open->check_file();
    open->write_commit();
}

void ChunkWriter::retry()
{
    open->check_file();
    while (::ftruncate(open->file, off_t(open->committed)) != 0)
        if (errno != EINTR) open->call(errno);
    open->at = open->committed;
    open->hashes.clear();
    open->trouble.clear();
}

std::uint64_t ChunkWriter::committed() const { return open->committed; }
std::uint64_t ChunkWriter::last_at() const { return open->last_at; }
const std::string& ChunkWriter::path() const { return open->path; }
int ChunkWriter::descriptor() const { return open->file; }

void ChunkWriter::remove()
{
    struct stat opened {
    }, named{};
    if (::fstat(open->file, &opened) == 0 && ::stat(open->path.c_str(), &named) == 0 &&
        opened.st_dev == named.st_dev && opened.st_ino == named.st_ino)
        ::unlink(open->path.c_str());
}

void copy_chunks(const std::string& from, std::uint64_t bytes, const std::vector<Chunk>& more,
                 const std::string& to)
{
    const ChunkFile::Open source(from, bytes);
    if (source.end != bytes)
        throw InputError(fmt::format("{}: byte {}: expected the end of a group", from, bytes));
    std::error_code none;
    if (fs::equivalent(from, to, none))
        throw OutputError(to + ": is the file that is to be copied; choose another name");
    const EndHeld held;  // a signal must not leave a partial file
    PartialFile copy(to);
    copy.append(source.file, from, 0, bytes);
    std::vector<std::uint64_t> hashes;
    for (const Chunk& chunk : more) {
        const ChunkHeader header = chunk_header(head_of(chunk), source.salt);
        hashes.push_back(header_hash(header.data()));
        copy.write(std::string(header.data(), header.size()));
        copy.write(chunk.stored);
    }
    if (!more.empty())
        copy.write(commit_chunk(source.commits + 1, more.size(),
                                chained(source.salt, source.chain, hashes), source.salt));
    copy.put_in_place();
}

namespace {

// A new file of one group, atomically: of the chunks that each_chunk(add) adds.
template <class Chunks>
void write_group(const std::string& to, const Chunks& each_chunk)
{
    const EndHeld held;  // a signal must not leave a partial file
    PartialFile file(to);
    const std::uint64_t salt = new_salt();
    const std::string start = new_head(salt);
    file.write(start);
    std::vector<std::uint64_t> hashes;
    each_chunk([&](const Chunk& chunk) {
        const ChunkHeader header = chunk_header(head_of(chunk), salt);
        hashes.push_back(header_hash(header.data()));
        file.write(std::string(header.data(), header.size()));
        file.write(chunk.stored);
    });
    file.write(commit_chunk(1, hashes.size(), chained(salt, payload_hash(start), hashes), salt));
    file.put_in_place();
}

}  // namespace

void write_chunks(const std::vector<Chunk>& chunks, const std::string& to)
{
    write_group(to, [&](const auto& add) {
        for (const Chunk& chunk : chunks) add(chunk);
    });
}

void rewrite_chunks(const ChunkFile& from, const std::function<bool(const ChunkHead&)>& keep,
                    const std::vector<Chunk>& more, const std::string& to)
{
    write_group(to, [&](const auto& add) {
        for (const ChunkHead& head : from.chunks())
            if (keep(head)) add(from.stored(head));
        for (const Chunk& chunk : more) add(chunk);
    });
}

}  // namespace knead
