// Commands of a run: those of --commands, and those recorded beside the hands that it plays.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

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

    bool any() const { return !log.empty() || given; }
    const std::string& recorded_file() const { return beside; }  // "": none

    // Applies the log in the run that `watch` observes. `scene`, `splats` and `solver` must outlive
    // it.
    void play(const Scene& scene, SceneSplats& splats, Simulator& solver, RunObserver& watch);

    const Document& document() const { return editor ? *editor->document() : *first; }
    std::size_t left() const { return replay ? replay->left() : 0; }  // commands not reached
    // Number of the object in the simulator. Precondition: the document has the object.
    int simulated(ObjectId object) const;

  private:
    void begin(Scene& scene);
    void refuse(const std::string& place, const Command& command, const Refusal& refusal,
                SessionLoop* loop);

    const bool given, keep_going;  // a log was given
    const Note note;
    std::string file, beside;
    std::vector<LogEntry> log;
    DocumentPtr first;  // before the first frame
    IdSource ids;
    std::unique_ptr<RecordedHands> hands;  // null: nothing was recorded beside the hands
    std::unique_ptr<CommandReplay> replay;
    std::unique_ptr<SceneEditor> editor;
};

// For a scene without hands: applies the first set_hands among the entries of frame 0 that were
// recorded beside `recording`. Returns false if there is none or it is refused.
bool begin_with_hands(Scene& scene, const std::string& recording);

}  // namespace knead
