// The container of sessions: what was committed is read again, and nothing else ever is.
#include "host/files/chunk_file.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>

#include "host/base/errors.h"
#include "host/base/machine.h"
#include "tests/files/chunk_bytes.h"
#include "tests/folder.h"
#include "tests/memory_of.h"
#include "tests/reason.h"
#include "tests/sanitized.h"
#include "tests/small_disk.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

std::string noise(std::size_t bytes, std::uint64_t seed)
{
    std::mt19937_64 engine(seed);
    std::string all;
    for (std::size_t i = 0; i < bytes; ++i) all += char(engine() & 0xff);
    return all;
}

// Groups of payloads; the id of a chunk is its number from 1.
using Groups = std::vector<std::vector<std::string>>;
const Groups small_groups = {
    {"first", ""}, {std::string(300, 'z')}, {noise(40, 1), "and the last", noise(3, 2)}};

void write_groups(ChunkWriter& writer, const Groups& groups, std::uint64_t id = 1)
{
    for (const auto& group : groups) {
        for (const std::string& payload : group)
            writer.add(chunk_of("TEST", payload, id, id / 2)), ++id;
        writer.commit();
    }
}
std::string session_of(const std::string& file, const Groups& groups)
{
    ChunkWriter writer(file);
    write_groups(writer, groups);
    return bytes_in(file);
}
std::vector<std::string> flat(const Groups& groups)
{
    std::vector<std::string> all;
    for (const auto& group : groups) all.insert(all.end(), group.begin(), group.end());
    return all;
}
std::vector<std::string> payloads(const ChunkFile& file)
{
    std::vector<std::string> all;
    for (const ChunkHead& head : file.chunks()) all.push_back(file.payload(head));
    return all;
}
std::vector<std::string> payloads(const std::string& file) { return payloads(ChunkFile(file)); }

class ChunkFileTest : public InFolder {
  protected:
    const std::string file = path("a.knead");

    // What is left of changed bytes: it must be a prefix of `all`, or be refused.
    void expect_prefix(const std::string& bytes, const std::vector<std::string>& all)
    {
        put_bytes(file, bytes);
        try {
            const ChunkFile read(file);
            ASSERT_LE(read.chunks().size(), all.size());
            for (std::size_t i = 0; i < read.chunks().size(); ++i) {
                ASSERT_EQ(read.chunks()[i].id, i + 1);
                try {
                    ASSERT_EQ(read.payload(read.chunks()[i]), all[i]);
                } catch (const InputError&) {
                    EXPECT_THROW(read.verify(), InputError);
                }
            }
        } catch (const InputError& e) {
            EXPECT_EQ(std::string(e.what()).find(file), 0u) << e.what();
        }
    }
    // A session of one chunk with these sizes in its header, and correct hashes.
    std::string with_sizes(const std::string& stored, std::uint64_t raw, std::uint64_t as_stored,
                           std::uint64_t flags)
    {
        fs::remove(file);
        std::string bytes = session_of(file, {{stored}});
        const std::size_t at = chunk_places(bytes)[1];
        const std::size_t payload = at + chunk_header_size;
        bytes.replace(payload, number_in(bytes, at + 11, 5), stored);
        put_number(bytes, at + 11, stored.size(), 5);
        put_number(bytes, at + 4, flags, 2);
        put_number(bytes, at + 6, raw, 5);
        bytes = rehashed(bytes);
        if (as_stored != stored.size()) {
            put_number(bytes, at + 11, as_stored, 5);
            bytes = rehashed(bytes);
        }
        put_bytes(file, bytes);
        return bytes;
    }
};

