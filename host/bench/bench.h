// knead bench: what is measured, how, and what comes of it.  docs/reference/benchmarks.md
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
    std::string scene = "scenes/squeeze.json";  // here, or of those that come with the program
    std::string data;  // folder of plot.py, peers.json, targets.json and peers/; "": figures_folder
    bool count = false;  // by the device's counters, too
    bool quick = false, peers = false, overwrite = false, json = false, quiet = false;
    int threads = 0;             // CPU; 0: all
    double case_limit = 0;       // seconds after which a case begins no frame; 0: 20, quick 4
    double max_memory = 0;       // [MiB] of the host; 0: what is free
    double max_particles = 5e7;  // of suite "scale"
};

// What the device's counters say of a case, for each particle; all 0: nothing was counted.
struct Counted {
    std::vector<StageWork> stages;
    DeviceWork sum;
    double issue_share = 0;  // instructions over time, of what the multiprocessors can issue
    double copy_share = 0;   // bytes of the memory over time, of the measured copy's rate
};

// What a row drew of splats, for both eyes. No pixels: nothing.
struct Drawn {
    int width = 0, height = 0;  // pixels of an eye
    std::size_t moved = 0;      // splats that are turned and stretched, of all
    std::size_t visible = 0, instances = 0, dropped = 0;  // of a GPU's picture (RasterStats)
    double psnr = 0;  // of the worse eye, against what the row's note says [dB]; 0: not compared
};

// One measured case. Times in seconds.
struct BenchRow {
    std::string suite, name;
    double at = 0;  // the quantity its suite varies
    std::size_t particles = 0;
    Int3 nodes{};
    int frames = 0, repeats = 0;  // timed, over all repeats
    int in_contact = 0;           // of them with particles put out of a hand
    double substeps = 0;          // of a frame; median
    Spread frame, substep;
    double between = 0;             // least to greatest median of the repeats, over the median
    double surface = 0;             // of one frame; median; 0: none was made
    std::size_t bytes = 0;          // held by the solver
    double min_bytes = 0;           // per particle and substep
    double copy_share = 0;          // min_bytes over time, of the measured copy's rate
    std::vector<StageTime> stages;  // of one frame, or parts of the surface
    Counted counted;                // per particle and substep; per particle of a surface
    double moved = 1;               // share of the particle-substeps; the rest was still
    Drawn drawn;                    // its particles are splats where this has pixels
    FrameStats acted;               // its guards alone
    long crowded = 0;               // particles, at the first repeat's end
    std::string hash;               // of the first repeat's end
    int hashed_after = 0;           // frames, warm-up included
    std::string note;

    // Particle-substeps per second, of those that moved.
    double rate() const
    {
        return substep.median > 0 ? moved * double(particles) / substep.median : 0;
    }
};

enum class Met { aim, must, missed, open };
Met met(const Target& target);
const char* met_name(Met met);

// What a peer said of itself on its last line, and what stands beside it here.
struct PeerRow {
    std::string name, problem;  // problem: why there are no figures, "" if there are
    double substep = 0;         // its median [s]
    double ours = 0;            // of the same scene [s]
    double apart = 0;  // at the end: largest difference of the clay's middle and extent [m]
    nlohmann::json said;
};

// Where the clay is: mean and standard deviation of the particles' places, axis by axis [m].
using ProbePlaces = std::array<double, 6>;
// The scene that peers run, and how long one may take.
struct PeerOptions {
    int nodes = 64;                      // along each edge of the box of 1 m
    int frames = 240, warm_frames = 40;  // the first of them are not timed
    double limit = 3600;                 // [s]
};
// Reads a peer's last line that has a time, in JSON; false if there is none, or it lacks a number.
bool understood(const std::string& said, PeerRow& row, ProbePlaces& places);

struct BenchResult {
    std::vector<BenchRow> rows;
    std::vector<Target> targets;
    std::vector<PeerRow> peers;
    std::vector<std::string> left_out;
};

// How a case is driven.
struct Drive {
    int frames = 0;  // 0: to the end of the recording
    bool from_contact =
        true;             // begin where both hands touch, less the warm-up; else at the beginning
    int warm_up = 3;      // frames that are not timed
    int repeats = 1;      // each with a solver of its own
    bool stages = false;  // ask for the stages of a frame
    bool counts = true;   // and for what the device counts, where the options ask for it
    int surfaces = 0;     // surfaces made, spread over the frames
    double limit = 20;    // [s] for all repeats together; two frames are always timed
};

