// How long the parts of a headset's frames take, and how late deformation follows the hand.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace knead {

// Wall time of one frame's parts [s].
struct FrameParts {
    double wait = 0;      // for the display
    double locate = 0;    // eyes and hands, and for textures
    double simulate = 0;  // in stepped time: for the simulation
    double draw = 0;
    double submit = 0;
    double period = 0;      // from frame to frame
    double interval = 0;    // since the frame before was to be seen; 0: it was not
    double left = -1;       // before the frame is due when it is submitted; negative: not known
    double latency = -1;    // from the hand's sample to the frame that shows what it did; negative:
                            // there is no simulation that would show it
    float scale = 1;        // of an eye's sides, as drawn
    float splat_scale = 1;  // of these, in the picture that splats have of their own
    double splats = 0;      // what that picture took [s]; 0: there is none

    double work() const { return locate + simulate + draw + submit; }
    // Neither its work nor the time since the frame before, which is whole periods, is longer.
    bool within(double periods) const
    {
        return work() <= periods * period && interval <= (periods + 0.5) * period;
    }
    // The share of the period that is not worked in: below 0.2 it is no longer comfortable.
    double margin() const { return period > 0 ? 1 - work() / period : 0; }
};

// The last frames, for a graph, and figures of all.
class FrameFigures {
  public:
    static constexpr std::size_t kept = 180;    // frames of the graph
    static constexpr double comfortable = 0.2;  // of the period
    static constexpr std::size_t most_listed = 100;

    void add(const FrameParts& frame);
    // Newest last.
    const std::vector<FrameParts>& recent() const { return last; }
    // Mean margin over the frames of the graph [1]; 1 where there are none.
    double margin() const;
    bool is_comfortable() const { return margin() >= comfortable; }
    long count() const { return frames; }
    long missed() const { return late; }  // that took longer than their period
    // Medians and percentiles [ms], and latency in frames, of up to an hour at 90 Hz; and the first
    // `most_listed` late frames one by one.
    nlohmann::json figures() const;
    std::string summary() const;

  private:
    struct Late {
        long frame;  // from 0
        FrameParts parts;
    };
    std::vector<FrameParts> last;
    std::vector<Late> listed;
    long far_late = 0, left_out = 0;  // frames over two periods; of the display, never drawn
    std::vector<float> work, draw, latency, latency_frames, scale, splats, splat_scale;
    long frames = 0, late = 0;
};

}  // namespace knead