TEST_F(ChunkFileTest, WhatIsWrittenIsReadAgain)
{
    const std::string large(3 << 20, 'x'), random = noise(3 << 20, 7);
    {
        ChunkWriter writer(file);
        writer.add(chunk_of("HEAD", "as it is", 1, 0, chunk_ancillary));
        writer.add(chunk_of("DATA", large, ~0ull, 1));
        writer.commit();
        writer.add(chunk_of("DATA", random, 3, ~0ull - 1));
        EXPECT_EQ(writer.last_at() + random.size(), fs::file_size(file));
        writer.commit();
        EXPECT_EQ(writer.committed(), fs::file_size(file));
    }
    const ChunkFile read(file);
    ASSERT_EQ(read.chunks().size(), 3u);
    const ChunkHead &head = read.chunks()[0], &packed = read.chunks()[1], &open = read.chunks()[2];
    EXPECT_EQ(head.kind.text(), "HEAD");
    EXPECT_TRUE(head.ancillary());
    EXPECT_EQ(packed.id, ~0ull);
    EXPECT_EQ(packed.flags, chunk_compressed);
    EXPECT_LT(packed.stored, 1000u);
    EXPECT_EQ(packed.raw, large.size());
    EXPECT_EQ(open.parent, ~0ull - 1);
    EXPECT_EQ(open.flags, 0u);
    EXPECT_EQ(payloads(read), (std::vector<std::string>{"as it is", large, random}));
    EXPECT_EQ(read.commits(), 3);
    EXPECT_EQ(read.end(), read.size());
    EXPECT_EQ(read.broken_by(), "");
    EXPECT_EQ(read.version(), 1);
    read.verify();
}

TEST_F(ChunkFileTest, ANewFileIsValidAndItsOwnersAlone)
{
    const ChunkWriter writer(file);
    EXPECT_EQ(ChunkFile(file).chunks().size(), 0u);
    struct stat info {};
    ASSERT_EQ(stat(file.c_str(), &info), 0);
    EXPECT_EQ(info.st_mode & 0777, 0600u);
}

TEST_F(ChunkFileTest, SessionsDifferInTheirSalts)
{
    const ChunkWriter a(file), b(path("b.knead"));
    EXPECT_NE(ChunkFile(file).salt(), ChunkFile(path("b.knead")).salt());
}

TEST_F(ChunkFileTest, AGroupCountsFromItsCommitOn)
{
    ChunkWriter writer(file);
    write_groups(writer, {{"first"}});
    writer.add(chunk_of("TEST", "second", 2));
    const ChunkFile before(file);
    EXPECT_EQ(before.chunks().size(), 1u);
    EXPECT_EQ(before.end(), writer.committed());
    EXPECT_NE(before.broken_by().find("1 chunks without a commit"), std::string::npos);
    writer.commit();
    EXPECT_EQ(payloads(file), (std::vector<std::string>{"first", "second"}));
}

TEST_F(ChunkFileTest, ACommitOfNothingWritesNothing)
{
    ChunkWriter writer(file);
    const auto size = fs::file_size(file);
    writer.commit();
    EXPECT_EQ(fs::file_size(file), size);
}

TEST_F(ChunkFileTest, NoFlippedBitGivesOtherPayloads)
{
    const std::string bytes = session_of(file, small_groups);
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
        std::string flipped = bytes;
        flipped[bit / 8] = char(flipped[bit / 8] ^ 1 << bit % 8);
        expect_prefix(flipped, flat(small_groups));
    }
}

TEST_F(ChunkFileTest, AFileCutAtAnyByteHasTheGroupsBeforeIt)
{
    const std::string bytes = session_of(file, small_groups);
    const std::vector<std::size_t> places = chunk_places(bytes);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        put_bytes(file, bytes.substr(0, size));
        std::size_t chunks = 0, commits = 0, pending = 0;
        for (const std::size_t at : places) {
            const std::size_t end = at + chunk_header_size + number_in(bytes, at + 11, 5);
            if (end > size) break;
            if (is_commit(bytes, at))
                ++commits, chunks += pending, pending = 0;
            else
                ++pending;
        }
        if (commits == 0) {
            EXPECT_THROW(ChunkFile{file}, InputError) << size;
            continue;
        }
        const ChunkFile read(file);
        EXPECT_EQ(read.chunks().size(), chunks) << size;
        EXPECT_EQ(read.broken_by() == "", read.end() == size) << size;
    }
}

