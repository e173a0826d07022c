// Damaged, cut, spliced, foreign and newer session files: refused, or a shorter valid prefix; never
// other clay. And a session of the first version of the format, which each later build reads.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>

#include "host/base/errors.h"
#include "host/document/document_text.h"
#include "host/live/live_session.h"
#include "host/session/capture.h"
#include "host/session/session_file.h"
#include "tests/files/chunk_bytes.h"
#include "tests/folder.h"
#include "tests/reason.h"
#include "tests/sanitized.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

const std::string golden = "tests/golden/session_v1.knead";  // by tests/golden_session.sh

std::unique_ptr<Simulator> damage_solver(const Setup& setup) { return cpu_solver(setup); }

// What a session gives to who opens it.
struct Contents {
    struct Step {
        std::string label, document;
        std::uint64_t clay = 0;  // hash of its rows
        bool operator==(const Step&) const = default;
    };
    std::map<StepId, Step> steps;
    StepId current = 0;
    std::vector<std::uint64_t> chunks;  // hashes of their payloads
};

Contents contents_of(const SessionFile& file)
{
    Contents found;
    History all(std::size_t(1) << 40);
    file.read_history(all, file.current());
    for (const StepInfo& info : all.list()) {
        const HistoryStep& step = *all.find(info.id);
        found.steps[info.id] = {step.label, document_text(*step.document),
                                hash(*all.rows_of(info.id))};
        if (info.current) found.current = info.id;
    }
    for (const ChunkHead& head : file.chunks().chunks()) found.chunks.push_back(head.hash);
    return found;
}
Contents contents_in(const std::string& file) { return contents_of(SessionFile(file)); }

bool starts(const std::vector<std::uint64_t>& all, const std::vector<std::uint64_t>& with)
{
    return with.size() <= all.size() && std::equal(with.begin(), with.end(), all.begin());
}

class SessionDamage : public InFolder {
  protected:
    SessionDamage()
    {
        if (const char* state = std::getenv("XDG_STATE_HOME")) state_before = state;
        setenv("XDG_STATE_HOME", (folder / "state").c_str(), 1);
        in_groups(golden, file, {});
        original = contents_in(file);
        bytes = bytes_in(file);
    }
    ~SessionDamage() override
    {
        if (state_before.empty())
            unsetenv("XDG_STATE_HOME");
        else
            setenv("XDG_STATE_HOME", state_before.c_str(), 1);
    }

    // The chunks of a file in groups of three, as a log has them, and others.
    static void in_groups(const std::string& from, const std::string& to,
                          const std::vector<Chunk>& more)
    {
        const ChunkFile read(from);
        ChunkWriter writer(to);
        std::size_t count = 0;
        for (const ChunkHead& head : read.chunks()) {
            writer.add(read.stored(head));
            if (++count % 3 == 0) writer.commit();
        }
        for (const Chunk& chunk : more) writer.add(chunk);
        writer.commit();
    }

    LiveOptions options(const std::string& session) const
    {
        LiveOptions by;
        by.make_solver = damage_solver;
        by.session = session;
        by.paused = by.manual_start = true;
        return by;
    }

    enum Outcome { refused, shorter, whole };
    // Fails the test if what is read is neither the original nor a prefix of it.
    Outcome outcome(const std::string& name) const
    {
        try {
            const SessionFile session(name);
            EXPECT_TRUE(starts(original.chunks, contents_of(session).chunks));
            const Contents found = contents_of(session);
            for (const auto& [id, step] : found.steps)
                if (step != original.steps.at(id))
                    ADD_FAILURE() << "step " << id << " is another one";
            verify_session(session);
            return found.chunks.size() == original.chunks.size() ? whole : shorter;
        } catch (const InputError&) {
            return refused;
        }
    }
    // The same by opening it to go on.
    void opens_or_is_refused(const std::string& name) const
    {
        LiveSession session(nullptr, options(name));
        try {
            session.wait_until_open();
        } catch (const InputError&) {
            return;
        }
        const auto state = session.state();
        EXPECT_EQ(state->failure, "");
        if (!state->steps) return;
        for (const StepInfo& info : *state->steps) {
            const auto known = original.steps.find(info.id);
            ASSERT_NE(known, original.steps.end());
            EXPECT_EQ(info.label, known->second.label);
            if (info.current) {
                EXPECT_EQ(document_text(*state->document), known->second.document);
            }
        }
    }

    const std::string file = path("original.knead");
    Contents original;
    std::string bytes;

  private:
    std::string state_before;
};

