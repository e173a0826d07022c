// `knead run`: the frame loop with watchers that record a row per frame, audit the state and
// compute surfaces.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "host/paging/scene_splats.h"
#include "host/run/depths.h"
#include "host/session/loop.h"
#include "host/solver/audit.h"

namespace knead {

struct BatchRunOptions {
    int frames = 0;             // 0: frames of the scene
    int audit_every = 1;        // interval of audits [frames]; first and last are always audited
    int mesh_every = 0;         // interval of meshes [frames]; 0: none
    bool last_mesh = false;     // mesh of the last frame
    int meshes_every = 0;       // interval of calls of RunObserver::meshes [frames]; 0: none
    int particles_every = 0;    // interval of calls of RunObserver::particles [frames]; 0: none
    double time_limit = 0;      // wall time after which the run ends [s]; 0: none
    double checkpoint = 0;      // interval of checkpoints, wall time [s]
    bool whole_frames = false;  // limits and interrupts end the run between frames only
};

struct FrameRow : PagingReport {
    int frame = 0;
    double simulated = 0;                     // since the start, at the frame's end [s]
    double hand_time = 0;                     // of the recording, at the frame's end [s]
    bool hands = false;                       // any hand was active
    double wall = 0;                          // of the solver [s]
    double hands_wall = 0, surface_wall = 0;  // [s]
    FrameStats stats;
    bool audited = false;  // the next members are valid
    Audit state;
    Crowding crowding;
    Depths left;
    Depths between;  // of these, particles held between two tools
    std::vector<StageTime> stages;
    bool meshed = false;
    bool kept = false;       // no clay moved since the last meshes: these were reused
    double mesh_volume = 0;  // [m^3]
    long triangles = 0;
};

struct RunRecord {
    std::vector<FrameRow> rows;
    Audit first;                    // before the first frame
    double first_mesh_volume = -1;  // [m^3]; negative: not meshed
    DepthCount depths;              // of all audits
    Depths left;                    // summary of `depths`; p99 to 10 micrometres
    std::size_t particles = 0, bytes = 0;
    int frames_wanted = 0;
    double duration = 0;  // simulated per frame [s]
    double wall = 0;      // of the whole loop [s]
    End end = End::complete;
    std::string failure;        // message if it ended by a fault (numbers, device, substeps)
    SharedParticles last_good;  // of the last audit without a fault
    Meshes meshes;              // the last ones; null: none
    // Pictures that failed since the run began or was resumed, and the reason for the first.
    int pictures_missing = 0;
    std::string no_picture;
};

struct RunObserver {
    std::function<void(const FrameRow&)> frame;  // after every frame
    // Called between frames with the number of the last one; may queue edits in the loop.
    std::function<void(int number, SessionLoop&)> edits;
    MotionSource motion;  // of the tools; replaces that of the hands
    // Called between substeps with the progress of frame `number`.
    std::function<void(int number, const FrameProgress&)> on_progress;
    // Called after each complete frame with a sound state, before it is drawn or saved. May edit
    // the solver's Gaussians, and add or remove clay; returns what it changed.
    std::function<PagingReport(const FrameResult&)> upkeep;
    // Called after each frame meshed by mesh_every. May throw PictureError: each is counted, the
    // first is printed.
    std::function<void(const FrameResult&, const std::vector<Mesh>&)> picture;
    // Called at the intervals meshes_every and particles_every, in the scene file's coordinates.
    std::function<void(int number, const std::vector<Mesh>&)> meshes;
    std::function<void(int number, const std::vector<Particle<double>>&)> particles;
    // Called between frames when a checkpoint is due, and at the end of a stopped run, with the
    // record so far, without a frame that was cut short. Record and solver state suffice to resume.
    std::function<void(const RunRecord&)> checkpoint;
    std::function<bool()> stop;  // called before each frame; true stops the run, as an interrupt
};

// Number of frames: `requested` if positive, else the scene's, else the duration of the hands, else
// one second.
int frames_wanted(const Scene& scene, const HandSource* hands, int requested);

// Runs the scene. Precondition: `solver` was made of scene.setup. `hands` may be null. `earlier`:
// record of a checkpoint to resume from; the solver must be in the state saved with it.
RunRecord run_frames(const Scene& scene, Simulator& solver, const HandSource* hands,
                     const BatchRunOptions& options, const RunObserver& watch,
                     const RunRecord* earlier = nullptr);

// Share of particle-substeps in which clay was awake; 1 for an empty run.
double moved_share(const RunRecord& record);

// Texts on what the run does not compute, because scene or command line do not request it.
std::vector<std::string> left_out(const Scene& scene, const BatchRunOptions& options);
// The same for work saved by sleeping clay, known after the run: its motion, and meshes of frames
// without motion. Empty if all clay was awake.
std::vector<std::string> left_at_rest(const RunRecord& record);

}  // namespace knead
