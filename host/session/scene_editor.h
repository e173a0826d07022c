// The document of a running scene: the one way to change it. A command is reduced to a new document
// (host/document/reduce.h), and the difference of both documents becomes edits of the simulator, on
// the simulation's thread, between two frames, all or none. docs/method/document.md.
#pragma once
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/document/command_table.h"
#include "host/document/reduce.h"
#include "host/paging/scene_splats.h"
#include "host/session/history.h"
#include "host/session/loop.h"
#include "host/session/object_places.h"
#include "host/session/object_verbs.h"
#include "host/session/stored_state.h"

namespace knead {

// The clay of a new object: what a difference of documents needs besides the documents.
struct PreparedObject {
    Material<double> material{};              // softened, with mass and volume of a particle
    std::vector<Particle<double>> particles;  // in the simulation's frame
    std::optional<SplatObject> splats;        // of an object of splats
    bool fitted = false;                      // leave_room() was called
};
// As build() makes it. Slow, and may be called on any thread. `walls`: in the simulation's frame.
// Throws InputError if the object holds no particles, std::invalid_argument for a material that
// would need too many substeps.
PreparedObject prepared(const Scene& scene, const WallOptions& walls, const SceneObject& object);
// The box of its particles and one spacing beside it, in the simulation's frame.
Box3<double> surroundings(const PreparedObject& clay);
// Removes the particles nearer than 3/4 of a spacing to the positions `there`, which are those of
// other clay within surroundings(). Throws std::invalid_argument if none is left.
void leave_room(PreparedObject& clay, const std::vector<Vec3<double>>& there);

// What the last nozzle has laid.
struct SourceReport {
    ObjectId object;              // 0: there was none
    long laid = 0, left_out = 0;  // particles so far; those in other clay or beyond a wall
    // The last move that was long enough to lay clay has laid none.
    bool clogged = false;
};

class SceneEditor {
  public:
    // What the editor acts on. All must outlive it.
    struct Parts {
        const Scene& scene;  // built
        SceneSplats& splats;
        SessionLoop& loop;
        EditableSimulator* simulator;  // null: not editable
        // Replaces the tools and the hands' motion, all or nothing; after the edit of the clay.
        std::function<void(const HandsOptions&)> set_hands;
        std::function<void(int nodes)> set_surface;  // all or nothing; null: not here
    };
    // `document`: of the parts' scene, whose objects are the simulator's 0, 1, 2, ... `ids`: of the
    // session.
    SceneEditor(Parts parts, DocumentPtr document, IdSource& ids);
    SceneEditor(const SceneEditor&) = delete;

    // Applies a command of the document, or Carry; the caller applies other commands of the session
    // and asks for their availability by situation(). A command that is refused has changed
    // nothing. Precondition: no frame in flight.
    // `ready`: of the object that AddObject adds, if it is prepared already; moved from.
    CommandAnswer apply(const Command& command, PreparedObject* ready = nullptr);
    // Moves a body of a recording of an older format.
    std::optional<Refusal> move(ObjectId object, const RigidMotion<double>& motion);
    // Edits the simulator so that it matches the document `to`, then replaces document(). Throws
    // what the simulator throws. Strong guarantee.
    void synchronise(const DocumentPtr& to, PreparedObject* ready = nullptr);

    // Why reduce() would refuse it.
    std::optional<Refusal> refusal_of(const Command& command) const;
    // What a step of the history keeps of the objects in the simulator.
    ObjectNumbers numbers() const;
    // Replaces clay and document by those of a step: its particles as `clay`, or as `beginning` if
    // not null. The settings of hands and surface stay. Throws what the simulator throws; strong
    // guarantee. Precondition: no local clay; no frame in flight.
    void restore(const HistoryStep& step, const ClayRows& clay);
    // The same of a step whose clay is the current one: only the document changes.
    void restore_document(const HistoryStep& step);
    // The state now, for load(), but for the simulator's, frames and time.
    StoredState stored() const;
    // Replaces everything by a state that was stored. Throws std::invalid_argument; strong
    // guarantee. Precondition: no frame in flight.
    void load(const StoredState& state);

    // Call after each frame: moves what is carried with the palm that carries it.
    void after_frame(const FrameResult& frame);