// 1 in a long run.
std::size_t stride(std::size_t in_short)
{
    return std::getenv("KNEAD_LONG") ? 1 : sanitized ? 8 * in_short : in_short;
}

void put_at(std::fstream& file, std::size_t at, char byte)
{
    file.seekp(std::streamoff(at));
    file.put(byte).flush();
}

TEST_F(SessionDamage, OfEachBitIsFoundOrCutsTheFileThere)
{
    const std::string flipped = path("flipped.knead");
    put_bytes(flipped, bytes);
    std::fstream in(flipped, std::ios::in | std::ios::out | std::ios::binary);
    const std::size_t step = stride(509);
    long counts[3] = {}, number = 0;
    for (std::size_t bit = 0; bit < 8 * bytes.size(); bit += step, ++number) {
        const std::size_t at = bit / 8;
        put_at(in, at, char(bytes[at] ^ (1 << bit % 8)));
        const Outcome found = outcome(flipped);
        ++counts[found];
        ASSERT_NE(found, whole) << "bit " << bit;
        if (number % (step == 1 ? 4001 : 40) == 0) opens_or_is_refused(flipped);
        put_at(in, at, bytes[at]);
    }
    std::printf("%ld bits of %zu: %ld files refused, %ld shorter\n", number, 8 * bytes.size(),
                counts[refused], counts[shorter]);
    EXPECT_EQ(outcome(flipped), whole);
}

TEST_F(SessionDamage, AFileThatIsCutHasAPrefixOfItsSteps)
{
    const std::string cut = path("cut.knead");
    put_bytes(cut, bytes);
    long counts[3] = {}, number = 0;
    const std::size_t step = stride(97);
    std::size_t steps = original.steps.size();
    for (std::size_t size = bytes.size(); size-- > 0;) {
        if (size % step != 0 && size + 1 != bytes.size()) continue;
        fs::resize_file(cut, size);
        const Outcome found = outcome(cut);
        ++counts[found], ++number;
        ASSERT_NE(found, whole) << size;
        if (found != shorter) continue;
        const Contents rest = contents_in(cut);
        ASSERT_LE(rest.steps.size(), steps) << size;
        steps = rest.steps.size();
        if (number % (step == 1 ? 499 : 20) == 0) opens_or_is_refused(cut);
    }
    std::printf("%ld lengths of %zu: %ld files refused, %ld shorter\n", number, bytes.size(),
                counts[refused], counts[shorter]);
    EXPECT_GT(counts[shorter], 5);
    EXPECT_GT(counts[refused], 0);
}

TEST_F(SessionDamage, ChunksOfAnotherSessionAndOutOfOrderAreNotRead)
{
    in_groups(golden, path("other.knead"), {});  // with another salt
    const std::string other = bytes_in(path("other.knead")), made = path("made.knead");
    const std::vector<std::size_t> places = chunk_places(bytes);
    ASSERT_EQ(places, chunk_places(other));
    const auto chunk = [&](const std::string& of, std::size_t i) {
        const std::size_t end = i + 1 < places.size() ? places[i + 1] : of.size();
        return of.substr(places[i], end - places[i]);
    };
    for (std::size_t i = 0; i < places.size(); ++i) {
        const std::string before = bytes.substr(0, places[i]), one = chunk(bytes, i),
                          after = bytes.substr(places[i] + one.size());
        put_bytes(made, before + chunk(other, i) + after);  // replaced
        EXPECT_NE(outcome(made), whole) << i;
        put_bytes(made, before + chunk(other, i) + one + after);  // inserted
        EXPECT_NE(outcome(made), whole) << i;
        put_bytes(made, before + after);  // missing
        EXPECT_NE(outcome(made), whole) << i;
        put_bytes(made, before + one + one + after);  // twice
        if (i + 1 < places.size()) {
            EXPECT_NE(outcome(made), whole) << i;
            put_bytes(made, before + chunk(bytes, i + 1) + one +
                                after.substr(chunk(bytes, i + 1).size()));
            EXPECT_NE(outcome(made), whole) << i;
        }
        if (i % 4 == 0) opens_or_is_refused(made);
    }
    put_bytes(made, other.substr(0, session_head) + bytes.substr(session_head));
    EXPECT_EQ(outcome(made), refused);
    put_bytes(made, bytes + other.substr(session_head));
    EXPECT_EQ(outcome(made), whole);  // what follows the last commit does not count
    EXPECT_FALSE(ChunkFile(made).broken_by().empty());
}

