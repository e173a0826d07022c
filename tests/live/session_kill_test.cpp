// Live sessions that are killed at random moments: the working log and the user's file are valid
// sessions at all times, and go on.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <new>
#include <random>
#include <string>
#include <thread>

#include "host/base/errors.h"
#include "host/base/machine.h"
#include "host/hands/gesture.h"
#include "host/live/live_session.h"
#include "host/scene/presets.h"
#include "host/session/session_file.h"
#include "tests/files/chunk_bytes.h"
#include "tests/folder.h"
#include "tests/reason.h"
#include "tests/sanitized.h"

namespace knead {
namespace {
namespace fs = std::filesystem;
using namespace std::chrono_literals;

// What a process that will be killed says of itself. A ring of moments: at `at`, hands up to
// `hands` had been given to the session, and steps up to `step` had begun.
struct KillProgress {
    static constexpr std::size_t size = 4096;
    struct Moment {
        double at = 0, hands = 0;  // wall time, time of the session [s]
        StepId step = 0;
    };
    Moment ring[size];
    std::atomic<std::size_t> moments = 0;
    std::atomic<long> opened = 0, saved = 0, refused = 0, commands = 0;
    std::atomic<double> slowest = 0;  // time that the disk took for a write [s]
    std::atomic<bool> ready = false;  // of this process: it has opened the session
    char log[1024] = {};              // of this process

    void add(const Moment& one)
    {
        ring[moments % size] = one;
        ++moments;
    }
    // The last one not later than `at`; none: zeros.
    Moment before(double at) const
    {
        for (std::size_t i = moments; i > 0 && i + size > moments; --i)
            if (ring[(i - 1) % size].at <= at) return ring[(i - 1) % size];
        return {};
    }
};

std::unique_ptr<Simulator> kill_solver(const Setup& setup) { return cpu_solver(setup); }

class SessionKill : public InFolder {
  protected:
    SessionKill()
    {
        fs::create_directory(folder / "state");
        if (const char* state = std::getenv("XDG_STATE_HOME")) state_before = state;
        setenv("XDG_STATE_HOME", (folder / "state").c_str(), 1);
        std::ofstream(path("ball.json")) << R"({"schema": "knead.scene/1",
            "domain": {"edge": 0.32, "cells": 16}, "frame_rate": 90, "surface": {"nodes": 16},
            "objects": [{"name": "ball", "shape": "sphere", "centre": [0.16, 0.07, 0.16],
                         "diameter": 0.09, "material": {"preset": "clay", "young": 1e5}}],
            "hands": {"recording": "squeeze", "at": [0.16, 0.07, 0.16], "zoom": 0.5}})";
        void* const memory = mmap(nullptr, sizeof(KillProgress), PROT_READ | PROT_WRITE,
                                  MAP_SHARED | MAP_ANONYMOUS, -1, 0);
        progress = new (memory) KillProgress;
    }
    ~SessionKill() override
    {
        munmap(progress, sizeof(KillProgress));
        if (state_before.empty())
            unsetenv("XDG_STATE_HOME");
        else
            setenv("XDG_STATE_HOME", state_before.c_str(), 1);
    }

    LiveOptions options() const
    {
        LiveOptions by;
        by.make_solver = kill_solver;
        by.recorded = false, by.protects = true;
        return by;
    }
    std::vector<std::string> logs() const
    {
        std::vector<std::string> all;
        for (const auto& entry : fs::directory_iterator(log_folder()))
            if (entry.path().extension() == log_ending) all.push_back(entry.path().string());
        return all;
    }
    // Forks a process that runs `work`, which may return.
    template <class Work>
    pid_t child(const Work& work)
    {
        progress->ready = false, progress->log[0] = 0, progress->moments = 0;
        progress->slowest = 0;
        const pid_t process = fork();
        if (process != 0) return process;
        try {
            work();
        } catch (const std::exception& e) {
            std::fprintf(stderr, "%s\n", e.what());
            _exit(9);
        }
        _exit(0);
    }

    void work(const std::string& log, unsigned seed, double seconds) const;
    void stay(double seconds) const;

    const std::string user_file = path("user.knead");
    KillProgress* progress;

  private:
    std::string state_before;
};

[[noreturn]] void child_fails(const std::string& why)
{
    std::fprintf(stderr, "%s\n", why.c_str());
    _exit(8);
}

