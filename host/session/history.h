// The past of a session: steps, and the differences of clay between them. Data only: no simulator,
// no clock, no threads. docs/method/history.md.
#pragma once
#include <cstddef>
#include <cstdint>
#include <exception>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/document/document.h"
#include "host/session/capture.h"
#include "host/session/session_event.h"
#include "host/solver/setup.h"
#include "host/splats/carried.h"

namespace knead {

// What the editor knows of the objects in the simulator.
struct ObjectNumbers {
    // In the simulator; several of an object that was merged of others.
    std::map<ObjectId, std::vector<int>> number;
    std::vector<Material<double>> materials;  // by number; of a removed object: all zero
};

// How the particles of a step differ from those of its parent: what the history keeps of them.
struct ClayEdge {
    // difference() from the parent's rows; where the members differ, encoded() rows of both.
    std::string from_parent, parent_whole, whole;
    std::size_t bytes() const { return from_parent.size() + parent_whole.size() + whole.size(); }
};
// Particles of a step, made on another thread. The history drops the rows when they are no longer
// those of the current step.
struct Capture {
    std::shared_ptr<const ClayRows> rows;
    std::uint64_t hash = 0;  // of the rows
    std::shared_ptr<const ClayEdge> edge;
    std::shared_ptr<const Quantisation> steps;  // null: lossless
    std::size_t bytes() const { return edge ? edge->bytes() : 0; }
};
// Slow; for any thread. `parent`: rows of the parent. `steps`: those of rows that are quantised();
// null: the lossless codec.
Capture capture_of(const ClayRows& parent, std::shared_ptr<const ClayRows> rows,
                   std::shared_ptr<const Quantisation> steps = nullptr);
using FutureCapture = std::shared_future<Capture>;

// Rows that are known, or will be by a capture. For any thread.
struct LaterRows {
    std::shared_ptr<const ClayRows> rows;  // or
    FutureCapture made;
    std::exception_ptr failure;                   // of a capture that is over
    bool ready() const;                           // get() does not wait
    std::shared_ptr<const ClayRows> get() const;  // throws what the capture threw
};

// Bytes of the splats in memory.
std::size_t bytes_of(const CarriedSplats& splats);

struct HistoryStep {
    StepId id = 0, parent = 0;  // the beginning, 0, is its own parent
    std::string label;          // of the change that led to it
    long frame = 0;             // frames of the session before its particles were captured
    DocumentPtr document;
    std::shared_ptr<const ObjectNumbers> objects;
    std::shared_ptr<const CarriedSplats> splats;  // null: the scene has none
    // With velocities, of a step at the beginning of a scene; null: of no other.
    std::shared_ptr<const InitialState> beginning;
    bool captured = false;  // its particles are known, or will be; false: of the current step only
};

// A row of the list that panels show.
struct StepInfo {
    StepId id = 0, parent = 0;
    std::string label;
    std::size_t bytes = 0;  // of its difference from its parent; 0: none, or not taken by evict()
    bool current = false;
    bool on_line = false;  // on the line from the beginning over the current step to the newest
};

// Of report.json.
struct HistoryInfo {
    std::size_t steps = 0, bytes = 0;  // that can be gone to; of memory
    StepId current = 0;
};

// How the particles of captured steps are encoded. `automatic`: lossless up to
// most_lossless_particles, quantised above.
enum class Codec { automatic, lossless, quantised };
constexpr std::size_t most_lossless_particles = 100000;

class History {
  public:
    // Of the line, beside the current step; evict() keeps these nearest ones whatever the budget.
    static constexpr std::size_t fewest_steps = 8;
    static constexpr std::size_t most_steps = 10000;  // more are evicted
    // `most_bytes`: of all differences and splats in memory.
    explicit History(std::size_t most_bytes = std::size_t(256) << 20) : budget(most_bytes) {}

    // The first step, id 0, with its particles; or the step of a session that goes on. Removes all
    // others.
    void begin(HistoryStep first, std::shared_ptr<const ClayRows> rows);
    // Adds a captured step behind one that exists, as files have them; the current step stays.
    // `made`: without an edge if its particles are its parent's; its rows are not used. Throws
    // std::invalid_argument for ids that do not rise, and a parent that does not exist or is open.
    void insert(HistoryStep step, Capture made);
    // Ids up to this one are not given again.
    void use_ids(StepId most) { last = most > last ? most : last; }