TEST_F(ChunkFileTest, RandomChangesGiveNoOtherPayloads)
{
    const std::string bytes = session_of(file, small_groups);
    std::mt19937_64 random(5);
    for (int i = 0; i < 2000; ++i) {
        std::string changed = bytes;
        const std::size_t from = random() % bytes.size(), to = random() % bytes.size();
        const std::size_t size = 1 + random() % 60;
        if (i % 2 == 0)
            changed.replace(to, size, bytes.substr(from, size));
        else
            changed.insert(to, bytes.substr(from, size));
        expect_prefix(changed, flat(small_groups));
    }
}

TEST_F(ChunkFileTest, AChunkOfAnotherSessionIsRefused)
{
    const std::string other = session_of(path("b.knead"), small_groups);
    const std::string bytes = session_of(file, small_groups);
    const std::vector<std::size_t> at = chunk_places(bytes);
    for (std::size_t i = 0; i + 1 < at.size(); ++i) {
        std::string spliced = bytes;
        spliced.replace(at[i], at[i + 1] - at[i], other, at[i], at[i + 1] - at[i]);
        expect_prefix(spliced, flat(small_groups));
        put_bytes(file, spliced);
        if (i == 0)
            EXPECT_THROW(ChunkFile{file}, InputError);
        else
            EXPECT_LE(ChunkFile(file).end(), at[i]);
    }
}

TEST_F(ChunkFileTest, ChunksInAnotherOrderTwiceOrMissingAreNoGroup)
{
    const std::string bytes = session_of(file, small_groups);
    std::vector<std::size_t> at = chunk_places(bytes);
    at.push_back(bytes.size());
    const auto chunk = [&](std::size_t i) { return bytes.substr(at[i], at[i + 1] - at[i]); };
    for (std::size_t i = 0; i + 1 < at.size(); ++i)
        for (std::size_t j = 0; j + 1 < at.size(); ++j) {
            const std::string inserted = bytes.substr(0, at[i]) + chunk(j) + bytes.substr(at[i]);
            expect_prefix(inserted, flat(small_groups));
            put_bytes(file, inserted);
            // A commit may be there once.
            if (i > 0) {
                EXPECT_LE(ChunkFile(file).end(), at[i == j ? i + 1 : i]) << i << " " << j;
            }
            std::string swapped = bytes.substr(0, session_head);
            for (std::size_t k = 0; k + 1 < at.size(); ++k)
                swapped += chunk(k == i ? j : k == j ? i : k);
            expect_prefix(swapped, flat(small_groups));
            std::string missing = bytes;
            expect_prefix(missing.erase(at[i], at[i + 1] - at[i]), flat(small_groups));
        }
}

TEST_F(ChunkFileTest, ADamagedPayloadIsFoundByReadingAndByVerifying)
{
    std::string bytes = session_of(file, {{"first", noise(5000, 3)}, {"last"}});
    bytes[chunk_places(bytes)[2] + chunk_header_size + 2500] ^= 1;
    put_bytes(file, bytes);
    const ChunkFile read(file);
    EXPECT_EQ(read.broken_by(), "");
    EXPECT_EQ(read.payload(read.chunks()[0]), "first");
    EXPECT_NE(reason<InputError>([&] { read.payload(read.chunks()[1]); }).find("checksum"),
              std::string::npos);
    EXPECT_THROW(read.stored(read.chunks()[1]), InputError);
    EXPECT_NE(reason<InputError>([&] { read.verify(); }).find("chunk TEST: damaged"),
              std::string::npos);
    int asked = 0;
    read.verify([&] { return ++asked == 2; });
}