Command random_edit(std::mt19937& random, const LiveState& state, const std::string& user_file)
{
    std::uniform_real_distribution<double> unit;
    const Document& document = *state.document;
    const auto any = [&] { return document.objects[random() % document.objects.size()]->id; };
    const bool many = document.objects.size() > 3, none = document.objects.empty();
    switch (random() % 12) {
        case 0:
        case 1:
            return SetGravity{{0, -9.81 * unit(random), 0}};
        case 2:
            return SetMaterial{none ? ObjectRef("ball") : any(), material_spec("snow")};
        case 3:
            return SetMaterial{none ? ObjectRef("ball") : any(), material_spec("clay")};
        case 4: {
            if (many) return RemoveObjects{{any()}};
            SceneObject added;
            added.material = material_spec("clay");
            added.source.size = {0.04, 0.04, 0.04};
            added.pose.p = {0.06 + 0.2 * unit(random), 0.2, 0.06 + 0.2 * unit(random)};
            return AddObject{added};
        }
        case 5:
        case 6:
        case 7:
            return Undo{};
        case 8:
            return Redo{};
        case 9:
            return GoTo{state.steps ? int((*state.steps)[random() % state.steps->size()].id) : 0};
        case 10:
            return Save{user_file, random() % 2 == 0};
        default:
            return Save{user_file, {}};
    }
}

// Gives the hands of a gesture again and again, as time goes on.
class GivenHands {
  public:
    explicit GivenHands(LiveSession& to) : session(to), offset(to.now()) {}
    void give()
    {
        for (; at < gesture.frames.size() && gesture.frames[at].time + offset <= session.now();
             ++at) {
            HandFrame frame = gesture.frames[at];
            frame.time += offset;
            session.push(frame);
            latest = frame.time;
        }
        if (at == gesture.frames.size()) at = 0, offset = session.now() + 0.01;
    }
    double last() const { return latest; }  // time of the last frame given [s]

  private:
    LiveSession& session;
    const Recording gesture = generate("squeeze");
    double offset, latest = 0;
    std::size_t at = 0;
};

// Measures how long the disk takes for a small write, while a process lives.
class DiskProbe {
  public:
    DiskProbe(const std::string& folder, std::atomic<double>& slowest)
        : thread([this, folder, &slowest] {
              const int file = ::open(folder.c_str(), O_RDWR | O_TMPFILE, 0600);
              while (file >= 0 && !ends) {
                  const double began = wall_seconds();
                  if (::pwrite(file, "x", 1, 0) != 1 || ::fdatasync(file) != 0) break;
                  slowest = std::max<double>(slowest, wall_seconds() - began);
                  std::this_thread::sleep_for(20ms);
              }
              ::close(file);
          })
    {
    }
    ~DiskProbe()
    {
        ends = true;
        thread.join();
    }

  private:
    std::atomic<bool> ends = false;
    std::thread thread;
};

// Opens the log, or a new session where it is "", and works with it for a time, or until the
// process is killed.
void SessionKill::work(const std::string& log, unsigned seed, double seconds) const
{
    std::mt19937 random(seed);
    LiveOptions by = options();
    by.session = log;
    std::shared_ptr<const LiveScene> scene;
    std::optional<SessionFile::Clay> expected;
    StepId current = 0;
    if (log.empty()) {
        scene = load_live_scene(path("ball.json"));
    } else {
        const SessionFile file(log);
        if (file.steps() > 0) expected = file.clay(), current = file.current();
        by.paused = expected.has_value();
    }
    const DiskProbe probe(log_folder(), progress->slowest);
    LiveSession session(scene, by);
    session.wait_until_open();
    std::shared_ptr<const LiveState> state = session.state();
    if (!state->failure.empty()) child_fails(state->failure);
    if (state->log.file.empty()) child_fails("the session is not protected: " + state->refusal);
    std::snprintf(progress->log, sizeof progress->log, "%s", state->log.file.c_str());
    progress->ready = true;
    ++progress->opened;
    if (expected) {
        std::vector<Particle<double>> found;
        session.inspect_solver([&](const Simulator& s) { found = s.particles(); });
        bool equal = found.size() == expected->particles.size();
        for (std::size_t i = 0; equal && i < found.size(); ++i)
            equal = length(found[i].x - expected->particles[i].x) == 0;
        if (!equal) child_fails("the session has other clay than its file");
        for (const StepInfo& step : *session.state()->steps)
            if (step.current && step.id != current) child_fails("the session is at another step");
        session.send(Pause{false});
    }
    GivenHands hands(session);
    const double began = wall_seconds();
    double next_command = began;
    while (wall_seconds() - began < seconds) {
        hands.give();
        state = session.state();
        if (!state->failure.empty()) child_fails(state->failure);
        if (!state->log.trouble.empty()) child_fails(state->log.trouble);
        if (state->refusal.find("Save") == 0) child_fails(state->refusal);
        progress->add({wall_seconds(), hands.last(), state->steps ? state->steps->back().id : 0});
        if (wall_seconds() > next_command) {
            next_command = wall_seconds() + 0.001 * double(random() % 150);
            const Command command = random_edit(random, *state, user_file);
            if (std::holds_alternative<Save>(command)) ++progress->saved;
            session.send(command);
            ++progress->commands;
        }
        std::this_thread::sleep_for(2ms);
    }
    session.send(Pause{true});
    session.send(Save{user_file, {}});
    session.wait_for_commands();
    for (int waited = 0; session.state()->unsaved && waited < 10000; ++waited) {
        session.send(Pause{true});  // publishes a state
        std::this_thread::sleep_for(1ms);
    }
    if (session.state()->unsaved) child_fails("the session cannot be saved");
}

