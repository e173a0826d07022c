// The working log of a session: chunks are queued here and written by a thread of its own, with a
// commit in less than a second, so that the simulation never waits for a disk.
// docs/method/history.md.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/files/chunk_file.h"

namespace knead {

struct JournalState {
    std::string file;
    std::uint64_t committed = 0;  // bytes
    std::size_t waiting = 0;      // bytes queued or being written; 0: all so far is committed
    // Chunks that are not in the file: the queue was full, or their `make` threw. Chunks that
    // depend on them are of no use.
    long dropped = 0;
    std::string trouble;  // why nothing is written at present; "": it is
};

// After a failure to write, the group that failed is kept and written again from the last commit:
// after 0.25 s, then after pauses that double up to 8 s, until the disk takes it.
class Journal {
  public:
    // What may be dropped when the queue is full, in this order; `no`: it is kept. Of states the
    // oldest are dropped first, a later one serves as well; of differences the newest, because
    // later ones build on earlier ones.
    enum class Drop { state, difference, no };
    struct Options {
        // [s]; sooner where a quarter of longest_queue waits. With what SessionWriter holds back
        // and the time to write, less than 1 s.
        double commit_every = 0.5;
        // Without what is being written [bytes]. A single chunk that is larger waits all the same.
        std::size_t longest_queue = std::size_t(64) << 20;
    };
    // A new log, which must not exist, or one to go on with. Locks it. Throws OutputError: of a
    // locked one with the process that holds it.
    Journal(const std::string& file, Options options);
    Journal(const ChunkFile& onto, Options options);
    // Commits what waits, for at most 2 s if there is trouble. Ends the saves that were asked for.
    ~Journal();
    Journal(const Journal&) = delete;

    // Thread-safe, and never waits for the disk. `make` is called on the journal's thread; `bytes`:
    // memory that it holds.
    void add(Chunk chunk, Drop drop = Drop::no);
    void add(std::function<Chunk()> make, std::size_t bytes, Drop drop = Drop::no);
    // Commits all so far, waits for it. False: there is trouble (state().trouble). Not for
    // functions that the journal calls.
    bool flush();
    // Commits all so far and copies the log into a user's file, atomically, with `more` as a last
    // group there; then `written` (with "", or why not) is called. Both are called on the journal's
    // thread, must not throw, and may add(). Frames go on, and so do commits. While there is
    // trouble with the log, the file gets what waits as well. `keep`: which chunks of the log are
    // copied; null: all. A save that waits for its turn is done by a later one of the same file:
    // each holds a state, and a slow disk must not gather them.
    void save(const std::string& to, std::function<std::vector<Chunk>()> more,
              std::function<void(const std::string& why_not)> written,
              std::function<bool(const ChunkHead&)> keep = {});
    JournalState state() const;
    // Deletes the log when the journal ends: nothing in it is missed.
    void discard();

  private:
    struct Work;
    std::unique_ptr<Work> work;
};

}  // namespace knead