TEST_F(ChunkFileTest, SizesThatCannotBeAreRefused)
{
    const std::uint64_t largest = (std::uint64_t(1) << 40) - 1;
    const std::string some = noise(100, 4);
    for (const std::uint64_t raw : {largest, longest_chunk + 1, std::uint64_t(101)}) {
        with_sizes(some, raw, some.size(), 0);
        EXPECT_EQ(ChunkFile(file).chunks().size(), 0u) << raw;
        EXPECT_NE(ChunkFile(file).broken_by().find("impossible size"), std::string::npos);
    }
    for (const std::uint64_t raw : {largest, longest_chunk, std::uint64_t(101) << 15}) {
        with_sizes(some, raw, some.size(), chunk_compressed);
        EXPECT_EQ(ChunkFile(file).chunks().size(), 0u) << raw;
    }
    for (const std::uint64_t stored : {largest, longest_chunk, std::uint64_t(1000)}) {
        with_sizes(some, stored, stored, 0);
        EXPECT_LT(memory_of([&] { EXPECT_EQ(ChunkFile(file).chunks().size(), 0u); }), 8u << 20);
    }
}

TEST_F(ChunkFileTest, APayloadLargerThanMemoryIsRefusedBeforeItIsUncompressed)
{
    with_sizes(noise(2 << 20, 4), longest_chunk, 2 << 20, chunk_compressed);
    const ChunkFile read(file);
    ASSERT_EQ(read.chunks().size(), 1u);
    EXPECT_LT(memory_of([&] {
                  if (available_memory() < longest_chunk)
                      EXPECT_THROW(read.payload(read.chunks()[0]), MemoryError);
                  else
                      EXPECT_THROW(read.payload(read.chunks()[0]), InputError);
                  EXPECT_THROW(read.verify(), InputError);
              }),
              32u << 20);
}

TEST_F(ChunkFileTest, AFrameOfOtherSizeThanStatedIsRefusedWithoutItsMemory)
{
    const std::string zeros(64 << 20, '\0');
    std::string bomb(ZSTD_compressBound(zeros.size()), '\0');
    bomb.resize(ZSTD_compress(bomb.data(), bomb.size(), zeros.data(), zeros.size(), 1));
    for (const std::size_t raw : {std::size_t(0), std::size_t(100), zeros.size() - 1}) {
        with_sizes(bomb, raw, bomb.size(), chunk_compressed);
        const ChunkFile read(file);
        ASSERT_EQ(read.chunks().size(), 1u);
        const std::size_t taken =
            memory_of([&] { EXPECT_THROW(read.payload(read.chunks()[0]), InputError) << raw; });
        if (raw < 1000) {
            EXPECT_LT(taken, 32u << 20);
        }
        EXPECT_LT(memory_of([&] { EXPECT_THROW(read.verify(), InputError); }), 32u << 20);
    }
    with_sizes(bomb, zeros.size() + 1, bomb.size(), chunk_compressed);
    const ChunkFile longer(file);
    EXPECT_THROW(longer.payload(longer.chunks()[0]), InputError);
    // A frame that is cut off, one with bytes behind it, and none.
    for (const std::string& stored : {bomb.substr(0, bomb.size() - 1), bomb + '\0', noise(99, 1)}) {
        with_sizes(stored, std::min(zeros.size(), stored.size() << 15), stored.size(),
                   chunk_compressed);
        const ChunkFile read(file);
        ASSERT_EQ(read.chunks().size(), 1u);
        EXPECT_THROW(read.payload(read.chunks()[0]), InputError);
    }
}

TEST_F(ChunkFileTest, AFrameWithALargeWindowIsRefusedWithoutItsMemory)
{
    // Magic number, a header without size whose window has 2^30 bytes, and one empty last block.
    const std::string frame("\x28\xb5\x2f\xfd\x00\xa0\x01\x00\x00", 9);
    with_sizes(frame, 0, frame.size(), chunk_compressed);
    const ChunkFile read(file);
    ASSERT_EQ(read.chunks().size(), 1u);
    EXPECT_LT(memory_of([&] { EXPECT_THROW(read.payload(read.chunks()[0]), InputError); }),
              32u << 20);
}