// Resident memory of this process [KiB].
long resident()
{
    std::ifstream in("/proc/self/status");
    for (std::string line; std::getline(in, line);)
        if (line.starts_with("VmRSS:")) return std::stol(line.substr(6));
    return 0;
}

// A session with a small budget for its steps, whose memory must not grow after a third of the
// time.
void SessionKill::stay(double seconds) const
{
    LiveOptions by = options();
    by.history = std::size_t(256) << 10;
    LiveSession session(load_live_scene(path("ball.json")), by);
    session.wait_for_commands();
    progress->ready = true;
    std::mt19937 random(6);
    GivenHands hands(session);
    const double began = wall_seconds();
    double next_command = began, next_sample = began;
    long early = 0, late = 0;  // the most, before and after a third
    std::size_t steps = 0;
    while (wall_seconds() - began < seconds) {
        const double now = wall_seconds();
        hands.give();
        const auto state = session.state();
        if (!state->failure.empty()) child_fails(state->failure);
        if (state->steps) steps = std::max(steps, state->steps->back().id);
        if (now > next_command) {
            next_command = now + 0.001 * double(random() % 100);
            session.send(random_edit(random, *state, path("stays.knead")));
            session.take_applied();
        }
        if (now > next_sample) {
            next_sample = now + 0.1;
            long& most = now - began < seconds / 3 ? early : late;
            most = std::max(most, resident());
        }
        std::this_thread::sleep_for(2ms);
    }
    std::printf("%.0f s, %d steps: at most %ld KiB before a third of the time, %ld after\n",
                seconds, int(steps), early, late);
    std::fflush(stdout);
    if (late > early + early / 10) child_fails("its memory grows");
}

// A child fails where a hash differs.
void replays(const std::string& file)
{
    const SessionFile session(file);
    ReplayOptions by;
    by.make_solver = kill_solver;
    by.stored_state = [&](std::uint64_t id) { return session.state(id); };
    by.read_history = [&](History& past) { session.read_history(past, 0); };
    long compared = 0;
    by.compared = [&](const ReplayedHash& hash) {
        if (!hash.equal) child_fails("a replay differs in frame " + std::to_string(hash.frame));
        ++compared;
    };
    SessionReplay replay(live_scene_of(session.scene()), by);
    session.each_event([&](const SessionEvent& event) {
        if (const HashEvent* hash = std::get_if<HashEvent>(&event)) replay.expect(*hash);
        return true;
    });
    session.each_event([&](const SessionEvent& event) { return replay.add(event); });
    if (compared == 0) child_fails("a replay compares nothing");
}

struct Seen {
    long steps = 0;    // in the file
    double hands = 0;  // time of the last [s]
};

Seen checked(const std::string& file)
{
    const SessionFile session(file);
    verify_session(session);
    EXPECT_EQ(session.read_only(), "") << file;
    History all(std::size_t(1) << 40);
    session.read_history(all, session.current());
    const auto hands = session.hands();
    return {session.steps(), hands.empty() ? 0 : hands.back().time};
}

