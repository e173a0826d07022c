#include "host/base/outputs.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>
#include <utility>

#include "host/base/errors.h"
#include "host/base/interrupt.h"
#include "host/base/paths.h"
#include "host/base/print.h"

namespace knead {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& what)
{
    throw OutputError(path + ": " + what);
}

[[noreturn]] void refuse(const std::string& file, int reason)
{
    fail(file, std::string("cannot be written: ") + std::strerror(reason));
}

void refuse_existing(const fs::path& path)
{
    std::error_code problem;
    if (fs::exists(fs::symlink_status(path, problem)))
        fail(path.string(), "is there already; --overwrite replaces it");
}

// Throws if a file, or folder if `name` ends in '/', cannot be created or replaced.
void check_place(const std::string& folder, std::string name, bool overwrite)
{
    const bool is_folder = name.ends_with('/');
    if (is_folder) name.pop_back();
    const fs::path path = fs::path(folder) / name;
    if (!overwrite) return refuse_existing(path);
    std::error_code problem;
    const fs::file_status status = fs::symlink_status(path, problem);
    if (!fs::exists(status)) return;
    if (fs::is_other(status)) fail(path.string(), "exists and is not a regular file");
    if (fs::is_directory(path, problem) != is_folder)
        fail(path.string(), is_folder ? "is no folder" : "is a folder");
}

constexpr std::string_view partial_mark = ".partial-";

// Target and process id of a partial file: "clip.mp4" and 42 for "clip.partial-42-0.mp4".
std::optional<std::pair<std::string, pid_t>> origin(const std::string& name)
{
    const std::size_t mark = name.rfind(partial_mark);
    if (mark == std::string::npos) return {};
    const char *at = name.data() + mark + partial_mark.size(), *end = name.data() + name.size();
    pid_t process = 0;
    unsigned number = 0;
    const auto first = std::from_chars(at, end, process);
    if (first.ec != std::errc() || process <= 0 || first.ptr == end || *first.ptr != '-') return {};
    const auto second = std::from_chars(first.ptr + 1, end, number);
    if (second.ec != std::errc() || (second.ptr != end && *second.ptr != '.')) return {};
    return {{name.substr(0, mark) + second.ptr, process}};
}

// Maximum length of a file name in the folder [bytes].
std::size_t longest_name(const fs::path& folder)
{
    const long limit = ::pathconf(folder.empty() ? "." : folder.c_str(), _PC_NAME_MAX);
    return limit > 0 ? std::size_t(limit) : 255;
}

// The first bytes of a text, up to `most`, without a truncated UTF-8 character.
std::string first_bytes(const std::string& text, std::size_t most)
{
    std::size_t size = std::min(text.size(), most);
    if (size < text.size())
        while (size > 0 && (text[size] & 0xc0) == 0x80) --size;
    return text.substr(0, size);
}

// "clip.partial-42-0.mp4" for "clip.mp4": keeps the ending, by which programs choose a format.
// Shortens the stem of long names, so that every valid name can be written.
std::string name_beside(const fs::path& file)
{
    static std::atomic<unsigned> made{0};
    constexpr std::size_t longest_ending = 32;  // [bytes]; no file format has a longer one
    const std::string mark =
        std::string(partial_mark) + std::to_string(getpid()) + "-" + std::to_string(made++);
    std::string form = file.extension().string();
    if (form.size() > longest_ending) form.clear();
    const std::size_t limit = longest_name(file.parent_path()), rest = mark.size() + form.size();
    const std::string stem = first_bytes(file.stem().string(), limit > rest ? limit - rest : 0);
    return (file.parent_path() / (stem + mark + form)).string();
}

// Target of a file name with its symbolic links resolved; it need not exist.
fs::path followed(const std::string& file)
{
    fs::path at = file;
    for (int links = 0; links < 40; ++links) {
        std::error_code problem;
        if (!fs::is_symlink(fs::symlink_status(at, problem))) return at;
        const fs::path to = fs::read_symlink(at, problem);
        if (problem) refuse(file, problem.value());
        at = at.parent_path() / to;
    }
    refuse(file, ELOOP);
}