TEST_F(ChunkFileTest, AFileOfNothingButHeadersTakesMemoryInProportion)
{
    ChunkWriter writer(file);
    const Chunk empty = chunk_of("TEST", "");
    const int count = sanitized ? 2000 : 100000;
    for (int i = 0; i < count; ++i) writer.add(empty);
    writer.commit();
    EXPECT_LT(memory_of([&] { EXPECT_EQ(ChunkFile(file).chunks().size(), std::size_t(count)); }),
              8 * fs::file_size(file) + (8 << 20));
}

TEST_F(ChunkFileTest, FilesThatAreNoSessionAreRefusedWithTheirPath)
{
    for (const std::string& bytes : {std::string(), std::string("knead.session"),
                                     std::string("{\"schema\": 1}"), noise(1000, 1)}) {
        put_bytes(file, bytes);
        EXPECT_EQ(reason<InputError>([&] { ChunkFile{file}; }).find(file), 0u);
    }
    EXPECT_NE(reason<InputError>([&] { ChunkFile{path("none")}; }).find("cannot be read"),
              std::string::npos);
    EXPECT_NE(reason<InputError>([&] { ChunkFile{folder.string()}; }).find("no"),
              std::string::npos);
}

TEST_F(ChunkFileTest, AFileOfANewerVersionIsRefused)
{
    std::string bytes = session_of(file, small_groups);
    put_number(bytes, 16, 2, 4);
    put_bytes(file, rehashed(bytes));
    EXPECT_NE(reason<InputError>([&] { ChunkFile{file}; }).find("of a newer knead"),
              std::string::npos);
}

TEST_F(ChunkFileTest, AChunkWithUnknownFlagsIsListedAndCopiedButNotRead)
{
    with_sizes("abc", 3, 3, 0x8001);
    const ChunkFile read(file);
    ASSERT_EQ(read.chunks().size(), 1u);
    EXPECT_TRUE(read.chunks()[0].ancillary());
    EXPECT_NE(reason<InputError>([&] { read.payload(read.chunks()[0]); }).find("newer"),
              std::string::npos);
    EXPECT_EQ(read.stored(read.chunks()[0]).flags, 0x8001u);
    read.verify();
}

TEST_F(ChunkFileTest, AStoredChunkCanBeAddedToAnotherFile)
{
    session_of(file, small_groups);
    const ChunkFile from(file);
    const std::string other = path("b.knead");
    {
        ChunkWriter writer(other);
        for (const ChunkHead& head : from.chunks()) writer.add(from.stored(head));
        writer.commit();
    }
    EXPECT_EQ(payloads(other), flat(small_groups));
}

TEST_F(ChunkFileTest, TheWriterGoesOnBehindTheLastCommit)
{
    const std::string bytes = session_of(file, small_groups);
    const std::size_t second = chunk_places(bytes)[4];
    for (std::size_t size = second; size < bytes.size(); size += 7) {
        put_bytes(file, bytes.substr(0, size) + noise(size % 3, size));
        std::vector<std::string> expected;
        {
            const ChunkFile read(file);
            expected = payloads(read);
            ChunkWriter writer(file, read);
            EXPECT_EQ(fs::file_size(file), read.end());
            write_groups(writer, {{"more"}, {"and more"}}, expected.size() + 1);
        }
        expected.insert(expected.end(), {"more", "and more"});
        EXPECT_EQ(payloads(file), expected);
        EXPECT_EQ(ChunkFile(file).broken_by(), "");
    }
}

TEST_F(ChunkFileTest, AFileThatChangedSinceItWasReadIsNotWritten)
{
    session_of(file, small_groups);
    const ChunkFile read(file);
    {
        ChunkWriter writer(file, read);
        write_groups(writer, {{"more"}}, 7);
    }
    EXPECT_NE(reason<OutputError>([&] { ChunkWriter(file, read); }).find("has changed"),
              std::string::npos);
    EXPECT_EQ(payloads(file).size(), 7u);
    fs::rename(file, path("b.knead"));
    session_of(file, small_groups);
    EXPECT_THROW(ChunkWriter(file, ChunkFile(path("b.knead"))), OutputError);
}

