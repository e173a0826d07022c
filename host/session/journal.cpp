#include "host/session/journal.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <filesystem>
#include <iterator>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include "host/base/outputs.h"

namespace knead {
namespace {

using JournalClock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto first_pause = 250ms, longest_pause = 8000ms;  // between attempts to write
constexpr auto patience_at_end = 2000ms;                     // with a disk that takes nothing

}  // namespace

// What the journal's thread does. All members but the writer are guarded by `lock`, which is not
// held while anything is made, written or freed.
struct Journal::Work {
    struct WaitingChunk {
        std::function<Chunk()> make;         // null: made
        std::shared_ptr<const Chunk> chunk;  // null: not made yet
        std::size_t bytes = 0;
        Drop drop = Drop::no;
    };

    struct RequestedSave {
        std::string to;
        std::function<std::vector<Chunk>()> more;
        std::vector<std::function<void(const std::string&)>> written;
        std::function<bool(const ChunkHead&)> keep;
        bool begun = false;
    };

    Work(const std::string& file, Options by) : options(by), writer(file) { begin(); }
    Work(const ChunkFile& onto, Options by) : options(by), writer(onto.path(), onto) { begin(); }
    ~Work();
    void begin();

    void add(WaitingChunk one);
    std::vector<WaitingChunk> shed();

    using Held = std::unique_lock<std::mutex>;
    void run();
    bool over() const;
    bool due() const;
    JournalClock::time_point next_due() const;
    void write_group(Held& held);
    std::string try_to_write(std::deque<WaitingChunk>& group, long& lost);
    void begin_save(Held& held);
    void copy(std::string from, std::uint64_t bytes, std::vector<Chunk> more, std::string to,
              std::function<bool(const ChunkHead&)> keep);
    void end_save(Held& held);

    const Options options;
    const JournalClock::duration period = std::chrono::duration_cast<JournalClock::duration>(
        std::chrono::duration<double>(options.commit_every));
    ChunkWriter writer;  // of the journal's thread alone

    mutable std::mutex lock;
    std::condition_variable wake, answer;
    std::deque<WaitingChunk> waiting;
    std::size_t waiting_bytes = 0, written_bytes = 0;  // written: being written
    std::uint64_t committed = 0;
    long dropped = 0;
    std::string trouble;
    long asked = 0, answered = 0, succeeded = 0;  // numbers of flushes
    bool ending = false, discarded = false;
    JournalClock::time_point last_group, next_attempt, end_of_patience;
    JournalClock::duration pause = first_pause;

    std::deque<RequestedSave> saves;  // the first one is being copied if `copier` runs
    std::thread copier;
    std::optional<std::string> copied;  // the copier has ended: "", or why it failed

