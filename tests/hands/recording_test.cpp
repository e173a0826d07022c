// Recordings survive their files exactly, and no file, however broken, gets past the reader.
#include "host/hands/recording.h"

#include <gtest/gtest.h>
#include <xxhash.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "tests/folder.h"

namespace knead {
namespace {

namespace fs = std::filesystem;

float random_float(std::mt19937_64& source, float low, float high)
{
    return low + (high - low) * float(double(source() >> 11) * 0x1p-53);
}

Recording some_recording(int frames, unsigned seed = 1)
{
    std::mt19937_64 source(seed);
    Recording r{"test \"of\\ quotes\"", 72, 0.038, {}};
    for (int i = 0; i < frames; ++i) {
        HandFrame frame;
        frame.time = 0.038 + i / 72.0 + 1e-3 * random_float(source, 0, 1);
        for (Hand& hand : frame.hand) {
            hand.tracked = source() % 4 != 0;
            for (int j = 0; j < joint_count; ++j) {
                Quat<float> q{random_float(source, -1, 1), random_float(source, -1, 1),
                              random_float(source, -1, 1), random_float(source, -1, 1)};
                hand.joints[j] = {unit(q),
                                  {random_float(source, -1, 1), random_float(source, -1, 1),
                                   random_float(source, -1, 1)}};
                hand.radius[j] = random_float(source, 0, 0.03f);
                hand.valid[j] = source() % 3 != 0;
            }
        }
        r.frames.push_back(frame);
    }
    r.frames[0].hand[left] = {};  // never seen: every number zero
    return r;
}

void expect_same(const Recording& a, const Recording& b)
{
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.rate, b.rate);
    EXPECT_EQ(a.latency, b.latency);
    ASSERT_EQ(a.frames.size(), b.frames.size());
    EXPECT_EQ(to_binary(a), to_binary(b));
}

// The binary form with the byte at `offset` replaced and the checksum made right again, so that
// the checks behind the checksum are reached.
std::string resealed(std::string bytes, std::size_t offset, const void* value, std::size_t size)
{
    std::memcpy(bytes.data() + offset, value, size);
    const std::uint64_t sum = XXH64(bytes.data(), bytes.size() - 8, 0);
    for (int i = 0; i < 8; ++i) bytes[bytes.size() - 8 + i] = char(sum >> (8 * i) & 0xff);
    return bytes;
}

std::string refusal(const std::string& bytes)
{
    try {
        from_bytes(bytes, "file");
    } catch (const InputError& error) {
        return error.what();
    }
    return "accepted";
}

void expect_refusal(const std::string& bytes, const std::string& where, const std::string& what)
{
    const std::string text = refusal(bytes);
    EXPECT_NE(text.find("file: " + where), std::string::npos) << text;
    EXPECT_NE(text.find(what), std::string::npos) << text;
}

constexpr std::size_t name_at = 44;  // after magic, version, joints, rate, latency, count, length
std::size_t frames_at(const Recording& r) { return name_at + r.name.size(); }

TEST(Recording, BothFormsKeepEveryBit)
{
    const Recording r = some_recording(40);
    expect_same(r, from_bytes(to_binary(r), "file"));
    expect_same(r, from_bytes(to_lines(r), "file"));
}

TEST(Recording, AFrameTakes1680Bytes)
{
    EXPECT_EQ(to_binary(some_recording(3)).size() - to_binary(some_recording(2)).size(), 1680u);
}

TEST(Recording, TheEndingChoosesTheFormAndTheContentTellsIt)
{
    const Folder folder;
    const Recording r = some_recording(5);
    for (const char* name : {"a.hands", "a.jsonl"}) {
        write_recording(folder / name, r);
        expect_same(r, read_recording(folder / name));
    }
    fs::rename(folder / "a.jsonl", folder / "b.hands");  // the ending lies
    expect_same(r, read_recording(folder / "b.hands"));
    EXPECT_THROW(write_recording(folder / "a.txt", r), InputError);
}

TEST(Recording, AFailedWriteLeavesTheOldFileAndNoOther)
{
    const Folder folder;
    const Recording good = some_recording(5);
    write_recording(folder / "a.hands", good);
    Recording bad = good;
    bad.frames[3].hand[right].joints[wrist].p.x = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THROW(write_recording(folder / "a.hands", bad), InputError);
    expect_same(good, read_recording(folder / "a.hands"));
    fs::create_directories(folder / "taken.hands/inside");
    EXPECT_THROW(write_recording(folder / "taken.hands", good), std::runtime_error);
    EXPECT_THROW(write_recording(folder / "none/a.hands", good), std::runtime_error);
    EXPECT_EQ(folder.files(), 2);
}

TEST(Recording, WhatIsNoFileIsRefusedByName)
{
    const Folder folder;
    EXPECT_THROW(read_recording(folder / "missing.hands"), InputError);
    EXPECT_THROW(read_recording(folder.path().string()), InputError);
    std::ofstream(folder / "empty.hands").close();
    EXPECT_THROW(read_recording(folder / "empty.hands"), InputError);
}

TEST(Recording, EachBrokenValueIsNamedWithItsByte)
{
    const Recording r = some_recording(3);
    const std::string good = to_binary(r);
    const std::size_t first = frames_at(r);
    const auto with = [&](std::size_t offset, auto value) {
        return resealed(good, offset, &value, sizeof value);
    };
    EXPECT_EQ(refusal(with(first, r.frames[0].time)), "accepted");
    expect_refusal(with(0, 'X'), "at byte 0", "KNHANDS1");
    expect_refusal(with(8, 2u), "at byte 8", "version 2");
    expect_refusal(with(12, 25u), "at byte 12", "26 joints");
    expect_refusal(with(16, -1.0), "at byte 16", "rate");
    expect_refusal(with(24, 1e9), "at byte 16", "latency");
    expect_refusal(with(32, std::uint64_t(-1)), "at byte 32", "18446744073709551615");
    expect_refusal(with(32, std::uint64_t(4)), "at byte 32", "a count of 4");
    expect_refusal(with(40, std::uint32_t(-1)), "at byte 44", "4294967295");
    expect_refusal(with(44, '\n'), "at byte 16", "printable");
    const auto at = [](std::size_t byte) { return "at byte " + std::to_string(byte) + ":"; };
    expect_refusal(with(first, std::nan("")), at(first), "time");
    expect_refusal(with(first + 1680, r.frames[0].time), at(first + 1680), "a time after");
    expect_refusal(with(first + 8, 1u << 27), at(first + 8), "flag");
    const std::size_t joint = first + 1680 + 8 + 4 + 2 * 32;
    expect_refusal(with(joint + 4, std::numeric_limits<float>::infinity()), at(joint), "100 m");
    expect_refusal(with(joint + 16, 1.5f), at(joint), "unit quaternion");
    expect_refusal(with(joint + 28, -0.01f), at(joint), "radius");
    expect_refusal(with(joint + 28, std::nanf("")), at(joint), "radius");
    std::string changed = good;
    changed[first + 100] ^= 1;
    expect_refusal(changed, at(good.size() - 8), "checksum");
    expect_refusal(good + "x", "at byte 32", "count");
}

TEST(Recording, EachBrokenLineIsNamedWithItsNumber)
{
    const std::string good = to_lines(some_recording(3));
    const auto with = [&](const std::string& from, const std::string& to) {
        std::string text = good;
        return text.replace(text.find(from), from.size(), to);
    };
    expect_refusal(with("knead.hands/1", "knead.hands/2"), "in line 1", "knead.hands/1");
    expect_refusal(with("\"frames\":3", "\"frames\":-3"), "in line 1", "frame");
    expect_refusal(with("\"frames\":3", "\"frames\":4"), "in line 4", "4 frames");
    expect_refusal(with("\"frames\":3", "\"frames\":2"), "in line 4", "another line");
    expect_refusal(with("\"rate\":72", "\"rate\":\"72\""), "in line 1", "number");
    expect_refusal(with("\"rate\":72", "\"rate\":72,\"what\":1"), "in line 1", "5 keys");
    expect_refusal(with("\"tracked\":", "\"tracked\":3,\"x\":"), "in line 2", "tracked");
    expect_refusal(with("\"joints\":[[", "\"joints\":[[9,"), "in line 2", "9 numbers");
    expect_refusal(with("\"joints\":[[", "\"joints\":[[1e400],["), "in line 2", "no JSON");
    expect_refusal(with("\"joints\":[[0,", "\"joints\":[[1e39,"), "in line 2", "100 m");
    expect_refusal(with("{\"time\":", "{\"time\":null,\"t\":"), "in line 2", "keys");
    expect_refusal("{" + std::string(1 << 20, '['), "in line 1", "characters");
    expect_refusal("[1]", "at byte 0", "something else");
}

// Every truncation and tens of thousands of flips, with and without a right checksum: each is
// refused as InputError, or is a recording that passes check().
TEST(Recording, NoTruncationOrFlippedByteGetsPastTheReader)
{
    const Recording r = some_recording(2);
    std::mt19937_64 source(7);
    int accepted = 0, refused = 0;
    const auto attempt = [&](const std::string& bytes) {
        try {
            check(from_bytes(bytes, "file"));
            ++accepted;
        } catch (const InputError&) {
            ++refused;
        }
    };
    for (const std::string& good : {to_binary(r), to_lines(r)}) {
        for (std::size_t size = 0; size + 1 < good.size(); size += size < 200 ? 1 : 7) {
            const int before = accepted;
            attempt(good.substr(0, size));
            ASSERT_EQ(accepted, before) << "cut to " << size << " bytes";
        }
        for (int i = 0; i < 5000; ++i) {
            std::string bytes = good;
            const int flips = 1 + int(source() % 4);
            for (int k = 0; k < flips; ++k)
                bytes[source() % bytes.size()] ^= char(1 + source() % 255);
            attempt(bytes);
        }
    }
    const std::string good = to_binary(r);
    for (int i = 0; i < 20000; ++i) {
        const char letter = char(source());
        const std::size_t reach = i % 2 == 0 ? frames_at(r) + 100 : good.size() - 8;
        attempt(resealed(good, source() % reach, &letter, 1));
    }
    EXPECT_GT(accepted, 1000);  // flips of low bits of numbers
    EXPECT_GT(refused, 10000);
}

}  // namespace
}  // namespace knead