// Valid containers of chunks that do not belong together.
TEST_F(SessionDamage, StepsWithParticlesOfOtherStepsAreRefused)
{
    const ChunkFile read(file);
    const auto ids = [&](ChunkKind kind) {
        std::vector<std::size_t> at;
        for (std::size_t i = 0; i < read.chunks().size(); ++i)
            if (read.chunks()[i].kind == kind) at.push_back(i);
        return at;
    };
    int made = 0;
    for (const ChunkKind kind : {ChunkKind("DIFF"), ChunkKind("STEP"), ChunkKind("ROWS")})
        for (const std::size_t a : ids(kind))
            for (const std::size_t b : ids(kind)) {
                if (a == b) continue;
                const std::string name = path(std::to_string(++made) + ".knead");
                {
                    ChunkWriter writer(name);
                    for (std::size_t i = 0; i < read.chunks().size(); ++i) {
                        Chunk chunk = read.stored(read.chunks()[i == a ? b : i]);
                        chunk.id = read.chunks()[i].id, chunk.parent = read.chunks()[i].parent;
                        writer.add(chunk);
                    }
                    writer.commit();
                }
                EXPECT_THROW(verify_session(SessionFile(name)), InputError) << a << " " << b;
                opens_or_is_refused(name);
            }
    EXPECT_GT(made, 6);
}

TEST_F(SessionDamage, AStepWithoutParticlesLeavesItsNumberToNoOther)
{
    // As a kill between the two leaves it; the log goes on with a step of the same number.
    const ChunkFile read(file);
    std::size_t last = 0;
    for (std::size_t i = 0; i < read.chunks().size(); ++i)
        if (read.chunks()[i].kind == ChunkKind("DIFF")) last = i;
    const StepId id = read.chunks()[last].id;
    const std::string name = path("without.knead");
    {
        ChunkWriter writer(name);
        for (std::size_t i = 0; i < last; ++i) writer.add(read.stored(read.chunks()[i]));
        writer.commit();
    }
    const SessionFile session(name);
    History all;
    session.read_history(all, session.current());
    EXPECT_FALSE(all.find(id));
    EXPECT_GT(all.count(), 1u);
    EXPECT_EQ(all.current().id, all.list().back().id);
    EXPECT_GT(all.open("", all.current().document, all.current().objects), id);
}

TEST_F(SessionDamage, UnknownAncillaryChunksSurviveASave)
{
    const std::string name = path("more.knead"), saved = path("saved.knead");
    in_groups(file, name, {chunk_of("XTRA", "kept", 7, 5, chunk_ancillary)});
    EXPECT_EQ(SessionFile(name).read_only(), "");
    const auto has_it = [](const std::string& in) {
        const ChunkFile read(in);
        for (const ChunkHead& head : read.chunks())
            if (head.kind == ChunkKind("XTRA"))
                return read.payload(head) == "kept" && head.id == 7 && head.parent == 5 &&
                       head.ancillary();
        return false;
    };
    for (const bool input : {true, false}) {
        LiveOptions by = options(name);
        by.protects = true;
        LiveSession session(nullptr, by);
        session.wait_until_open();
        session.send(SetGravity{{0, input ? 1. : 2., 0}});
        session.send(Save{saved, input});
        session.wait_for_commands();
        for (int i = 0; i < 10000 && session.state()->saved_as != saved; ++i) {
            session.send(Pause{true});
            session.wait_for_commands();
        }
        EXPECT_EQ(session.state()->refusal, "");
        EXPECT_TRUE(has_it(saved));
        EXPECT_EQ(contents_in(saved).steps.size(), original.steps.size() + 1);
    }
    compact_session(SessionFile(name), saved);
    EXPECT_TRUE(has_it(saved));
}

TEST_F(SessionDamage, UnknownRequiredChunksMakeAFileReadOnly)
{
    const std::string name = path("newer.knead");
    in_groups(file, name, {chunk_of("NEWS", "of a newer version", 1)});
    const SessionFile session(name);
    EXPECT_NE(session.read_only().find("NEWS"), std::string::npos);
    verify_session(session);
    EXPECT_EQ(contents_of(session).steps, original.steps);
    EXPECT_FALSE(session.clay().particles.empty());
    for (const bool protects : {false, true}) {
        LiveOptions by = options(name);
        by.protects = protects;
        LiveSession live(nullptr, by);
        const std::string why = reason<InputError>([&] { live.wait_until_open(); });
        EXPECT_NE(why.find("can be read, but not gone on with"), std::string::npos) << why;
        EXPECT_NE(why.find("NEWS"), std::string::npos) << why;
    }
    ReplayOptions by;
    by.make_solver = damage_solver, by.stepped = true;
    by.stored_state = [&](std::uint64_t id) { return session.state(id); };
    by.read_history = [&](History& past) { session.read_history(past, 0); };
    SessionReplay replay(live_scene_of(session.scene()), by);
    session.each_event([&](const SessionEvent& event) { return replay.add(event); });
    EXPECT_EQ(replay.frames(), session.frames());
}