// All cases of one device. Cases of the same name are measured once.
class Bench {
  public:
    explicit Bench(const BenchOptions& options);

    // The scene of the options with its objects' particles, built; `settings` as of --set.
    Scene scene(const std::vector<std::string>& settings) const;
    const BenchRow& measured(const std::string& name, const Scene& scene, const Drive& drive);
    // A plain squeeze at `cells` per metre; the same case wherever it is asked for.
    const BenchRow& squeeze(int cells);
    // Whether a case of so many bytes per particle can be had, on both sides; says if not.
    bool fits(const std::string& what, double particles, double host_bytes, double device_bytes);

    void add(BenchRow row);  // unless it was interrupted before anything was timed
    // From now on keep() writes what was measured so far to this file, as each new row does, should
    // the program be ended before the rest is. What cannot be written is said, and no more.
    void keep_in(const std::string& file) { kept = file; }
    void keep() const;
    void say(const std::string& text) const;  // on stderr
    bool stopped() const;                     // by Ctrl-C
    // What `count` finds; nothing unless that is asked for. Once it has failed it is not tried
    // again, and `left_out` says why.
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

// The scene's frames, from `first` of the hands on, until the recording or an interrupt ends them,
// or `after`, which sees each, answers false. Throws what the solver throws.
void drive(const Scene& scene, Solver& solver, const HandSource* hands, int first,
           const std::function<bool(const Frame&)>& after);
// The same with every frame handed over while the one before is computed, each with a surface if
// that is wanted; where the device makes it, not even that is waited for.
struct QueuedFrames {
    int frames = 0;
    double frame = 0;     // [s] from the end of one to the end of the next, on average
    double waits = 0;     // of the host within a frame, on average
    double substeps = 0;  // of a frame, on average
    std::vector<Gaussian<double>> gaussians;  // as the last frame left them
};
QueuedFrames queued(const Scene& scene, Device device, const HandSource* hands, int first,
                    int frames, bool surfaces);
// The first frame at whose end every hand that is there reaches into the clay as it was seeded; -1
// if that never comes.
int first_contact(const Scene& scene, const HandSource& hands);
// Bytes that every substep must move per particle: its state in and out, and the nodes of the
// blocks with clay, written once and read once.
double min_bytes(std::size_t particles, long active_blocks);

// What was counted of `items` particle-substeps, or particles of a surface, beside `row`'s times.
Counted counted_each(const std::vector<StageWork>& stages, double items, const BenchRow& row,
                     const DeviceInfo& facts);

// Seconds of surfaces of one state by the scene's rule, and of their stages.
struct SurfaceTimes {
    std::vector<double> whole;
    std::vector<StageTime> stages;
    std::size_t bytes = 0;  // held on the device; 0: not counted
    std::string note;
};
SurfaceTimes surface_times(const std::vector<Particle<double>>& state, const Scene& scene,
                           Device device, int count);
// What a GPU's counters say of such a surface; empty on a CPU.
std::vector<StageWork> surface_counts(const std::vector<Particle<double>>& state,
                                      const Scene& scene, Device device);
// Seconds of the surfaces of `frames` frames on end, after as many as `warm_up`, where what has not
// moved is kept, and where nothing is. On a GPU.
struct KeptTimes {
    std::vector<double> kept, whole;
    double anew = 0;        // share of the blocks with clay that are made anew, on average
    std::size_t bytes = 0;  // held on the device
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
void targets_suite(Bench&);
void run_peers(Bench&);
void run_peers(Bench&, const PeerOptions& rule);

nlohmann::json bench_json(const Bench& bench);
std::string bench_csv(const BenchResult& result);
std::string bench_text(const Bench& bench);
// The clock of the multiprocessors as the driver tells it now [1/s]; 0: not told.
double gpu_clock();
// Draws what stands in the file `json`, beside it; "", or why not and how to do it by hand.
std::string draw(const Bench& bench, const std::string& json);

int bench_verb(const BenchOptions& options);

// Settings that put a scene's walls 3 nodes inside a cubic lattice over `edge` [m].
std::vector<std::string> walls_on_cells(double edge, int cells);

}  // namespace knead