long kill_count()
{
    if (const char* count = std::getenv("KNEAD_KILLS")) return std::atol(count);
    return std::getenv("KNEAD_LONG") ? 10000 : sanitized ? 6 : 20;
}

TEST_F(SessionKill, ASessionKilledAtAnyMomentGoesOnAndTheUsersFileIsWhole)
{
    const long kills = kill_count();
    constexpr long in_chain = 6;  // kills of one session
    const char* const seed = std::getenv("KNEAD_SEED");
    std::mt19937 random(seed ? unsigned(std::atoi(seed)) : 59);
    std::uniform_real_distribution<double> unit;
    long recovered = 0, ended = 0, in_recovery = 0, without = 0;
    double slowest = 0, most_lost = 0;  // of input [s]
    StepId most_steps_lost = 0;
    long user_steps = 0, log_steps = 0;
    const long between_long = kills > 1000 ? 60 : 6;  // those that live for seconds
    std::string log;
    for (long i = 0; i < kills; ++i) {
        if (i % in_chain == 0) {
            for (const std::string& old : logs()) delete_log(old);
            fs::remove(user_file);
            log.clear(), user_steps = log_steps = 0;
        }
        const std::string goes_on = log;
        const auto child_seed = unsigned(random());
        const pid_t process = child([&] { work(goes_on, child_seed, 60); });
        ASSERT_GT(process, 0);
        // Each third one while it opens the session, some after the first commits.
        const double wait = i % 3 == 2              ? 0.06 * unit(random)
                            : i % 6 == 0            ? 0.2 + 0.5 * unit(random)
                            : i % between_long == 3 ? 1 + 1.5 * unit(random)
                                                    : 0.3 * unit(random);
        if (i % 3 != 2)
            for (int waited = 0; !progress->ready && waited < 20000; ++waited)
                std::this_thread::sleep_for(1ms);
        std::this_thread::sleep_for(std::chrono::duration<double>(wait));
        const double killed_at = wall_seconds();
        kill(process, SIGKILL);
        int status = 0;
        waitpid(process, &status, 0);
        ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << i << ": " << status;
        if (!progress->ready) ++in_recovery;

        // The log.
        const std::vector<std::string> found = logs();
        ASSERT_LE(found.size(), 1u) << i;
        if (found.empty()) {
            ASSERT_TRUE(goes_on.empty()) << i << ": the log is gone";
            continue;
        }
        const std::vector<Recoverable> list = recoverable_sessions();
        Seen seen;
        try {
            seen = checked(found[0]);
        } catch (const InputError& e) {
            // Nothing was committed yet but its beginning.
            ASSERT_EQ(log_steps, 0) << i << ": " << e.what();
            ASSERT_LE(ChunkFile(found[0]).chunks().size(), 1u) << i << ": " << e.what();
            fs::remove(found[0]);
            log.clear();
            continue;
        }
        ASSERT_GE(seen.steps, log_steps) << i;
        log_steps = seen.steps;
        const SessionFile session(found[0]);
        ASSERT_EQ(list.size(), session.steps() > 1 && !session.ended() ? 1u : 0u) << i;
        if (session.ended()) {
            ++ended;
        } else if (list.empty()) {
            ++without;
        } else {
            ASSERT_EQ(list[0].file, found[0]) << i;
            ASSERT_LT(list[0].age, 60) << i;
            ++recovered;
        }
        log = found[0];
        if (progress->ready) {
            // Of what there was a second before the kill, all but one step. A commit waits for the
            // disk twice, and for the one before.
            const double disk = 4 * progress->slowest;
            slowest = std::max(slowest, disk / 4);
            for (double lost = 0;; lost += 0.02) {
                const KillProgress::Moment one = progress->before(killed_at - lost);
                if (one.hands > seen.hands) continue;
                most_lost = std::max(most_lost, lost - disk);
                break;
            }
            StepId newest = 0;
            for (const ChunkHead& head : session.chunks().chunks())
                if (head.kind == ChunkKind("STEP")) newest = std::max(newest, head.id);
            const StepId had = progress->before(killed_at - disk - 1).step;
            if (had > newest) most_steps_lost = std::max(most_steps_lost, had - newest);
        }

        // The user's file.
        if (!fs::exists(user_file)) continue;
        const Seen user = checked(user_file);
        ASSERT_GE(user.steps, user_steps) << i;
        user_steps = user.steps;
        if (session.ended()) {
            ASSERT_EQ(user.steps, seen.steps) << i;
        }
    }
    std::printf(
        "%ld kills: %ld logs to recover, %ld all of whose steps were saved, %ld had no step, "
        "%ld while opening; %ld commands, "
        "%ld saves; at most %.2f s of input and %d steps older than 1 s lost; a write took "
        "%.0f ms at most\n",
        kills, recovered, ended, without, in_recovery, progress->commands.load(),
        progress->saved.load(), most_lost, int(most_steps_lost), 1e3 * slowest);
    EXPECT_LE(most_lost, sanitized ? 5 : 1);
    EXPECT_LE(most_steps_lost, 1u);
    EXPECT_GT(recovered + ended, kills / 4);

    // What the last one left is opened, saved and ended.
    const pid_t last = child([&] { work(log, 1, 2); });
    int status = 0;
    waitpid(last, &status, 0);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
    EXPECT_TRUE(recoverable_sessions().empty());
    checked(user_file);
    // All that was computed and not lost is computed again: with what came before each kill.
    const pid_t again = child([&] { replays(user_file); });
    waitpid(again, &status, 0);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
    fs::remove(user_file);
    for (const auto& entry : fs::directory_iterator(folder))
        EXPECT_TRUE(entry.path() == folder / "state" || entry.path() == folder / "ball.json")
            << entry.path();
}

