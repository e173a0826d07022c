// What the last frames took, stage by stage.
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
    // The names that any kept frame has, in the order in which they first came.
    const std::vector<std::string>& names() const { return names_; }
    // Of the frame so many back, 0 the last: seconds by the order of names(), and their sum.
    double seconds(int back, std::size_t name) const;
    double total(int back) const;
    double mean(std::size_t name) const;  // over the kept frames
    double longest() const;               // total of any

  private:
    std::array<std::vector<double>, frames> rows_;
    std::vector<std::string> names_;
    int next_ = 0, count_ = 0;
};

}  // namespace knead
