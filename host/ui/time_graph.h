// Times of the last frames by stage.
#pragma once
#include <array>
#include <string>
#include <vector>

namespace knead {

class TimeGraph {
  public:
    static constexpr int frames = 120;
    using Stages = std::vector<std::pair<std::string, double>>;  // name, seconds

    void add(const Stages& stages);

    int count() const { return count_; }
    // Names of all stages in the kept frames, in order of first appearance.
    const std::vector<std::string>& names() const { return names_; }
    // Of the frame `back` frames ago (0: the last): time of the stage names()[name], and their sum
    // [s].
    double seconds(int back, std::size_t name) const;
    double total(int back) const;
    double mean(std::size_t name) const;  // mean over the kept frames [s]
    double longest() const;               // longest total of the kept frames [s]

  private:
    std::array<std::vector<double>, frames> rows_;
    std::vector<std::string> names_;
    int next_ = 0, count_ = 0;
};

}  // namespace knead