// Waits until the data written so far are on disk. Returns 0 (also if the file system does not
// report) or errno. Called piece by piece, because the final flush cannot be interrupted.
int send(int file)
{
    constexpr unsigned all =
        SYNC_FILE_RANGE_WAIT_BEFORE | SYNC_FILE_RANGE_WRITE | SYNC_FILE_RANGE_WAIT_AFTER;
    if (::sync_file_range(file, 0, 0, all) == 0) return 0;
    return errno == EIO || errno == ENOSPC || errno == EDQUOT ? errno : 0;
}

// Flushes to disk. Some file systems report a full disk only here.
int flush(int file)
{
    while (::fsync(file) != 0)
        if (errno != EINTR) return errno == EINVAL || errno == ENOTSUP ? 0 : errno;
    return 0;
}

// Throws if files cannot be created in the folder.
void probe(const std::string& folder)
{
    const EndHeld held;
    try {
        const PartialFile file((fs::path(folder) / ".knead-probe").string());
    } catch (const OutputError& e) {
        const std::string said = e.what();
        fail(folder, said.substr(said.find("cannot be written")));
    }
}

}  // namespace

PartialFile::PartialFile(const std::string& to) : file(to)
{
    if (file.empty()) fail("\"\"", "cannot be written: the path is empty");
    place = followed(file).string();
    do {
        partial = name_beside(place);
        made = ::open(partial.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        // EEXIST: left by a killed process with the same id.
    } while (made < 0 && (errno == EEXIST || errno == EINTR));
    if (made < 0) refuse(file, errno);
}

PartialFile::~PartialFile()
{
    if (made < 0) return;
    ::close(made);
    ::unlink(partial.c_str());
}

void PartialFile::write(const std::string& bytes)
{
    if (const int reason = write_all(made, bytes)) refuse(file, reason);
}

void PartialFile::append(int from, const std::string& source, std::uint64_t at, std::uint64_t count)
{
    constexpr std::uint64_t piece = std::uint64_t(16) << 20;
    auto place_in_source = off64_t(at);
    while (count > 0) {
        const ssize_t copied = ::copy_file_range(from, &place_in_source, made, nullptr,
                                                 std::size_t(std::min(count, piece)), 0);
        if (copied < 0 && errno == EINTR) continue;
        if (copied <= 0) break;  // not supported between these files, or an error, found below
        count -= std::uint64_t(copied);
    }
    std::string bytes(std::size_t(std::min(count, piece / 16)), '\0');
    while (count > 0) {
        const ssize_t got =
            ::pread(from, bytes.data(), std::size_t(std::min<std::uint64_t>(count, bytes.size())),
                    place_in_source);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0)
            throw InputError(source + ": cannot be read: " +
                             (got < 0 ? std::strerror(errno) : "the file ends before"));
        if (const int reason = write_all(made, std::string_view(bytes).substr(0, std::size_t(got))))
            refuse(file, reason);
        place_in_source += got, count -= std::uint64_t(got);
    }
}

bool PartialFile::write_unless(const std::function<bool()>& stop, const std::string& bytes)
{
    constexpr std::size_t piece = std::size_t(4) << 20;
    for (std::size_t from = 0; from < bytes.size(); from += piece) {
        if (stop()) return false;
        int reason = write_all(made, std::string_view(bytes).substr(from, piece));
        if (reason == 0 && bytes.size() > piece) reason = send(made);
        if (reason) refuse(file, reason);
    }
    return !stop();
}

