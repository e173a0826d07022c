// Commands of a run: those of --commands, and those recorded beside the hands that it plays.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/cli/run_session.h"
#include "host/run/run.h"
#include "host/session/command_replay.h"

namespace knead {

struct RunOptions;
using Note = std::function<void(const std::string&)>;

class RunScript {
  public:
    // Reads the log of `options`, if any. Unless the log is of a recording, applies its commands of
    // the document of frame 0 to `scene`, which is not built yet: see scene_of(). Throws InputError
    // for a bad line and, unless `options.keep_going`, for a refusal of these commands.
    RunScript(const RunOptions& options, Scene& scene, const Note& note);

    // The commands or actions recorded with the scene's hands. Throws InputError for an invalid
    // file, or one of another recording.
    void add_recorded(const Scene& scene, const Recording& recording);

    bool any() const { return !log.empty() || given || watches; }
    const std::string& recorded_file() const { return beside; }  // "": none

    // Applies the log in the run that `watch` observes, of `frames` frames, with the motion of
    // `played`, which may be null. After the last frame, commands are applied up to the first that
    // may change clay. The arguments must outlive it.
    void play(const Scene& scene, SceneSplats& splats, Simulator& solver, const HandSource* played,
              int frames, RunObserver& watch);
    // Of a run with --commands.
    std::optional<HistoryInfo> history() const
    {
        return session ? std::optional(session->info()) : std::nullopt;
    }
    // Why a session was not saved; "": it was, or should not be.
    std::string problem() const { return session ? session->problem() : ""; }

    const Document& document() const { return editor ? *editor->document() : *first; }
    // Of the objects, if commands were given; reads the clay, between frames only.
    std::optional<ObjectPlaces> places() const
    {
        return editor ? std::optional(editor->places()) : std::nullopt;
    }
    std::size_t left() const { return replay ? replay->left() : 0; }  // commands not reached
    // Numbers of the object in the simulator. Precondition: the document has the object.
    std::vector<int> simulated(ObjectId object) const;

  private:
    void begin(Scene& scene);
    void after_frame(int number, SessionLoop& loop);
    void after_last_frame(int number, SessionLoop& loop);
    void play_entries(int number, SessionLoop& loop,
                      const std::function<bool(const LogEntry&)>& may);
    std::optional<Refusal> apply(const Command& command);
    void refuse(const std::string& place, const Command& command, const Refusal& refusal,
                SessionLoop* loop);

    const bool given, keep_going;  // a log was given
    const Note note;
    std::string file, beside;
    std::vector<LogEntry> log;
    DocumentPtr first;  // before the first frame
    IdSource ids;
    const bool watches;                    // pieces become objects
    std::unique_ptr<RecordedHands> hands;  // null: nothing was recorded beside the hands
    std::unique_ptr<CommandReplay> replay;
    std::optional<Recording> recording;  // of the hands that are played
    std::vector<RunSession::Beginning> beginnings;
    std::unique_ptr<SceneEditor> editor;
    std::unique_ptr<RunSession> session;  // with --commands, or where pieces become objects
    int frames_before = 0;
};

// For a scene without hands: applies the first set_hands among the entries of frame 0 that were
// recorded beside `recording`. Returns false if there is none or it is refused.
bool begin_with_hands(Scene& scene, const std::string& recording);

}  // namespace knead