    std::thread thread;
};

void Journal::Work::begin()
{
    committed = writer.committed();
    last_group = JournalClock::now() - period;
    thread = std::thread([this] { run(); });
}

Journal::Work::~Work()
{
    {
        const Held held(lock);
        ending = true;
        end_of_patience = JournalClock::now() + patience_at_end;
        next_attempt = JournalClock::now();
        pause = first_pause;
    }
    wake.notify_one();
    thread.join();
}

void Journal::Work::add(WaitingChunk one)
{
    std::vector<WaitingChunk> victims;  // freed without the lock
    bool wakes;
    {
        const Held held(lock);
        const std::size_t early = options.longest_queue / 4;
        wakes = waiting.empty() || (waiting_bytes < early && waiting_bytes + one.bytes >= early);
        waiting_bytes += one.bytes;
        waiting.push_back(std::move(one));
        victims = shed();
    }
    if (wakes) wake.notify_one();
}

// Removes and returns what the queue is too long for.
std::vector<Journal::Work::WaitingChunk> Journal::Work::shed()
{
    std::vector<WaitingChunk> victims;
    if (waiting_bytes <= options.longest_queue) return victims;
    const auto is = [](Drop drop) {
        return [=](const WaitingChunk& one) { return one.drop == drop; };
    };
    std::ptrdiff_t count = 0;  // of what may be dropped
    std::size_t bytes = 0;
    for (const WaitingChunk& one : waiting)
        if (one.drop != Drop::no) ++count, bytes += one.bytes;
    while (count > 0 && waiting_bytes > options.longest_queue) {
        const bool single = count == 1 && bytes > options.longest_queue;
        if (single && waiting_bytes - bytes <= options.longest_queue) break;
        auto victim = std::find_if(waiting.begin(), waiting.end(), is(Drop::state));
        if (victim == waiting.end())
            victim = std::prev(
                std::find_if(waiting.rbegin(), waiting.rend(), is(Drop::difference)).base());
        waiting_bytes -= victim->bytes, bytes -= victim->bytes;
        --count, ++dropped;
        victims.push_back(std::move(*victim));
        waiting.erase(victim);
    }
    return victims;
}

void Journal::Work::run()
{
    Held held(lock);
    while (!over()) {
        if (copied) {
            end_save(held);
        } else if (!saves.empty() && !copier.joinable()) {
            begin_save(held);
        } else if (due()) {
            write_group(held);
        } else {
            wake.wait_until(held, next_due());
        }
    }
    held.unlock();
    if (discarded) writer.remove();
}

bool Journal::Work::over() const
{
    if (!ending || !saves.empty() || copier.joinable()) return false;
    if (waiting.empty() || discarded) return true;
    return !trouble.empty() && JournalClock::now() >= end_of_patience;
}

// Whether a group is to be written now.
bool Journal::Work::due() const
{
    if (asked > answered) return true;
    if (ending && discarded) return false;
    if (trouble.empty() && waiting.empty()) return false;
    if (trouble.empty() && (ending || waiting_bytes >= options.longest_queue / 4)) return true;
    return JournalClock::now() >= next_due();
}

JournalClock::time_point Journal::Work::next_due() const
{
    const auto now = JournalClock::now();
    if (!trouble.empty()) return next_attempt;
    if (waiting.empty()) return now + 1h;
    return last_group + period;
}

// Writes all that waits as a group, or puts it back.
void Journal::Work::write_group(Held& held)
{
    std::deque<WaitingChunk> group = std::exchange(waiting, {});
    written_bytes = std::exchange(waiting_bytes, 0);
    const long number = asked;
    last_group = JournalClock::now();
    held.unlock();
    long lost = 0;
    std::string why = try_to_write(group, lost);
    const std::uint64_t end = writer.committed();
    std::vector<WaitingChunk> victims;
    held.lock();
    written_bytes = 0;
    committed = end;
    dropped += lost;
    if (why.empty()) {
        succeeded = number;
        pause = first_pause;
    } else {
        for (const WaitingChunk& one : group) waiting_bytes += one.bytes;
        waiting.insert(waiting.begin(), std::make_move_iterator(group.begin()),
                       std::make_move_iterator(group.end()));
        victims = shed();
        next_attempt = JournalClock::now() + pause;
        pause = ending ? first_pause : std::min<JournalClock::duration>(2 * pause, longest_pause);
    }
    trouble.swap(why);
    answered = number;
    answer.notify_all();
    if (victims.empty()) return;
    held.unlock();
    victims.clear();
    held.lock();
}

// Makes and writes the chunks of a group, and commits it. Returns why not, else "" and an empty
// group. `lost`: counts those that cannot be made or written on any disk, and are no longer in it.
std::string Journal::Work::try_to_write(std::deque<WaitingChunk>& group, long& lost)
{
    const auto out_of = [&](WaitingChunk& one) {
        try {
            if (!one.make) return false;
            one.chunk = std::make_shared<const Chunk>(one.make());
            one.make = nullptr;
            one.bytes = one.chunk->bytes();
            return false;
        } catch (...) {
            ++lost;
            return true;
        }
    };
    std::erase_if(group, out_of);
    try {
        if (!trouble.empty()) writer.retry();  // changed by this thread alone
        std::erase_if(group, [&](const WaitingChunk& one) {
            try {
                writer.add(*one.chunk);
                return false;
            } catch (const std::logic_error&) {  // of no valid kind, flags or size
                ++lost;
                return true;
            }
        });
        writer.commit();
        group.clear();
        return "";
    } catch (const std::exception& e) {
        return e.what();
    }
}

void Journal::Work::begin_save(Held& held)
{
    saves.front().begun = true;
    write_group(held);
    const RequestedSave& save = saves.front();  // stays: others are added behind it
    std::vector<std::shared_ptr<const Chunk>> kept;
    const auto goes = [&](const Chunk& chunk) {
        return !save.keep || save.keep({chunk.kind, chunk.flags, chunk.id, chunk.parent});
    };
    for (const WaitingChunk& one : waiting)
        if (!trouble.empty() && one.chunk && goes(*one.chunk)) kept.push_back(one.chunk);
    // The descriptor still has the log if its path has not.
    const std::string from =
        trouble.empty() ? writer.path() : "/proc/self/fd/" + std::to_string(writer.descriptor());
    held.unlock();
    try {
        std::vector<Chunk> more;
        for (const auto& chunk : kept) more.push_back(*chunk);
        if (save.more)
            for (Chunk& chunk : save.more()) more.push_back(std::move(chunk));
        std::thread started(&Work::copy, this, from, writer.committed(), std::move(more), save.to,
                            save.keep);
        held.lock();
        copier = std::move(started);
    } catch (const std::exception& e) {  // no memory, no thread
        held.lock();
        copied = save.to + ": cannot be written: " + e.what();
    }
}

// On the copier's thread.
void Journal::Work::copy(std::string from, std::uint64_t bytes, std::vector<Chunk> more,
                         std::string to, std::function<bool(const ChunkHead&)> keep)
{
    std::string why;
    try {
        if (keep)
            rewrite_chunks(ChunkFile(from), keep, more, to);
        else
            copy_chunks(from, bytes, more, to);
        // Of a save during which a process was killed.
        const std::filesystem::path saved = to;
        remove_partials(saved.parent_path().string(),
                        [&](const std::string& of) { return of == saved.filename().string(); });
    } catch (const std::exception& e) {
        why = e.what();
    }
    {
        const Held held(lock);
        copied = std::move(why);
    }
    wake.notify_one();
}

void Journal::Work::end_save(Held& held)
{
    const RequestedSave save = std::move(saves.front());
    saves.pop_front();
    const std::string why = *std::exchange(copied, {});
    std::thread ended = std::move(copier);
    held.unlock();
    if (ended.joinable()) ended.join();
    for (const auto& written : save.written)
        if (written) written(why);
    held.lock();
}

Journal::Journal(const std::string& file, Options options)
    : work(std::make_unique<Work>(file, options))
{
}

Journal::Journal(const ChunkFile& onto, Options options)
    : work(std::make_unique<Work>(onto, options))
{
}

Journal::~Journal() = default;

void Journal::add(Chunk chunk, Drop drop)
{
    const std::size_t bytes = chunk.bytes();
    work->add({nullptr, std::make_shared<const Chunk>(std::move(chunk)), bytes, drop});
}

void Journal::add(std::function<Chunk()> make, std::size_t bytes, Drop drop)
{
    work->add({std::move(make), nullptr, bytes, drop});
}

bool Journal::flush()
{
    Work::Held held(work->lock);
    const long number = ++work->asked;
    work->wake.notify_one();
    work->answer.wait(held, [&] { return work->answered >= number; });
    return work->succeeded >= number;
}

void Journal::save(const std::string& to, std::function<std::vector<Chunk>()> more,
                   std::function<void(const std::string&)> written,
                   std::function<bool(const ChunkHead&)> keep)
{
    Work::RequestedSave one{to, std::move(more), {}, std::move(keep)}, before;
    {
        const Work::Held held(work->lock);
        const auto same = std::ranges::find_if(work->saves, [&](const Work::RequestedSave& other) {
            return !other.begun && other.to == to;
        });
        if (same != work->saves.end()) {
            before = std::move(*same);  // freed without the lock
            one.written = std::move(before.written);
            work->saves.erase(same);
        }
        one.written.push_back(std::move(written));
        work->saves.push_back(std::move(one));
    }
    work->wake.notify_one();
}

JournalState Journal::state() const
{
    const Work::Held held(work->lock);
    return {work->writer.path(), work->committed, work->waiting_bytes + work->written_bytes,
            work->dropped, work->trouble};
}

void Journal::discard()
{
    const Work::Held held(work->lock);
    work->discarded = true;
}

}  // namespace knead