void PartialFile::put_in_place()
{
    // Do not replace a device file by renaming.
    std::error_code problem;
    if (fs::is_other(fs::symlink_status(place, problem)))
        fail(file, "cannot be written: it exists and is not a regular file");
    int reason = flush(made);
    // Close before renaming: network file systems may report errors only here.
    if (::close(made) != 0 && reason == 0) reason = errno;
    made = -1;
    if (reason == 0 && ::rename(partial.c_str(), place.c_str()) != 0) reason = errno;
    if (reason == 0) return;
    ::unlink(partial.c_str());
    refuse(file, reason);
}

void write_whole(const std::string& file, const std::string& bytes)
{
    write_whole_unless([] { return false; }, file, bytes);
}

void write_in_parts(const std::string& file, const std::function<void(const AddBytes& add)>& make)
{
    if (is_standard(file))
        return make([&](const std::string& bytes) {
            if (const int reason = write_all(STDOUT_FILENO, bytes)) refuse(file, reason);
        });
    struct Stopped {};
    const EndHeld held;  // a signal must not leave a partial file
    PartialFile partial(file);
    try {
        make([&](const std::string& bytes) {
            if (!partial.write_unless([] { return EndHeld::pending(); }, bytes)) throw Stopped();
        });
    } catch (const Stopped&) {
        return;
    }
    partial.put_in_place();
}

bool write_whole_unless(const std::function<bool()>& stop, const std::string& file,
                        const std::string& bytes)
{
    if (is_standard(file)) {
        if (const int reason = write_all(STDOUT_FILENO, bytes)) refuse(file, reason);
        return true;
    }
    const EndHeld held;  // a signal must not leave a partial file
    PartialFile partial(file);
    if (!partial.write_unless([&] { return EndHeld::pending() || stop(); }, bytes)) return false;
    partial.put_in_place();
    return true;
}

FolderLock prepare_folder(const std::string& folder, const std::vector<std::string>& names,
                          bool overwrite, FolderLock lock)
{
    std::error_code problem;
    fs::create_directories(folder, problem);
    if (problem) fail(folder, "cannot be made: " + problem.message());
    if (!fs::is_directory(folder)) fail(folder, "is not a folder");
    probe(folder);
    if (!lock.held()) lock = FolderLock(folder);
    for (const std::string& name : names) check_place(folder, name, overwrite);
    return lock;
}

std::vector<Leftover> leftovers(const std::string& folder)
{
    std::error_code problem;
    std::vector<Leftover> left;
    for (fs::directory_iterator at(folder, problem), end; !problem && at != end;
         at.increment(problem)) {
        const std::string name = at->path().filename().string();
        std::error_code unknown;
        if (!fs::is_regular_file(at->symlink_status(unknown))) continue;
        const auto from = origin(name);
        if (from && ::kill(from->second, 0) != 0 && errno == ESRCH)
            left.push_back({at->path().string(), from->first});
        else if (name.ends_with(lock_name) && !FolderLock::is_held(at->path().string()))
            left.push_back({at->path().string(), lock_name});
    }
    std::sort(left.begin(), left.end(),
              [](const Leftover& a, const Leftover& b) { return a.path < b.path; });
    return left;
}

void remove_partials(const std::string& folder, const std::function<bool(const std::string&)>& ours)
{
    std::error_code problem;
    for (const Leftover& left : leftovers(folder))
        if (ours(left.of)) fs::remove(left.path, problem);
}

void remove_files(const std::string& folder, const std::vector<std::string>& names)
{
    for (const std::string& name : names) {
        const fs::path path = fs::path(folder) / name;
        std::error_code problem;
        fs::remove(path, problem);
        if (problem) fail(path.string(), "cannot be removed: " + problem.message());
    }
}

void prepare_file(const std::string& file, bool overwrite)
{
    if (is_standard(file)) return;
    const fs::path path(file);
    if (!path.has_filename()) fail(file, "is not the name of a file");
    std::error_code problem;
    if (fs::is_directory(path, problem)) fail(file, "is a folder");
    if (!overwrite) refuse_existing(path);
    const EndHeld held;
    const PartialFile probe(file);
}

}  // namespace knead