    const DocumentPtr& document() const { return now; }
    // `live`: see Situation. Of steps and log it says that there are none:
    // SceneHistory::situation().
    Situation situation(bool live) const;
    bool carries() const { return !carried.empty(); }
    // Numbers of the object in the simulator, several if it was merged; of local clay, that of its
    // own object, not of its cubes. Precondition: the document has the object.
    const std::vector<int>& simulated(ObjectId object) const { return objects.at(object); }
    // Of the clay now. Slow: reads all particles. Precondition: no frame in flight.
    ObjectPlaces places() const;
    const SourceReport& source() const { return sourced; }
    long edits() const { return count; }            // so far
    long clay_edits() const { return clay_count; }  // that moved, added or removed clay

  private:
    struct Carried {
        ObjectId object;
        Side side;
        // At the ends of the last frame that moved the object, and of the last frame.
        std::optional<Joint<double>> palm, seen;
    };

    // What a command that reads_clay() does to the simulator.
    struct ClayEdit {
        struct NewPart {
            ObjectId object;
            PartClay clay;
        };
        // A Gaussian after the edit, `scale` times as large as the splat of the Gaussian `from`
        // before it. `part`: index into `added`, of its object; negative: its object stays.
        struct NewGaussian {
            Gaussian<double> gaussian;
            std::size_t from = 0;
            int part = -1;
            double scale = 1;
        };
        std::vector<int> gone;
        std::vector<NewPart> added;
        std::vector<int> moved;
        RigidMotion<double> motion{{1, 0, 0, 0}, {0, 0, 0}};      // of those
        std::vector<std::pair<int, Material<double>>> materials;  // to be set
        std::map<ObjectId, std::vector<int>> objects;             // without those of `added`
        Vec3<double> gravity{};
        bool splats = false;                 // they change
        long laid = 0, left_out = 0;         // of a nozzle
        std::vector<NewGaussian> gaussians;  // all, if they do
    };

    std::optional<Refusal> carry(const Carry& command);
    CommandAnswer reshape(const Command& command);
    ClayEdit unchanged(const SnapshotData& all) const;
    ClayEdit edit_of(CopyObjects& command) const;
    ClayEdit edit_of(MoveObjects& command) const;
    ClayEdit edit_of(ResetObjects& command) const;
    ClayEdit edit_of(ScaleObjects& command) const;
    ClayEdit edit_of(MergeObjects& command) const;
    ClayEdit edit_of(SplitObject& command) const;
    void give_categories(SplitObject& command, ObjectId id) const;
    ClayEdit edit_of(SourceBegin& command) const;
    ClayEdit edit_of(SourceMove& command, const Document& to) const;
    ClayEdit edit_of(SourceEnd& command, const Document& to) const;
    void make(ClayEdit edit);
    void replace_splats(const ClayEdit& edit, const std::vector<int>& numbers,
                        const CarriedSplats& before);
    std::vector<PartClay> clay_of(const SnapshotData& all, const std::vector<int>& numbers) const;
    void check_place(const std::vector<PartClay>& clay, const char* field) const;
    void check_free(const std::vector<PartClay>& clay, const std::vector<Particle<double>>& there,
                    const char* field, const std::vector<PartClay>* before = nullptr) const;
    using NewClay = std::map<ObjectId, PreparedObject>;
    NewClay new_clay(const Document& to, PreparedObject* ready) const;
    void check(const Document& to) const;
    void make(const Document& to, NewClay& added);
    void make_surroundings(const Document& to);
    WallOptions walls_of(const Document& document) const;
    bool local(ObjectId object) const;
    RigidMotion<double> in_simulation(const RigidMotion<double>& pose) const;
    Document document_of_step(const HistoryStep& step) const;
    Vec3<double> gravity_of(const Document& document) const;

    const Parts parts;
    DocumentPtr now;
    const DocumentPtr first;
    IdSource& ids;
    std::map<ObjectId, std::vector<int>> objects;  // of the simulator
    std::vector<Carried> carried;
    bool shaped = false;  // hands have pressed clay
    SourceReport sourced;
    long count = 0, clay_count = 0;
};

}  // namespace knead
