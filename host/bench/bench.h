// knead bench: cases, measurement and results. docs/reference/benchmarks.md
#pragma once
#include <array>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cuda/mpm/particle.h"
#include "host/base/machine.h"
#include "host/bench/device.h"
#include "host/bench/figures.h"
#include "host/run/report.h"
#include "host/session/loop.h"

namespace knead {

struct BenchOptions {
    std::vector<std::string> suites;            // none: all
    std::string device = "auto";                // auto, cuda, cuda:N, cpu
    std::string out;                            // "": profiling/results/<device>
    std::string scene = "scenes/squeeze.json";  // path, or name of a bundled scene
    std::string data;  // folder of plot.py, peers.json, targets.json and peers/; "": figures_folder
    bool count = false;  // also read the device's hardware counters
    bool quick = false, peers = false, overwrite = false, json = false, quiet = false;
    int threads = 0;             // CPU; 0: all
    double case_limit = 0;       // [s] after which a case starts no frame; 0: 20, quick 4
    double max_memory = 0;       // host memory [MiB]; 0: free memory
    double max_particles = 5e7;  // of suite "scale"
};

// Hardware counters of a case, per particle; all 0: not counted.
struct Counted {
    std::vector<StageWork> stages;
    DeviceWork sum;
    double issue_share = 0;  // instruction rate over the issue rate of the multiprocessors
    double copy_share = 0;   // memory bandwidth over the bandwidth of the measured copy
};

// Splats drawn by a row, for both eyes; 0 pixels: none.
struct DrawTimes {
    int width = 0, height = 0;                            // pixels of an eye
    std::size_t moved = 0;                                // deformed splats
    std::size_t visible = 0, instances = 0, dropped = 0;  // of a GPU's picture (RasterStats)
    // PSNR of the worse eye, against the reference in the row's note [dB]; 0: not compared.
    double psnr = 0;
};

// One measured case. Times in seconds.
struct BenchRow {
    std::string suite, name;
    double at = 0;  // value of the quantity varied by the suite
    std::size_t particles = 0;
    Int3 nodes{};
    int frames = 0, repeats = 0;  // timed frames of all repeats
    int in_contact = 0;           // of those, frames with particles projected out of a hand
    double substeps = 0;          // median per frame
    Spread frame, substep;
    double between = 0;             // range of the repeats' medians over their median
    double surface = 0;             // median time per frame; 0: none made
    std::size_t bytes = 0;          // memory of the solver
    double min_bytes = 0;           // bytes moved at least, per particle and substep
    double copy_share = 0;          // min_bytes per second over the measured copy's rate
    std::vector<StageTime> stages;  // stages of one frame, or of the surface
    Counted counted;                // per particle and substep; per particle of a surface
    double moved = 1;               // fraction of particle-substeps simulated; the rest: still
    DrawTimes drawn;                // if it has pixels, `particles` counts splats
    FrameStats acted;               // of all timed frames
    long crowded = 0;               // crowded particles at the end of the first repeat
    std::string hash;               // state hash at the end of the first repeat
    int hashed_after = 0;           // frames until the hash, including warm-up
    std::string note;

    // Particle-substeps per second, without particles at rest.
    double rate() const
    {
        return substep.median > 0 ? moved * double(particles) / substep.median : 0;
    }
};

enum class Met { aim, must, missed, open };
Met met(const Target& target);
const char* met_name(Met met);

// Result of a peer, from its last output line, with the result of Knead for comparison.
struct PeerRow {
    std::string name, problem;  // problem: why there are no results; "": none
    double substep = 0;         // median [s]
    double ours = 0;            // Knead's median for the same scene [s]
    double apart = 0;           // largest difference of the clay's mean and extent at the end [m]
    nlohmann::json said;
};

// Mean and standard deviation of the particle positions, per axis [m].
using ProbePlaces = std::array<double, 6>;
// Scene and time limit of peers.
struct PeerOptions {
    int nodes = 64;                      // along each edge of the box of 1 m
    int frames = 240, warm_frames = 40;  // the first warm_frames are not timed
    double limit = 3600;                 // [s]
};
// Parses the last JSON line with a time in a peer's output `said`; false if missing or incomplete.
bool understood(const std::string& said, PeerRow& row, ProbePlaces& places);

struct BenchResult {
    std::vector<BenchRow> rows;
    std::vector<Target> targets;
    std::vector<PeerRow> peers;
    std::vector<std::string> left_out;
};

// How a case is run.
struct Drive {
    int frames = 0;  // 0: to the end of the recording
    // True: start at the first contact of both hands, minus the warm-up; false: at the start.
    bool from_contact = true;
    int warm_up = 3;      // frames that are not timed
    int repeats = 1;      // each with a new solver
    bool stages = false;  // measure the stages of a frame
    bool counts = true;   // read hardware counters, if BenchOptions::count
    int surfaces = 0;     // number of surfaces, spread over the frames
    double limit = 20;    // [s] for all repeats together; two frames are always timed
};

// All cases of one device. Cases of the same name are measured once.
class Bench {
  public:
    explicit Bench(const BenchOptions& options);

