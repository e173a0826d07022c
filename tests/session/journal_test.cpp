// The working log: what was committed is never lost, and nobody waits for the disk.
#include "host/session/journal.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <future>
#include <new>
#include <random>
#include <thread>

#include "host/base/errors.h"
#include "tests/faulty_disk.h"
#include "tests/folder.h"
#include "tests/reason.h"
#include "tests/sanitized.h"
#include "tests/small_disk.h"

namespace knead {
namespace {
namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Drop = Journal::Drop;

const Journal::Options often{0.01, std::size_t(64) << 20}, never_alone{1e6, std::size_t(64) << 20};

std::string payload_of(std::uint64_t id)
{
    std::mt19937_64 random(id);
    std::string text(random() % (id % 50 == 0 ? 200000 : 2000), char('a' + random() % 26));
    return text + std::to_string(id);
}
Chunk numbered(std::uint64_t id) { return chunk_of("TEST", payload_of(id), id); }

std::vector<std::uint64_t> ids_in(const std::string& file)
{
    const ChunkFile read(file);
    read.verify();
    std::vector<std::uint64_t> ids;
    for (const ChunkHead& head : read.chunks()) ids.push_back(head.id);
    return ids;
}
std::vector<std::uint64_t> up_to(std::uint64_t last)
{
    std::vector<std::uint64_t> ids;
    for (std::uint64_t id = 1; id <= last; ++id) ids.push_back(id);
    return ids;
}

template <class Condition>
bool comes(const Condition& condition)
{
    for (int i = 0; i < 20000 && !condition(); ++i) std::this_thread::sleep_for(1ms);
    return condition();
}

class JournalTest : public InFolder {
  protected:
    ~JournalTest() override { disk.reset(); }
    const std::string file = path("a.log"), copy = path("copy.knead");