TEST_F(SessionDamage, ANewerVersionIsRefused)
{
    std::string newer = bytes;
    put_number(newer, 16, 2, 4);
    put_bytes(path("newer.knead"), rehashed(newer));
    EXPECT_NE(reason<InputError>([&] { SessionFile(path("newer.knead")); }).find("newer knead"),
              std::string::npos);
}

TEST_F(SessionDamage, ARefusedFileLeavesTheSessionAsItIs)
{
    std::string flipped = bytes;
    const std::vector<std::size_t> places = chunk_places(bytes);
    for (const std::size_t at : places)
        if (number_in(bytes, at, 4) == ChunkKind("DIFF").code) flipped[at + 60] ^= 1;
    put_bytes(path("flipped.knead"), flipped);
    LiveOptions by = options(file);
    by.protects = true;
    LiveSession session(nullptr, by);
    session.wait_until_open();
    const auto before = session.state();
    session.send(Open{path("flipped.knead"), {}, {}});
    session.wait_for_commands();
    const auto after = session.state();
    EXPECT_EQ(after->refused, 1);
    EXPECT_NE(after->refusal.find("flipped.knead"), std::string::npos) << after->refusal;
    EXPECT_EQ(after->steps->size(), before->steps->size());
    EXPECT_EQ(after->log.file, before->log.file);
    EXPECT_TRUE(fs::exists(after->log.file));
    session.send(Undo{});
    session.wait_for_commands();
    EXPECT_EQ(session.state()->refused, 1) << session.state()->refusal;
}

TEST(GoldenSession, OfTheFirstVersionIsRead)
{
    EXPECT_LT(fs::file_size(golden), 60000u);
    const SessionFile session(golden);
    verify_session(session);
    EXPECT_EQ(session.chunks().version(), 1);
    EXPECT_EQ(session.meta().program, "0.1.0");
    EXPECT_TRUE(session.meta().deterministic && session.meta().stepped);
    EXPECT_EQ(session.frames(), 11);
    EXPECT_EQ(session.current(), 4u);
    EXPECT_EQ(session.states().size(), 2u);  // one is that of a beginning with velocities
    EXPECT_EQ(session.hands().size(), session.recording().frames.size());
    struct Expected {
        StepId parent;
        const char *label, *objects;
        double gravity;
        std::uint64_t clay;
    };
    const Expected expected[] = {
        {0, "", "1 ball clay", -9.81, 0x342b3d787fb257d9},
        {0, "Add object", "1 ball clay, 2 brick snow", -9.81, 0x0fe7af4946abe04f},
        {1, "Rename", "1 renamed clay, 2 brick snow", -9.81, 0x0fe7af4946abe04f},
        {2, "Gravity", "1 renamed clay, 2 brick snow", 5, 0xa7c8a029bafb33c6},
        {2, "Material", "1 renamed clay, 2 brick clay", -9.81, 0x01dd8fd7a0a34b42},
        {4, "Delete", "1 renamed clay", -9.81, 0x5ca9a3e7233d047c}};
    History all;
    session.read_history(all, session.current());
    ASSERT_EQ(all.count(), std::size(expected));
    EXPECT_EQ(all.current().id, 4u);
    for (StepId id = 0; id < std::size(expected); ++id) {
        const HistoryStep& step = *all.find(id);
        const Expected& e = expected[id];
        EXPECT_EQ(step.parent, e.parent);
        EXPECT_EQ(step.label, e.label);
        EXPECT_EQ(step.document->scene->gravity.y, e.gravity);
        EXPECT_EQ(hash(*all.rows_of(id)), e.clay) << id;
        std::string objects;
        for (const auto& o : step.document->objects)
            objects += (objects.empty() ? "" : ", ") + std::to_string(o->id.value) + " " + o->name +
                       " " + o->material.name;
        EXPECT_EQ(objects, e.objects);
    }
    // Velocities of the beginning.
    ASSERT_TRUE(all.find(0)->beginning);
    for (const Particle<double>& p : all.find(0)->beginning->particles)
        EXPECT_NEAR(p.v.x, 0.1, 1e-6);
}

}  // namespace
}  // namespace knead