TEST_F(SessionKill, OfOthersLeavesTheMemoryOfASessionFlat)
{
    const char* const given = std::getenv("KNEAD_SECONDS");
    const double seconds = given ? std::atof(given) : std::getenv("KNEAD_LONG") ? 1800 : 6;
    const pid_t stays = child([&] { stay(sanitized ? 1 : seconds); });
    for (int waited = 0; !progress->ready && waited < 60000; ++waited)
        std::this_thread::sleep_for(1ms);
    std::mt19937 random(7);
    int status = 0, kills = 0;
    while (waitpid(stays, &status, WNOHANG) == 0) {
        const std::vector<Recoverable> list = recoverable_sessions();
        const std::string log = kills % 5 != 0 && !list.empty() ? list[0].file : "";
        if (log.empty())
            for (const Recoverable& old : list) delete_log(old.file);
        const auto seed = unsigned(random());
        const pid_t other = child([&] { work(log, seed, 60); });
        std::this_thread::sleep_for(std::chrono::milliseconds(100 + random() % 1500));
        kill(other, SIGKILL);
        int killed = 0;
        waitpid(other, &killed, 0);
        ASSERT_TRUE(WIFSIGNALED(killed) && WTERMSIG(killed) == SIGKILL) << killed;
        ++kills;
    }
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
    EXPECT_GT(kills, 1);
    std::printf("%d kills meanwhile\n", kills);
}

TEST_F(SessionKill, ALogInUseIsRefusedWithItsProcess)
{
    const pid_t process = child([&] { work("", 1, 60); });
    ASSERT_GT(process, 0);
    for (int waited = 0; !progress->ready && waited < 60000; ++waited)
        std::this_thread::sleep_for(1ms);
    ASSERT_TRUE(progress->ready);
    const std::string log = progress->log, holder = "process " + std::to_string(process);
    EXPECT_TRUE(recoverable_sessions().empty());
    const auto names = [&](const auto& action) {
        const std::string why = reason<OutputError>(action);
        EXPECT_NE(why.find(holder), std::string::npos) << why;
    };
    for (int waited = 0; waited < 10000; ++waited) {  // until it has a session's beginning
        try {
            if (SessionFile(log).steps() > 1) break;
        } catch (const InputError&) {
        }
        std::this_thread::sleep_for(1ms);
    }
    names([&] { session_to_continue(log); });
    names([&] { SessionWriter{SessionFile(log)}; });
    names([&] { delete_log(log); });
    names([&] {
        LiveOptions by = options();
        by.session = log;
        LiveSession(nullptr, by).wait_until_open();
    });
    EXPECT_EQ(waitpid(process, nullptr, WNOHANG), 0);
    kill(process, SIGKILL);
    waitpid(process, nullptr, 0);
    EXPECT_EQ(recoverable_sessions().size(), 1u);
    session_to_continue(log);
}

}  // namespace
}  // namespace knead
