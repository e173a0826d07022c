// Sessions as files: what the kinds of chunks hold, writing them to the working log, and reading
// them. Layout: docs/reference/formats.md.
#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "host/files/chunk_file.h"
#include "host/session/history.h"
#include "host/session/journal.h"
#include "host/session/session_event.h"
#include "host/session/stored_state.h"

namespace knead {

struct SessionMeta {
    std::string session;         // a UUID
    std::string program;         // version that began it
    std::string begun;           // UTC, as 2026-01-31T12:00:00Z
    std::string device;          // name of the simulator
    bool deterministic = false;  // equal runs give equal bits
    bool stepped = false;        // not in real time
};
struct SceneSource {
    std::string path, text;  // of the file
    std::vector<std::string> settings;
};
// A new session of now.
SessionMeta new_session();
// As a file has them first.
Chunk chunk_of(const SessionMeta& meta);
Chunk chunk_of(const SceneSource& scene);

// Where working logs are: $XDG_STATE_HOME/knead, else $HOME/.local/state/knead, else a folder of
// the user in the folder for temporary files. Created if missing. Throws OutputError.
std::string log_folder();
constexpr const char* log_ending = ".log";
constexpr const char* session_ending = ".knead";

constexpr ChunkKind state_kind("STAT");
// Of a checkpoint (host/run/checkpoint.h), which is a session: what a run needs beside the state
// whose id is the chunk's parent, to go on. The last chunk, or the file is no checkpoint any more.
// Ancillary.
constexpr ChunkKind run_record_kind("RUNR");

// Why a session is not saved under that name.
std::optional<Refusal> refusal_of(const Save& command);

class SessionWriter {
  public:
    // A new working log. Throws OutputError.
    SessionWriter(const SessionMeta& meta, const SceneSource& scene,
                  const Journal::Options& options = {});
    // Goes on with the log of a session that was not ended. Throws OutputError: of a log that is
    // in use, with the process that uses it.
    explicit SessionWriter(const class SessionFile& onto, const Journal::Options& options = {});
    ~SessionWriter();
    SessionWriter(const SessionWriter&) = delete;

    // None of these waits for a disk or for a capture.
    void add(const SessionEvent& event);
    void add_hands(const HandFrame& frame);
    // A captured step; `made` is not valid if it is unchanged.
    void add_step(const HistoryStep& step, const FutureCapture& made);
    // The first step, with its particles.
    void add_beginning(const HistoryStep& step, std::shared_ptr<const ClayRows> rows);
    // Returns the id for RunBegun. `make` is called on another thread.
    std::uint64_t add_state(std::function<StoredState()> make, std::size_t bytes);
    void set_picture(std::string png);  // the next group has it
    // Call once a frame: hands over what is older than 0.2 s.
    void poll();

    // Writes all so far to a user's file, atomically, as one that begins with a state: `make` as
    // for add_state(). `written` is called on another thread with "" or the reason why not.
    // `step`: the current one.
    void save(const std::string& to, bool input, StepId step, std::function<StoredState()> make,
              std::function<void(const std::string& why_not)> written);
    JournalState state() const { return journal->state(); }
    bool changed() const { return steps > *saved_steps; }  // steps since the last that was written
    void discard() { journal->discard(); }

  private:
    void hand_over();

    std::unique_ptr<Journal> journal;
    EventWriter events, hands;
    std::uint64_t last_state = 0, last_splats = 0;
    std::shared_ptr<const CarriedSplats> splats_written;
    long steps = 0, steps_since_key = 0;
    // In the last save that was written. Shared with the journal's thread.
    const std::shared_ptr<std::atomic<long>> saved_steps = std::make_shared<std::atomic<long>>(0);
    double handed = 0;  // when hand_over() was called, wall time [s]
};

// A session as read. Throws InputError for a file that is no session or is damaged.
class SessionFile {
  public:
    explicit SessionFile(const std::string& file);

    const ChunkFile& chunks() const { return file; }
    const SessionMeta& meta() const { return of; }
    const SceneSource& scene() const { return source; }
    std::string read_only() const { return unknown; }      // why it cannot be gone on with; ""
    const std::string& saved_as() const { return saved; }  // of a log: file of its last save, or ""
    // The step that was current last, of those that are in the file.
    StepId current() const { return at; }
    std::uint32_t object_ids() const { return most_object_id; }  // the highest id in its commands
    // The state at its end, if nothing has happened since it was saved; 0: there is none.
    std::uint64_t final_state() const { return at_state; }
    bool ended() const { return is_ended; }  // saved since its last step
    // If the session is a checkpoint, its chunk of run_record_kind; else null.
    const ChunkHead* run_record() const;

    // Calls visit(event) for all events in order, until it returns false.
    void each_event(const std::function<bool(const SessionEvent&)>& visit) const;
    std::vector<HandFrame> hands() const;
    // The same as a recording that begins with the first. Throws InputError if there are none.
    Recording recording() const;
    // Stored states by id, in order.
    std::vector<std::uint64_t> states() const;
    StoredState state(std::uint64_t id) const;
    std::string picture() const;  // the last, a PNG; "": none
    // All steps. The current one is `current`; if that has no particles, the step before it by id.
    // Slow.
    void read_history(History& into, StepId current) const;
    // Particles at the end, in the simulation's frame, and the materials of their objects: of the
    // last state, or at rest of the current step. Throws InputError if there are none.
    struct Clay {
        std::vector<Particle<double>> particles;
        std::vector<Material<double>> materials;
        DocumentPtr document;
    };
    Clay clay() const;
    long frames() const;  // events of frames
    long steps() const;

  private:
    void follow_events(const std::set<StepId>& stored, const ChunkHead* last_saved);
    struct StoredStep;
    StoredStep step_in(const ChunkHead& head) const;

    ChunkFile file;
    SessionMeta of;
    SceneSource source;
    std::string unknown, saved;
    StepId at = 0, most_step_id = 0;
    std::uint32_t most_object_id = 0;
    std::uint64_t at_state = 0;
    bool is_ended = false;
};

// Writes the session into `to`, atomically, without what a replay needs: its events, the hands, and
// the states but for the last. It can be gone on with, and has all steps. Throws InputError,
// OutputError.
void compact_session(const SessionFile& from, const std::string& to);

// Checks all chunks, events, documents and the particles of all steps. Throws InputError for what
// is wrong. `stop`: polled; true: returns early.
void verify_session(const SessionFile& file, const std::function<bool()>& stop = {});

// Working logs of sessions that ended without being saved, the newest first.
struct Recoverable {
    std::string file, session, scene;
    double age = 0;  // since it was written last [s]
    long steps = 0;
    std::string picture;  // a PNG; "": none
};
std::vector<Recoverable> recoverable_sessions();

// Deletes a log. Throws OutputError if a process uses it.
void delete_log(const std::string& file);
// A session to go on with. Throws InputError also for one that can be read only, OutputError for a
// log that a process uses, with that process.
SessionFile session_to_continue(const std::string& file);

// Whether the file begins as a session does. Throws InputError for a checkpoint of version 6 or
// older, which is none.
bool is_session(const std::string& file);

// Whether the first bytes of a file, at least 16, are those of a checkpoint of version 6 or older.
bool begins_older_checkpoint(std::string_view start);

}  // namespace knead