    // A new step after the current one becomes the current one; it has no particles yet. Returns
    // its id, which was never used. Throws std::logic_error if the current step is not captured.
    StepId open(std::string label, DocumentPtr document,
                std::shared_ptr<const ObjectNumbers> objects);
    // The three below throw std::logic_error unless the current step is open.
    // Changes the current step.
    void update(DocumentPtr document, std::shared_ptr<const ObjectNumbers> objects);
    // The current step is captured: as its parent is (no clay has changed, nor have splats), or by
    // `made`, which is capture_of() of resident() and other rows.
    void capture_unchanged(long frame);
    void capture(FutureCapture made, std::shared_ptr<const CarriedSplats> splats, long frame);

    const HistoryStep& current() const { return steps.at(at); }
    const HistoryStep* find(StepId id) const;  // null: there is none, or it was evicted
    std::optional<StepId> undo() const;  // the parent; none: at the beginning, or it was evicted
    std::optional<StepId> redo() const;  // the child on the line; none: at its end
    // Rows of a captured step: waits for captures on the way from the current one. Throws
    // std::invalid_argument for a step that does not exist, was evicted or is open, and what a
    // capture threw: the steps behind that one are lost, all others are not.
    std::shared_ptr<const ClayRows> rows_of(StepId id) const;
    // Whether no step on the way between these, both captured, has changed clay or splats.
    bool same_clay(StepId one, StepId other) const;
    // Makes a captured step, whose rows are these, the current one. Throws std::logic_error if the
    // current step is open, and std::invalid_argument as rows_of() does.
    void go_to(StepId id, std::shared_ptr<const ClayRows> rows);
    // Rows of the current step if it is captured, else of its parent. The first may wait for a
    // capture, and throws what it threw.
    std::shared_ptr<const ClayRows> resident() const { return resident_later().get(); }
    bool resident_ready() const { return resident_later().ready(); }
    LaterRows resident_later() const;

    // Call now and then, at least after captures: takes what captures have made, and evicts steps
    // beyond the budget. Other branches go first, the oldest first, each from its end; then the far
    // end of redo, then the oldest of undo. Never waits: steps whose captures are not ready stay.
    void evict();

    std::vector<StepInfo> list() const;       // by id
    long version() const { return changes; }  // of list(): rises when it changes
    std::size_t count() const { return steps.size(); }
    // In memory, without the rows of the current step and of another: as evict() has found it, and
    // kept.
    std::size_t bytes() const { return sum; }

  private:
    // At most one of them; none: unchanged.
    struct Edge {
        FutureCapture made;  // until evict() finds it ready
        std::shared_ptr<const ClayEdge> clay;
        std::exception_ptr failure;  // what the capture threw
    };

    struct Move {
        const Edge* edge;
        bool forward;
    };

    static const ClayEdge* clay_of(const Edge& edge);
    std::vector<Move> moves(StepId from, StepId to) const;
    static std::shared_ptr<const ClayRows> moved(std::shared_ptr<const ClayRows> from,
                                                 const std::vector<Move>& moves);
    HistoryStep& opened(const char* action);
    const HistoryStep& captured(StepId id) const;
    static bool take(Edge& edge);
    void take_captures();
    std::vector<StepId> way_to_root(StepId id) const;
    std::vector<StepId> line() const;
    std::optional<StepId> next_to_evict() const;
    void remove(StepId id);
    void keep_shared(const HistoryStep& step);
    void drop_shared(const HistoryStep& step);

    std::size_t budget;
    std::map<StepId, HistoryStep> steps;
    std::map<StepId, Edge> edges;     // by the step: from its parent; none of the oldest step
    std::map<StepId, StepId> newest;  // of a step: the child that was current last
    StepId at = 0, last = 0;          // the current step; the last id given
    // Rows of the current step, or of the step before it whose capture was ready last.
    StepId rows_at = 0;
    std::shared_ptr<const ClayRows> rows;
    // Rows of another step, so that undo and redo of the newest step decode nothing: of the parent
    // after a capture, else of the step that was left last. Null: there is none.
    StepId beside_at = 0;
    std::shared_ptr<const ClayRows> beside;
    std::vector<StepId> waiting;  // whose captures are not ready
    long changes = 0;
    std::size_t sum = 0;                        // of edges, splats and beginnings [bytes]
    std::map<const void*, std::size_t> shared;  // splats and beginnings: how many steps have them
};

}  // namespace knead