TEST_F(ChunkFileTest, ANewFileReplacesNone)
{
    put_bytes(file, "something else");
    EXPECT_NE(reason<OutputError>([&] { ChunkWriter{file}; }).find("is there already"),
              std::string::npos);
    EXPECT_EQ(bytes_in(file), "something else");
    EXPECT_EQ(files(), 1);
    EXPECT_EQ(reason<OutputError>([&] { ChunkWriter{path("no/folder")}; }).find(path("no/")), 0u);
}

TEST_F(ChunkFileTest, ASecondWriterIsRefusedWithTheHoldersProcess)
{
    session_of(file, small_groups);
    const ChunkFile read(file);
    const std::string holder = "process " + std::to_string(getpid());
    {
        const ChunkWriter writer(file, read);
        const auto refused = [&] { return reason<OutputError>([&] { ChunkWriter(file, read); }); };
        EXPECT_NE(refused().find(holder), std::string::npos);
        const pid_t child = fork();
        if (child == 0) _exit(refused().find(holder) != std::string::npos ? 0 : 1);
        int status = 1;
        waitpid(child, &status, 0);
        EXPECT_EQ(status, 0);
        // By another name, too.
        fs::create_symlink(file, path("link"));
        EXPECT_NE(reason<OutputError>([&] { ChunkWriter(path("link"), read); }).find("another"),
                  std::string::npos);
        fs::remove(path("link"));
        EXPECT_EQ(payloads(file), flat(small_groups));  // readers are not kept out
    }
    const ChunkWriter writer(file, read);
    EXPECT_EQ(files(), 2);
}

TEST_F(ChunkFileTest, OnAFullDiskTheGroupIsLostAndTheFileGoesOnOnceThereIsRoom)
{
    ChunkWriter writer(file);
    write_groups(writer, {{"first"}});
    for (const int more : {0, 20, 60, 100, 5000}) {
        const SmallDisk full(rlim_t(writer.committed()) + more);
        const std::string why = reason<OutputError>([&] {
            writer.add(chunk_of("TEST", "lost", 9));
            writer.add(chunk_of("TEST", noise(6000, 1), 9));
            writer.commit();
        });
        EXPECT_EQ(why.find(file + ": cannot be written: "), 0u);
        EXPECT_EQ(reason<OutputError>([&] { writer.add(chunk_of("TEST", "lost", 9)); }), why);
        EXPECT_EQ(reason<OutputError>([&] { writer.commit(); }), why);
        EXPECT_EQ(payloads(file).size(), 1u);
        writer.retry();
        EXPECT_EQ(fs::file_size(file), writer.committed());
    }
    write_groups(writer, {{"second"}}, 2);
    EXPECT_EQ(payloads(file), (std::vector<std::string>{"first", "second"}));
    const SmallDisk full(10);
    EXPECT_THROW(ChunkWriter{path("b.knead")}, OutputError);
    EXPECT_EQ(files(), 2);  // with the lock
}

TEST_F(ChunkFileTest, AFileThatIsRemovedOrCutMeanwhileIsReported)
{
    ChunkWriter writer(file);
    write_groups(writer, {{"first"}});
    fs::resize_file(file, 40);
    writer.add(chunk_of("TEST", "", 2));
    fs::resize_file(file, 40);
    EXPECT_NE(reason<OutputError>([&] { writer.commit(); }).find("was cut"), std::string::npos);
    EXPECT_THROW(writer.retry(), OutputError);
    ChunkWriter other(path("b.knead"));
    fs::remove(path("b.knead"));
    other.add(chunk_of("TEST", "", 1));
    EXPECT_NE(reason<OutputError>([&] { other.commit(); }).find("removed"), std::string::npos);
}

TEST_F(ChunkFileTest, AWriterRemovesItsOwnFileAlone)
{
    ChunkWriter writer(file);
    fs::rename(file, path("moved"));
    put_bytes(file, "another");
    writer.remove();
    EXPECT_EQ(bytes_in(file), "another");
    fs::rename(path("moved"), file);
    writer.remove();
    EXPECT_FALSE(fs::exists(file));
}

