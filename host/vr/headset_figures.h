// Timing statistics of headset frames, and latency from hand motion to visible deformation.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace knead {

// Wall time of one frame's parts [s].
struct FrameParts {
    double wait = 0;      // for the display
    double locate = 0;    // locating eyes and hands, and waiting for textures
    double simulate = 0;  // stepped time: waiting for the simulation
    double draw = 0;
    double submit = 0;
    double period = 0;      // of the display
    double interval = 0;    // from the display time of the previous frame; 0: it was not displayed
    double left = -1;       // from submission to the deadline; negative: unknown
    double latency = -1;    // from the hand's sample to the frame that shows its effect; negative:
                            // no simulation
    float scale = 1;        // linear resolution scale of the eyes
    float splat_scale = 1;  // linear scale of the splat picture, relative to it
    double splats = 0;      // time for the splat picture; 0: there is none

    double work() const { return locate + simulate + draw + submit; }
    // Whether both the work and the interval, a multiple of the period, are at most `periods`.
    bool within(double periods) const
    {
        return work() <= periods * period && interval <= (periods + 0.5) * period;
    }
    // Idle share of the period; less than 0.2 is not comfortable.
    double margin() const { return period > 0 ? 1 - work() / period : 0; }
};

// The last frames, for a graph, and statistics over all frames.
class FrameFigures {
  public:
    static constexpr std::size_t kept = 180;    // frames of the graph
    static constexpr double comfortable = 0.2;  // of the period
    static constexpr std::size_t most_listed = 100;

    void add(const FrameParts& frame);
    // Newest last.
    const std::vector<FrameParts>& recent() const { return last; }
    // Mean margin over the frames of the graph; 1 if there are none.
    double margin() const;
    bool is_comfortable() const { return margin() >= comfortable; }
    long count() const { return frames; }
    long missed() const { return late; }  // frames whose work exceeds their period
    // Medians and percentiles [ms], latency also in frames, over at most an hour at 90 Hz, and a
    // list of the first `most_listed` late frames.
    nlohmann::json figures() const;
    std::string summary() const;

  private:
    struct Late {
        long frame;  // from 0
        FrameParts parts;
    };
    std::vector<FrameParts> last;
    std::vector<Late> listed;
    long far_late = 0, left_out = 0;  // frames over two periods; display frames skipped
    std::vector<float> work, draw, latency, latency_frames, scale, splats, splat_scale;
    long frames = 0, late = 0;
};

}  // namespace knead