    // The scene of the options with its particles; `settings` as for --set.
    Scene scene(const std::vector<std::string>& settings) const;
    const BenchRow& measured(const std::string& name, const Scene& scene, const Drive& drive);
    // The plain squeeze at `cells` per metre, measured once and shared by the suites.
    const BenchRow& squeeze(int cells);
    // True if a case with these bytes per particle fits into host and device memory; reports it if
    // not.
    bool fits(const std::string& what, double particles, double host_bytes, double device_bytes);

    void add(BenchRow row);  // ignored if interrupted before any frame was timed
    // keep(), called by each new row, writes the results so far to this file, in case the program
    // is interrupted. Write errors are only reported.
    void keep_in(const std::string& file) { kept = file; }
    void keep() const;
    void say(const std::string& text) const;  // on stderr
    bool stopped() const;                     // by Ctrl-C
    // Calls `count` if BenchOptions::count is set, else returns nothing. After a failure it is not
    // called again; the reason is added to `left_out`.
    std::vector<StageWork> counted(const std::function<std::vector<StageWork>()>& count);

    const BenchOptions options;
    const Device device;
    const DeviceInfo facts;
    const Figures figures;
    BenchResult result;

  private:
    void examine(const Scene& scene, const HandSource* hands, int first, int frame,
                 const Drive& how, BenchRow& row);

    std::map<std::string, BenchRow> known;
    std::string kept;  // "": nowhere
    bool uncountable = false;
};

// Runs the scene from frame `first` of the hands until the recording ends, an interrupt occurs, or
// `after`, called after each frame, returns false. Rethrows exceptions of the solver.
void drive(const Scene& scene, Simulator& solver, const HandSource* hands, int first,
           const std::function<bool(const FrameResult&)>& after);
// The same with frames submitted one ahead, optionally with a surface each; surfaces made on the
// device are not waited for.
struct QueuedFrames {
    int frames = 0;
    double frame = 0;     // mean time from the end of one frame to the end of the next [s]
    double waits = 0;     // mean number of host waits per frame
    double substeps = 0;  // mean per frame
    std::vector<Gaussian<double>> gaussians;  // state after the last frame
};
QueuedFrames queued(const Scene& scene, Device device, const HandSource* hands, int first,
                    int frames, bool surfaces);
// The first frame at whose end every present hand penetrates the clay as seeded; -1: none.
int first_contact(const Scene& scene, const HandSource& hands);
// Minimum memory traffic per particle and substep [bytes]: its state read and written, and the
// nodes of active blocks written once and read once.
double min_bytes(std::size_t particles, long active_blocks);

// Counters divided by `items` (particle-substeps, or particles of a surface), with rates from the
// times of `row`.
Counted counted_each(const std::vector<StageWork>& stages, double items, const BenchRow& row,
                     const DeviceInfo& facts);

// Times of surfaces of one state by the scene's options, and of their stages [s].
struct SurfaceTimes {
    std::vector<double> whole;
    std::vector<StageTime> stages;
    std::size_t bytes = 0;  // device memory; 0: not counted
    std::string note;
};
SurfaceTimes surface_times(const std::vector<Particle<double>>& state, const Scene& scene,
                           Device device, int count);
// Hardware counters of such a surface; empty on a CPU.
std::vector<StageWork> surface_counts(const std::vector<Particle<double>>& state,
                                      const Scene& scene, Device device);
// Times of surfaces of `frames` consecutive frames after `warm_up` frames, with and without reuse
// of blocks that have not moved [s]. GPU only.
struct KeptTimes {
    std::vector<double> kept, whole;
    double anew = 0;        // mean fraction of the blocks with clay that are rebuilt
    std::size_t bytes = 0;  // device memory
};
KeptTimes kept_surface_times(const Scene& scene, Device device, int warm_up, int frames);

using Suite = void (*)(Bench&);
const std::vector<std::pair<std::string, Suite>>& suites();
void stages_suite(Bench&);
void paper_suite(Bench&);
void scale_suite(Bench&);
void surface_suite(Bench&);
void localized_suite(Bench&);
void deterministic_suite(Bench&);
void splats_suite(Bench&);
void undo_suite(Bench&);
void targets_suite(Bench&);
void run_peers(Bench&);
void run_peers(Bench&, const PeerOptions& options);

nlohmann::json bench_json(const Bench& bench);
std::string bench_csv(const BenchResult& result);
std::string bench_text(const Bench& bench);
// Current clock of the multiprocessors from the driver [1/s]; 0: unknown.
double gpu_clock();
// Draws figures of the results in file `json`, beside it. Returns "", or the reason for failure and
// how to draw them by hand.
std::string draw(const Bench& bench, const std::string& json);

int bench_verb(const BenchOptions& options);

// The squeeze's scene on another lattice, with walls 3 nodes inside it: the ball still rests on the
// floor.
std::vector<std::string> squeeze_on(int cells);
// Settings that put a scene's walls 3 nodes inside a cubic lattice over `edge` [m].
std::vector<std::string> walls_on_cells(double edge, int cells);

}  // namespace knead