TEST_F(ChunkFileTest, ChunksThatNoReaderWouldTakeAreNotWritten)
{
    ChunkWriter writer(file);
    EXPECT_THROW(writer.add(chunk_of("CMIT", "")), std::invalid_argument);
    Chunk odd = chunk_of("TEST", "abc");
    odd.raw = 4;
    EXPECT_THROW(writer.add(odd), std::length_error);
    odd.raw = 3, odd.flags = 1 << 16;
    EXPECT_THROW(writer.add(odd), std::invalid_argument);
    write_groups(writer, {{"fine"}});
    EXPECT_EQ(payloads(file).size(), 1u);
}

TEST_F(ChunkFileTest, ACopyOfAPrefixIsAFileThatCanBeContinued)
{
    const std::string copy = path("copy.knead");
    ChunkWriter writer(file);
    std::vector<std::uint64_t> ends = {writer.committed()};
    for (const auto& group : small_groups)
        write_groups(writer, {group}, ends.size()), ends.push_back(writer.committed());
    const std::vector<Chunk> more = {chunk_of("SAVE", "of the copy alone"), chunk_of("SAVE", "")};
    for (std::size_t groups = 0; groups < ends.size(); ++groups) {
        copy_chunks(file, ends[groups], {}, copy);
        EXPECT_EQ(bytes_in(copy), bytes_in(file).substr(0, ends[groups]));
        copy_chunks(file, ends[groups], more, copy);
        std::vector<std::string> expected =
            flat(Groups(small_groups.begin(), small_groups.begin() + std::ptrdiff_t(groups)));
        expected.insert(expected.end(), {"of the copy alone", ""});
        EXPECT_EQ(payloads(copy), expected);
        {
            ChunkWriter longer(copy, ChunkFile(copy));
            write_groups(longer, {{"more"}});
        }
        expected.push_back("more");
        EXPECT_EQ(payloads(copy), expected);
    }
    EXPECT_EQ(ChunkFile(file).end(), ends.back());
}

TEST_F(ChunkFileTest, ACopyOntoAnotherFileSystemIsTheSame)
{
    if (!fs::is_directory("/dev/shm")) GTEST_SKIP() << "no other file system here";
    const std::string other = fmt::format("/dev/shm/knead-test-{}.knead", getpid());
    Groups groups = small_groups;
    groups.push_back({noise(5 << 20, 3)});
    const std::string bytes = session_of(file, groups);
    copy_chunks(file, bytes.size(), {}, other);
    EXPECT_EQ(bytes_in(other), bytes);
    fs::remove(other);
}

TEST_F(ChunkFileTest, ACopyThatFailsLeavesWhatWasThere)
{
    const std::string copy = path("copy.knead");
    const std::string bytes = session_of(file, small_groups);
    put_bytes(copy, "as before");
    EXPECT_NE(reason<InputError>([&] {
                  copy_chunks(file, bytes.size() - 1, {}, copy);
              }).find("expected the end of a group"),
              std::string::npos);
    EXPECT_THROW(copy_chunks(file, bytes.size() + 1, {}, copy), InputError);
    EXPECT_THROW(copy_chunks(path("none"), 100, {}, copy), InputError);
    EXPECT_NE(reason<OutputError>([&] {
                  copy_chunks(file, bytes.size(), {}, file);
              }).find("choose another name"),
              std::string::npos);
    {
        const SmallDisk full(rlim_t(bytes.size() - 10));
        EXPECT_EQ(reason<OutputError>([&] {
                      copy_chunks(file, bytes.size(), {}, copy);
                  }).find(copy + ": cannot be written"),
                  0u);
    }
    EXPECT_EQ(bytes_in(copy), "as before");
    EXPECT_EQ(bytes_in(file), bytes);
    EXPECT_EQ(files(), 2);
}

}  // namespace
}  // namespace knead