    // Saves and waits; returns why not.
    std::string saved(Journal& journal, const std::string& to, std::vector<Chunk> more = {})
    {
        std::promise<std::string> promise;
        journal.save(
            to, [&] { return more; }, [&](const std::string& why) { promise.set_value(why); });
        return promise.get_future().get();
    }
};

TEST_F(JournalTest, AFlushCommitsAllSoFar)
{
    Journal journal(file, never_alone);
    EXPECT_TRUE(journal.flush());
    for (std::uint64_t id = 1; id <= 100; ++id) journal.add(numbered(id));
    EXPECT_TRUE(journal.flush());
    EXPECT_EQ(ids_in(file), up_to(100));
    const JournalState state = journal.state();
    EXPECT_EQ(state.file, file);
    EXPECT_EQ(state.committed, fs::file_size(file));
    EXPECT_EQ(state.waiting, 0u);
    EXPECT_EQ(state.trouble, "");
}

TEST_F(JournalTest, WhatWaitsIsCommittedEachInterval)
{
    Journal journal(file, {0.05, std::size_t(64) << 20});
    for (std::uint64_t id = 1; id <= 3; ++id) {
        journal.add(numbered(id));
        EXPECT_TRUE(comes([&] { return journal.state().waiting == 0; }));
        EXPECT_EQ(ids_in(file), up_to(id));
    }
}

TEST_F(JournalTest, ALongQueueIsCommittedBeforeTheInterval)
{
    Journal journal(file, {1e6, 1000});
    journal.add(numbered(1));
    EXPECT_TRUE(comes([&] { return journal.state().waiting == 0; }));  // the first does not wait
    for (std::uint64_t id = 2; id <= 10; ++id) journal.add(numbered(id));
    EXPECT_TRUE(comes([&] { return journal.state().waiting <= 250; }));
}

TEST_F(JournalTest, ItsEndCommitsWhatWaits)
{
    {
        Journal journal(file, never_alone);
        journal.flush();
        for (std::uint64_t id = 1; id <= 100; ++id) journal.add(numbered(id));
    }
    EXPECT_EQ(ids_in(file), up_to(100));
    EXPECT_EQ(files(), 1);
}

TEST_F(JournalTest, ALogGoesOn)
{
    for (std::uint64_t id = 1; id <= 3; ++id) {
        if (id == 1) {
            Journal journal(file, often);
            journal.add(numbered(id));
        } else {
            Journal journal(ChunkFile(file), often);
            EXPECT_EQ(journal.state().committed, fs::file_size(file));
            journal.add(numbered(id));
        }
    }
    EXPECT_EQ(ids_in(file), up_to(3));
}

TEST_F(JournalTest, ChunksAreMadeOnItsThreadInOrder)
{
    Journal journal(file, never_alone);
    const std::thread::id here = std::this_thread::get_id();
    std::atomic<int> elsewhere = 0;
    for (std::uint64_t id = 1; id <= 20; ++id) {
        const auto make = [&, id] {
            elsewhere += std::this_thread::get_id() != here;
            return numbered(id);
        };
        if (id % 3 == 0)
            journal.add(numbered(id));
        else
            journal.add(make, 100);
    }
    EXPECT_TRUE(journal.flush());
    EXPECT_EQ(elsewhere, 14);
    EXPECT_EQ(ids_in(file), up_to(20));
}

TEST_F(JournalTest, AChunkThatCannotBeMadeIsCountedAsDropped)
{
    Journal journal(file, never_alone);
    journal.add(numbered(1));
    journal.add([]() -> Chunk { throw std::bad_alloc(); }, 100);
    journal.add(chunk_of("CMIT", "not ours to write"));
    journal.add(numbered(2));
    EXPECT_TRUE(journal.flush());
    EXPECT_EQ(journal.state().dropped, 2);
    EXPECT_EQ(ids_in(file), up_to(2));
}

TEST_F(JournalTest, ChunksOfManyThreadsKeepTheOrderOfEach)
{
    constexpr std::uint64_t threads = 4, count = 200;
    {
        Journal journal(file, often);
        std::vector<std::thread> all;
        for (std::uint64_t t = 0; t < threads; ++t)
            all.emplace_back([&journal, t] {
                for (std::uint64_t i = 0; i < count; ++i) {
                    journal.add(chunk_of("TEST", "", i, t));
                    if (i % 50 == 0) journal.flush();
                    journal.state();
                }
            });
        for (std::thread& thread : all) thread.join();
    }
    std::uint64_t next[threads] = {};
    const ChunkFile read(file);
    for (const ChunkHead& head : read.chunks()) EXPECT_EQ(head.id, next[head.parent]++);
    for (const std::uint64_t each : next) EXPECT_EQ(each, count);
}

// Chunks of 100 bytes with their headers.
Chunk small(std::uint64_t id)
{
    Chunk chunk{"TEST", 0, id, 0, 52, std::string(52, 'x')};
    EXPECT_EQ(chunk.bytes(), 100u);
    return chunk;
}

TEST_F(JournalTest, OfAFullQueueTheOldestStatesAreDroppedAndThenTheNewestDifferences)
{
    Journal journal(file, {1e6, 1000});
    disk.write_error = EIO;
    EXPECT_TRUE(journal.flush());  // of nothing
    const Drop kinds[] = {Drop::difference, Drop::state, Drop::no, Drop::state, Drop::difference,
                          Drop::difference, Drop::state, Drop::no, Drop::no,    Drop::difference};
    for (std::uint64_t id = 1; id <= 10; ++id) journal.add(small(id), kinds[id - 1]);
    EXPECT_FALSE(journal.flush());
    EXPECT_EQ(journal.state().dropped, 0);
    std::vector<std::uint64_t> dropped;
    for (std::uint64_t id = 11; id <= 18; ++id) {
        journal.add(small(id));
        EXPECT_EQ(journal.state().dropped, std::min(long(id - 10), 7l));
    }
    EXPECT_EQ(journal.state().waiting, 1100u);  // more than fits, and nothing more can be dropped
    journal.add(small(19), Drop::state);
    EXPECT_EQ(journal.state().dropped, 8);
    disk.write_error = 0;
    EXPECT_TRUE(journal.flush());
    EXPECT_EQ(ids_in(file), (std::vector<std::uint64_t>{3, 8, 9, 11, 12, 13, 14, 15, 16, 17, 18}));
}

TEST_F(JournalTest, TheOrderOfDroppingIsThatOfTheirKinds)
{
    Journal journal(file, {1e6, 600});
    disk.write_error = EIO;
    const Drop kinds[] = {Drop::difference, Drop::difference, Drop::state, Drop::state, Drop::no};
    for (std::uint64_t id = 1; id <= 5; ++id) journal.add(small(id), kinds[id - 1]);
    journal.flush();
    for (std::uint64_t id = 6; id <= 9; ++id) journal.add(small(id));
    disk.write_error = 0;
    EXPECT_TRUE(journal.flush());
    EXPECT_EQ(ids_in(file), (std::vector<std::uint64_t>{1, 5, 6, 7, 8, 9}));
}

TEST_F(JournalTest, ASingleChunkLargerThanTheQueueIsWritten)
{
    Journal journal(file, {1e6, 250});
    disk.write_error = EIO;
    journal.add(small(1));
    EXPECT_FALSE(journal.flush());
    Chunk large = small(2);
    large.raw = 1000, large.stored.resize(1000);
    journal.add(large, Drop::state);
    EXPECT_EQ(journal.state().dropped, 0);
    journal.add(small(3), Drop::difference);
    EXPECT_EQ(journal.state().dropped, 1);
    journal.add(large, Drop::difference);
    EXPECT_EQ(journal.state().dropped, 2);
    disk.write_error = 0;
    EXPECT_TRUE(journal.flush());
    EXPECT_EQ(ids_in(file), (std::vector<std::uint64_t>{1, 3}));
    journal.add(large, Drop::difference);
    EXPECT_TRUE(journal.flush());
    EXPECT_EQ(ids_in(file), (std::vector<std::uint64_t>{1, 3, 2}));
}

TEST_F(JournalTest, OnAFullDiskNothingThatMustBeKeptIsLostOnceThereIsRoom)
{
    Journal journal(file, often);
    journal.add(numbered(1));
    EXPECT_TRUE(journal.flush());
    {
        const SmallDisk full(rlim_t(journal.state().committed) + 2000);
        for (std::uint64_t id = 2; id <= 300; ++id) journal.add(numbered(id));
        EXPECT_FALSE(journal.flush());
        EXPECT_EQ(journal.state().trouble.find(file + ": cannot be written: "), 0u);
        EXPECT_GT(journal.state().waiting, 0u);
        // The first may be committed before the others come.
        const std::vector<std::uint64_t> kept = ids_in(file);
        EXPECT_EQ(kept, up_to(kept.size()));
        EXPECT_LT(kept.size(), 300u);
    }
    EXPECT_TRUE(comes([&] { return journal.state().trouble.empty(); }));
    EXPECT_EQ(ids_in(file), up_to(300));
    EXPECT_EQ(journal.state().dropped, 0);
}

TEST_F(JournalTest, EachFailureIsReportedAndTriedAgain)
{
    Journal journal(file, often);
    std::uint64_t id = 0;
    for (const int error : {ENOSPC, EIO, EROFS, EDQUOT})
        for (std::atomic<int>* at : {&disk.write_error, &disk.sync_error}) {
            *at = error;
            journal.add(numbered(++id));
            EXPECT_FALSE(journal.flush());
            EXPECT_EQ(journal.state().trouble,
                      file + ": cannot be written: " + std::strerror(error));
            journal.add(numbered(++id));
            *at = 0;
            EXPECT_TRUE(journal.flush());
            EXPECT_EQ(journal.state().trouble, "");
            EXPECT_EQ(ids_in(file), up_to(id));
        }
}

TEST_F(JournalTest, AttemptsBecomeRarer)
{
    Journal journal(file, often);
    disk.sync_error = EIO;
    journal.add(numbered(1));
    EXPECT_TRUE(comes([&] { return !journal.state().trouble.empty(); }));
    disk.calls = 0;
    std::this_thread::sleep_for(1500ms);  // attempts after 0.25 s and 0.75 s
    EXPECT_GE(disk.calls, 3);             // two writes and a flush each
    EXPECT_LE(disk.calls, 3 * 3);
    disk.reset();
}

TEST_F(JournalTest, ShortAndInterruptedWritesAreCompleted)
{
    disk.most = 7, disk.interrupts = true;
    {
        Journal journal(file, often);
        for (std::uint64_t id = 1; id <= 20; ++id) journal.add(numbered(id));
    }
    EXPECT_EQ(ids_in(file), up_to(20));
}

TEST_F(JournalTest, NobodyWaitsForADiskThatStands)
{
    Journal journal(file, often);
    disk.stands = true;
    journal.add(numbered(1));
    EXPECT_TRUE(comes([&] { return disk.calls > 3; }));  // it is being written
    for (std::uint64_t id = 2; id <= 1000; ++id) {
        journal.add(numbered(id));
        EXPECT_GT(journal.state().waiting, 0u);
    }
    journal.save(copy, {}, {});
    disk.stands = false;
    EXPECT_TRUE(journal.flush());
    EXPECT_EQ(ids_in(file), up_to(1000));
}

TEST_F(JournalTest, ItsEndDoesNotWaitForeverForADiskThatTakesNothing)
{
    const auto start = std::chrono::steady_clock::now();
    {
        Journal journal(file, often);
        journal.add(numbered(1));
        EXPECT_TRUE(journal.flush());
        disk.write_error = EIO;
        journal.add(numbered(2));
    }
    EXPECT_GT(std::chrono::steady_clock::now() - start, 1500ms);
    EXPECT_LT(std::chrono::steady_clock::now() - start, 10s);
    EXPECT_EQ(ids_in(file), up_to(1));
}

TEST_F(JournalTest, ItsEndUsesTheDiskThatIsBackInTime)
{
    std::thread later;
    {
        Journal journal(file, often);
        disk.write_error = ENOSPC;
        journal.add(numbered(1));
        EXPECT_FALSE(journal.flush());
        later = std::thread([] {
            std::this_thread::sleep_for(300ms);
            disk.write_error = 0;
        });
    }
    later.join();
    EXPECT_EQ(ids_in(file), up_to(1));
}

TEST_F(JournalTest, ASecondJournalIsRefusedWithTheHoldersProcess)
{
    const std::string holder = "process " + std::to_string(getpid());
    {
        Journal journal(file, often);
        journal.add(numbered(1));
        EXPECT_TRUE(journal.flush());
        const ChunkFile read(file);
        const auto refused = [&] { return reason<OutputError>([&] { Journal(read, often); }); };
        EXPECT_NE(refused().find(holder), std::string::npos);
        EXPECT_THROW(Journal(file, often), OutputError);
    }
    Journal(ChunkFile(file), often).add(numbered(2));
    EXPECT_EQ(ids_in(file), up_to(2));
}

TEST_F(JournalTest, ASavedFileHasAllSoFarAndItsOwnLastGroup)
{
    Journal journal(file, never_alone);
    for (std::uint64_t id = 1; id <= 100; ++id) journal.add(numbered(id));
    EXPECT_EQ(saved(journal, copy, {numbered(101), numbered(102)}), "");
    EXPECT_EQ(ids_in(copy), up_to(102));
    EXPECT_EQ(ids_in(file), up_to(100));
    journal.add(numbered(101));
    EXPECT_EQ(saved(journal, copy), "");
    EXPECT_EQ(ids_in(copy), up_to(101));
    Journal(ChunkFile(copy), often).add(numbered(102));
    EXPECT_EQ(ids_in(copy), up_to(102));
}

TEST_F(JournalTest, WhatIsCalledAfterASaveMayAdd)
{
    {
        Journal journal(file, never_alone);
        journal.add(numbered(1));
        journal.save(copy, {}, [&](const std::string& why) {
            EXPECT_EQ(why, "");
            journal.add(numbered(2));
        });
    }
    EXPECT_EQ(ids_in(copy), up_to(1));
    EXPECT_EQ(ids_in(file), up_to(2));
}

TEST_F(JournalTest, SavesAreMadeInTheirOrderAndBeforeItsEnd)
{
    std::vector<int> order;
    {
        Journal journal(file, never_alone);
        for (int i = 1; i <= 5; ++i) {
            journal.add(numbered(std::uint64_t(i)));
            journal.save(
                copy, [] { return std::vector<Chunk>{}; },
                [&order, i](const std::string&) { order.push_back(i); });
        }
    }
    EXPECT_EQ(order, (std::vector<int>{1, 2, 3, 4, 5}));
    EXPECT_EQ(ids_in(copy), up_to(5));
}

// While one is written, the others of the same file become one.
TEST_F(JournalTest, SavesOfOneFileThatWaitAreOne)
{
    std::vector<int> order;
    std::atomic<int> made = 0;
    std::promise<void> begun, goes_on;
    {
        Journal journal(file, never_alone);
        const auto save = [&](int i, std::function<std::vector<Chunk>()> more) {
            journal.add(numbered(std::uint64_t(i)));
            journal.save(copy, std::move(more),
                         [&order, i](const std::string&) { order.push_back(i); });
        };
        save(1, [&] {
            ++made, begun.set_value();
            goes_on.get_future().wait();
            return std::vector<Chunk>{};
        });
        begun.get_future().wait();
        for (int i = 2; i <= 100; ++i) save(i, [&] { return ++made, std::vector<Chunk>{}; });
        goes_on.set_value();
    }
    EXPECT_EQ(made, 2);
    EXPECT_EQ(order.size(), 100u);
    EXPECT_TRUE(std::ranges::is_sorted(order));
    EXPECT_EQ(ids_in(copy), up_to(100));
}

TEST_F(JournalTest, ASaveThatFailsSaysWhyAndTheLogGoesOn)
{
    Journal journal(file, often);
    journal.add(numbered(1));
    EXPECT_NE(saved(journal, path("no/copy.knead")).find("no/copy.knead: cannot be written"),
              std::string::npos);
    EXPECT_NE(saved(journal, file).find("choose another name"), std::string::npos);
    std::promise<std::string> promise;
    journal.save(
        copy, []() -> std::vector<Chunk> { throw std::bad_alloc(); },
        [&](const std::string& why) { promise.set_value(why); });
    EXPECT_EQ(promise.get_future().get().find(copy + ": cannot be written"), 0u);
    EXPECT_EQ(journal.state().trouble, "");
    journal.add(numbered(2));
    EXPECT_TRUE(journal.flush());
    EXPECT_EQ(ids_in(file), up_to(2));
    EXPECT_FALSE(fs::exists(copy));
}

TEST_F(JournalTest, ASaveIsWholeThoughTheLogCannotBeWritten)
{
    Journal journal(file, often);
    journal.add(numbered(1));
    EXPECT_TRUE(journal.flush());
    disk.write_error = ENOSPC;
    journal.add(numbered(2));
    journal.add([] { return numbered(3); }, 100);
    EXPECT_EQ(saved(journal, copy, {numbered(4)}), "");
    EXPECT_EQ(ids_in(copy), up_to(4));
    EXPECT_EQ(ids_in(file), up_to(1));
    fs::remove(file);
    disk.write_error = 0;
    EXPECT_FALSE(journal.flush());
    EXPECT_NE(journal.state().trouble.find("it was removed"), std::string::npos);
    EXPECT_EQ(saved(journal, copy), "");
    EXPECT_EQ(ids_in(copy), up_to(3));
    journal.discard();
}

TEST_F(JournalTest, ASaveWithoutSomeKindsHasNoneOfThoseThatWaitEither)
{
    Journal journal(file, often);
    journal.add(numbered(1));
    journal.add(chunk_of("HAND", "", 2));
    EXPECT_TRUE(journal.flush());
    disk.write_error = ENOSPC;
    journal.add(numbered(3));
    journal.add(chunk_of("HAND", "", 4));
    std::promise<std::string> promise;
    journal.save(
        copy, [] { return std::vector<Chunk>{numbered(5)}; },
        [&](const std::string& why) { promise.set_value(why); },
        [](const ChunkHead& head) { return head.kind != ChunkKind("HAND"); });
    EXPECT_EQ(promise.get_future().get(), "");
    EXPECT_EQ(ids_in(copy), (std::vector<std::uint64_t>{1, 3, 5}));
}

TEST_F(JournalTest, ASaveRemovesWhatAKilledOneLeft)
{
    const pid_t gone = fork();
    if (gone == 0) _exit(0);
    waitpid(gone, nullptr, 0);
    const auto left = [&](const std::string& of, pid_t by) {
        const std::string name = path(of + ".partial-" + std::to_string(by) + "-0.knead");
        std::fclose(std::fopen(name.c_str(), "w"));
        return name;
    };
    const std::string old = left("copy", gone), another = left("other", gone),
                      in_use = left("copy", getpid());
    Journal journal(file, often);
    journal.add(numbered(1));
    EXPECT_EQ(saved(journal, copy), "");
    EXPECT_FALSE(fs::exists(old));
    EXPECT_TRUE(fs::exists(another) && fs::exists(in_use));
}

TEST_F(JournalTest, ADiscardedLogIsDeletedAtItsEnd)
{
    {
        Journal journal(file, often);
        journal.add(numbered(1));
        journal.save(copy, {}, {});
        journal.discard();
        EXPECT_TRUE(fs::exists(file));
        disk.write_error = EIO;
    }
    disk.write_error = 0;
    EXPECT_EQ(ids_in(copy), up_to(1));
    EXPECT_EQ(files(), 1);
}

// What a process that will be killed says of itself.
struct Progress {
    std::atomic<std::uint64_t> added = 0;      // last id
    std::atomic<std::uint64_t> committed = 0;  // all ids up to this one, by the journal's state
    std::atomic<long> opened = 0, saved = 0;
};

// Goes on with the log, if there is one, until it is killed.
[[noreturn]] void work_until_killed(const std::string& file, const std::string& copy,
                                    Progress& progress, std::uint64_t seed)
{
    try {
        const bool on = fs::exists(file);
        std::uint64_t id = 0;
        std::unique_ptr<Journal> journal;
        if (on) {
            const ChunkFile read(file);
            id = read.chunks().empty() ? 0 : read.chunks().back().id;
            journal = std::make_unique<Journal>(read, often);
        } else {
            journal = std::make_unique<Journal>(file, often);
        }
        ++progress.opened;
        std::mt19937_64 random(seed);
        while (true) {
            const std::uint64_t next = ++id;
            if (random() % 2 == 0)
                journal->add(numbered(next));
            else
                journal->add([next] { return numbered(next); }, 100);
            progress.added = next;
            if (random() % 8 == 0 && journal->flush()) progress.committed = next;
            if (random() % 30 == 0)
                journal->save(copy, {}, [&](const std::string& why) {
                    if (!why.empty()) _exit(8);
                    ++progress.saved;
                });
            if (journal->state().waiting == 0) progress.committed = next;
            std::this_thread::sleep_for(std::chrono::microseconds(random() % 1500));
        }
    } catch (const std::exception& e) {
        std::fprintf(stderr, "%s\n", e.what());
        _exit(9);
    }
}

TEST_F(JournalTest, ALogKilledAtAnyMomentHasAllThatWasCommitted)
{
    const long kills = std::getenv("KNEAD_LONG") ? 10000 : sanitized ? 20 : 200;
    auto* const progress = new (mmap(nullptr, sizeof(Progress), PROT_READ | PROT_WRITE,
                                     MAP_SHARED | MAP_ANONYMOUS, -1, 0)) Progress;
    std::mt19937_64 random(59);
    std::uint64_t lost = 0, last = 0;
    for (long i = 0; i < kills; ++i) {
        if (i % 25 == 0) {  // a new log: reading a long one takes long
            fs::remove(file), fs::remove(copy);
            last = progress->added = progress->committed = 0;
        }
        const pid_t child = fork();
        ASSERT_GE(child, 0);
        if (child == 0) work_until_killed(file, copy, *progress, random());
        // Each second one while it opens the log.
        std::this_thread::sleep_for(
            std::chrono::microseconds(random() % (i % 2 == 0 ? 3000 : 40000)));
        kill(child, SIGKILL);
        int status = 0;
        waitpid(child, &status, 0);
        ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << i;
        if (!fs::exists(file)) {
            ASSERT_EQ(progress->committed, 0u) << i;
            continue;
        }
        const std::vector<std::uint64_t> ids = ids_in(file);
        ASSERT_EQ(ids, up_to(ids.size())) << i;
        ASSERT_GE(ids.size(), std::max<std::uint64_t>(last, progress->committed)) << i;
        lost += std::max<std::uint64_t>(progress->added, ids.size()) - ids.size();
        last = progress->added = progress->committed = ids.size();
        const ChunkFile read(file);
        for (std::size_t k = 0; k < ids.size(); k += 1 + random() % 100)
            ASSERT_EQ(read.payload(read.chunks()[k]), payload_of(k + 1));
        if (fs::exists(copy)) {
            ASSERT_EQ(ids_in(copy), up_to(ids_in(copy).size())) << i;
        }
    }
    std::printf("%ld kills, %ld logs opened, %ld saves, %.1f chunks lost a kill\n", kills,
                progress->opened.load(), progress->saved.load(), double(lost) / double(kills));
    EXPECT_GT(progress->opened, kills / 4);
    munmap(progress, sizeof(Progress));
}

}  // namespace
}  // namespace knead
