// What a checkpoint holds: each number of it, in bytes that do not change within a version.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/run/checkpoint.h"
#include "tests/document/random.h"
#include "tests/folder.h"
#include "tests/run/checkpoint_6.h"
#include "tests/session/filled_state.h"

namespace knead {
namespace {

class CheckpointContent : public InFolder {};

void fill(FrameStats& stats, Next& next) { each_stored_number(stats, next); }

void fill(Audit& a, Next& next)
{
    next.all(a.mass, a.volume, a.unloaded, a.kinetic, a.elastic, a.fastest, a.broken, a.hash,
             a.momentum, a.spin);
}

void fill(FrameRow& r, Next& next)
{
    next.all(r.simulated, r.hand_time, r.hands, r.wall, r.hands_wall, r.surface_wall);
    fill(r.stats, next);
    next.all(r.audited, r.crowding.particles, r.crowding.most, r.left.count, r.left.mean,
             r.left.p99, r.left.max, r.between.count, r.between.mean, r.between.p99, r.between.max,
             r.meshed, r.kept, r.mesh_volume, r.triangles, r.splats_split, r.splats_added,
             r.splats_waiting, r.cubes, r.cubes_activated, r.cubes_frozen);
    fill(r.state, next);
    r.stages = {{"p2g", 0.5}, {"grid", 0.25}};
}

Checkpoint filled()
{
    Next next;
    Checkpoint c;
    c.command = {{"scene", "a.json"}, {"frames", 12}};
    c.record.rows.resize(2);
    for (int i = 0; i < 2; ++i) {
        c.record.rows[std::size_t(i)].frame = i + 1;
        fill(c.record.rows[std::size_t(i)], next);
    }
    fill(c.record.first, next);
    next.all(c.record.first_mesh_volume, c.record.wall, c.record.depths.count, c.record.depths.sum,
             c.record.depths.max, c.record.depths.bins[3], c.record.depths.bins.back());
    c.record.frames_wanted = 12;
    fill_state(c.stored, next);
    c.meta = {"a-b-c", "0.1.0", "2026-01-31T12:00:00Z", "cpu", true, true};
    c.scene = {"/scenes/a.json", "{}", {"seed=5"}};
    c.stored.document = empty_room(), c.stored.frames = 2, c.stored.time = 0.0625;
    return c;
}

// Of all chunks: kinds and payloads. The rest of a file is another in each.
std::vector<std::pair<std::string, std::string>> contents(const std::string& file)
{
    std::vector<std::pair<std::string, std::string>> all;
    const ChunkFile chunks(file);
    for (const ChunkHead& head : chunks.chunks())
        all.emplace_back(head.kind.text(), chunks.payload(head));
    return all;
}

// The facts are CBOR as nlohmann::json writes it since 3.8.
TEST_F(CheckpointContent, AFileOfVersion6HasTheSameBytesAsEver)
{
    const std::string bytes = checkpoint_6(filled());
    std::uint64_t sum;  // over the bytes before it
    std::memcpy(&sum, bytes.data() + bytes.size() - 8, 8);
    EXPECT_EQ(bytes.size(), 2106u);
    EXPECT_EQ(sum, 7497262924001653405u);
    write_whole(path("filled"), bytes);
    Checkpoint read = read_checkpoint(path("filled"));
    EXPECT_EQ(read.meta.session, "");
    EXPECT_EQ(read.stored.document, nullptr);
    // What version 6 does not have.
    read.meta = filled().meta, read.stored.document = empty_room(), read.stored.frames = 2;
    EXPECT_EQ(checkpoint_6(read), bytes);
}

// The stored state: tests/session/stored_state_test.cpp.
TEST_F(CheckpointContent, ARecordOfVersion7HasTheSameBytesAsEver)
{
    write_checkpoint(path("filled"), filled());
    const auto all = contents(path("filled"));
    ASSERT_EQ(all.size(), 4u);
    EXPECT_EQ(all[0].first, "META");
    EXPECT_EQ(all[1].first, "SCEN");
    EXPECT_EQ(all[2].first, "STAT");
    EXPECT_EQ(all[3].first, "RUNR");
    const std::string& record = all[3].second;
    EXPECT_EQ(record.size(), 798u);
    EXPECT_EQ(std::uint64_t(XXH64(record.data(), record.size(), 0)), 16136411967208796102u);
    const Checkpoint read = read_checkpoint(path("filled"));
    write_checkpoint(path("again"), read);
    EXPECT_EQ(contents(path("again")), all);
    EXPECT_EQ(read.meta.session, "a-b-c");
    EXPECT_EQ(read.scene.settings, filled().scene.settings);
}

// One that knows no checkpoints takes it for a session with the state as its end.
TEST_F(CheckpointContent, IsASessionThatEndsWithItsState)
{
    write_checkpoint(path("filled"), filled());
    const SessionFile session(path("filled"));
    EXPECT_TRUE(session.run_record()->ancillary());
    EXPECT_TRUE(session.ended());
    EXPECT_EQ(session.read_only(), "");
    EXPECT_EQ(session.saved_as(), "");
    EXPECT_EQ(session.steps(), 0);
    EXPECT_EQ(session.frames(), 0);
    ASSERT_EQ(session.states(), std::vector<std::uint64_t>{session.final_state()});
    EXPECT_EQ(to_bytes(session.state(session.final_state())), to_bytes(filled().stored));
    EXPECT_EQ(session.clay().particles.size(), 3u);
    EXPECT_NO_THROW(verify_session(session));

    // Anything after it: no checkpoint any more, but still a session.
    std::vector<Chunk> more = {chunk_of("THMB", "a picture", 0, 0, chunk_ancillary)};
    copy_chunks(path("filled"), session.chunks().end(), more, path("longer"));
    EXPECT_EQ(SessionFile(path("longer")).run_record(), nullptr);
    EXPECT_FALSE(is_checkpoint(path("longer")));
    EXPECT_THROW(read_checkpoint(path("longer")), InputError);
    compact_session(session, path("compact"));
    EXPECT_EQ(contents(path("compact")), contents(path("filled")));
    compact_session(SessionFile(path("longer")), path("compact"));
    EXPECT_FALSE(is_checkpoint(path("compact")));
    EXPECT_NE(SessionFile(path("compact")).final_state(), 0u);
    EXPECT_TRUE(is_checkpoint(path("filled")));
}

TEST_F(CheckpointContent, OneOfVersion6IsNoSession)
{
    write_whole(path("older"), checkpoint_6(filled()));
    EXPECT_TRUE(is_checkpoint(path("older")));
    const auto reason = [&](const std::function<void()>& action) -> std::string {
        try {
            action();
        } catch (const InputError& e) {
            return e.what();
        }
        return "";
    };
    for (const std::string& why : {reason([&] { is_session(path("older")); }),
                                   reason([&] { SessionFile file(path("older")); })})
        EXPECT_NE(why.find("is a checkpoint of an older knead, and no session"), std::string::npos)
            << why;
}

TEST_F(CheckpointContent, ARecordThatDoesNotFitItsStateIsRefused)
{
    const auto why_not = [&](const std::function<void(Checkpoint&)>& spoil) -> std::string {
        Checkpoint c = filled();
        spoil(c);
        write_checkpoint(path("bad"), c);
        try {
            read_checkpoint(path("bad"));
        } catch (const InputError& e) {
            return e.what();
        }
        return "";
    };
    EXPECT_EQ(why_not([](Checkpoint&) {}), "");
    EXPECT_NE(why_not([](Checkpoint& c) { c.stored.frames = 3; }).find("not that after its frames"),
              std::string::npos);
    const auto no_run = [](Checkpoint& c) { c.record.rows.clear(), c.stored.frames = 0; };
    EXPECT_NE(why_not(no_run).find("not those of an unfinished run"), std::string::npos);

    // A state that is not in the file; facts that are none.
    write_checkpoint(path("good"), filled());
    const ChunkFile good(path("good"));
    const Json facts = record_facts(path("good"));
    const auto with = [&](const Json& record, std::uint64_t state) -> std::string {
        const std::vector<std::uint8_t> bytes = Json::to_cbor(record);
        const Chunk chunk = chunk_of(run_record_kind, std::string(bytes.begin(), bytes.end()), 0,
                                     state, chunk_ancillary);
        const auto keep = [](const ChunkHead& head) { return head.kind != run_record_kind; };
        rewrite_chunks(good, keep, {chunk}, path("bad"));
        try {
            read_checkpoint(path("bad"));
        } catch (const InputError& e) {
            return e.what();
        }
        return "";
    };
    EXPECT_EQ(with(facts, 1), "");
    EXPECT_NE(with(facts, 2).find("there is no state 2"), std::string::npos);
    Json newer = facts;
    newer["schema"] = "knead.checkpoint/8";
    EXPECT_NE(
        with(newer, 1).find("expected knead.checkpoint/7, found the text \"knead.checkpoint/8\""),
        std::string::npos)
        << with(newer, 1);
    for (const auto& [key, value] : facts.items()) {
        Json less = facts;
        less.erase(key);
        EXPECT_NE(with(less, 1), "") << key;
    }
    EXPECT_NE(with(Json::array(), 1), "");
}

TEST_F(CheckpointContent, EachStoredStatisticOfAFrameIsReadAsWritten)
{
    Checkpoint c = filled();
    FrameStats& written = c.record.rows.back().stats;
    written[Count::covered] = 1, written.touched = 2, written.cut = true, written.reached = 3;
    write_checkpoint(path("filled"), c);
    const FrameStats read = read_checkpoint(path("filled")).record.rows.back().stats;
    each_statistic([&](const auto& row) {
        const FrameStats& wanted = row.stored() ? written : FrameStats{};
        EXPECT_EQ(std::memcmp(&read[row.member], &wanted[row.member], sizeof read[row.member]), 0)
            << row.name;
    });
}

// Each array that is longer or shorter by an element than its count says.
TEST_F(CheckpointContent, CountsThatDoNotFillTheBodyAreRefused)
{
    const auto refused = [&](const Checkpoint& c) {
        write_checkpoint(path("bad"), c);
        EXPECT_THROW(read_checkpoint(path("bad")), InputError);
    };
    Checkpoint c = filled();
    c.stored.state.contents.particles.pop_back(), refused(c);
    c = filled(), c.stored.state.order.pop_back(), refused(c);
    c = filled(), c.stored.splats.extent.pop_back(), refused(c);
    c = filled(), c.stored.local.active.push_back(0), refused(c);
    c = filled(), c.stored.local.normal.pop_back(), refused(c);
    c = filled(), c.stored.splats.cloud.degree = 2, refused(c);
    c = filled(), c.stored.splats.cloud.degree = -1, refused(c);
}

}  // namespace
}  // namespace knead
