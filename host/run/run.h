// `knead run`: the session loop, watched by what keeps a row of every frame, audits the state, and
// makes surfaces.
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
    int frames = 0;           // 0: as the scene says
    int audit_every = 1;      // frames from audit to audit; the first and the last always are
    int mesh_every = 0;       // frames from mesh to mesh; 0: none
    bool last_mesh = false;   // a mesh of the last frame
    int meshes_every = 0;     // frames from one to the next that `meshes` of RunWatch is told of
    int particles_every = 0;  // the same of `particles`
    double time_limit = 0;    // wall time after which it ends [s]; 0: none
    double checkpoint = 0;    // wall time from checkpoint to checkpoint [s]
};

struct FrameRow : PagingReport {
    int frame = 0;
    double simulated = 0;                     // since the start, at the frame's end [s]
    double hand_time = 0;                     // of the recording, at the frame's end [s]
    bool hands = false;                       // any hand was active
    double wall = 0;                          // of the solver [s]
    double hands_wall = 0, surface_wall = 0;  // [s]
    FrameStats stats;
    bool audited = false;  // what follows is filled in
    Audit state;
    Crowding crowding;
    Depths left;
    Depths between;  // of these, what two tools hold between them
    std::vector<StageTime> stages;
    bool meshed = false;
    bool kept = false;       // no clay had moved since the last meshes: these are the same
    double mesh_volume = 0;  // [m^3]
    long triangles = 0;
};

struct RunRecord {
    std::vector<FrameRow> rows;
    Audit first;                    // before the first frame
    double first_mesh_volume = -1;  // [m^3]; negative: not meshed
    DepthCount depths;              // that audits found
    Depths left;                    // the same over all audited frames; p99 to 10 micrometres
    std::size_t particles = 0, bytes = 0;
    int frames_wanted = 0;
    double duration = 0;  // simulated per frame [s]
    double wall = 0;      // of the whole loop [s]
    End end = End::complete;
    std::string trouble;  // of End::numbers and End::device: what, when
    State last_good;      // of the last audit that found nothing wrong
    Meshes meshes;        // the last that were made; null: none
    // Pictures that could not be made since the run began, or went on; why not the first of them.
    int pictures_missing = 0;
    std::string no_picture;
};

struct RunWatch {
    std::function<void(const FrameRow&)> frame;  // after every frame
    // Before each frame: may hand the loop edits, after the frame of that number.
    std::function<void(int number, SessionLoop&)> edits;
    MotionSource motion;  // of the tools, in place of the hands' own
    // Between substeps: where the frame of that number stands.
    std::function<void(int number, const FramePart&)> part;
    // After every whole frame of a sound state, before it is shown or kept: may edit the solver's
    // Gaussians, and add or remove clay, which it reports.
    std::function<PagingReport(const Frame&)> upkeep;
    // After every frame that was meshed by mesh_every. A PictureError is counted and said once.
    std::function<void(const Frame&, const std::vector<Mesh>&)> picture;
    // After every frame of meshes_every and particles_every, in the frame of the scene's file.
    std::function<void(int number, const std::vector<Mesh>&)> meshes;
    std::function<void(int number, const std::vector<Particle<double>>&)> particles;
    // Between frames, when it is due, and at the end where the run was stopped: what it has so far,
    // without a frame that was cut short. With the solver's state that is all that a later run
    // needs to go on.
    std::function<void(const RunRecord&)> checkpoint;
    std::function<bool()> stop;  // asked before every frame, beside interrupts
};

// Frames the scene asks for: its own number, or as long as the hands move, or one second.
int frames_wanted(const Scene& scene, const HandSource* hands, int asked);

// Advances `solver`, made of scene.setup, frame by frame. `hands` may be null. With what an earlier
// run had at a checkpoint, and the solver in its state then, it goes on from there.
RunRecord run_frames(const Scene& scene, Solver& solver, const HandSource* hands,
                     const BatchRunOptions& options, const RunWatch& watch,
                     const RunRecord* earlier = nullptr);

// Of all particle-substeps those in which clay moved; 1 for a run of none.
double moved_share(const RunRecord& record);

// What the run does not compute, because the scene, or the command line, does not ask for it.
std::vector<std::string> left_out(const Scene& scene, const BatchRunOptions& options);
// The same of what clay at rest spared, known only when the run is over: its own motion, and meshes
// of frames in which nothing moved. Nothing where all moved.
std::vector<std::string> left_at_rest(const RunRecord& record);

}  // namespace knead
