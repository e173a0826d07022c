#include "host/ui/time_graph.h"

#include <algorithm>
#include <numeric>

namespace knead {

void TimeGraph::add(const Stages& stages)
{
    std::vector<double>& row = rows_[std::size_t(next_)];
    row.assign(names_.size(), 0);
    for (const auto& [name, seconds] : stages) {
        const auto at = std::find(names_.begin(), names_.end(), name);
        const std::size_t i = std::size_t(at - names_.begin());
        if (at == names_.end()) names_.push_back(name), row.push_back(0);
        row[i] += seconds;
    }
    next_ = (next_ + 1) % frames;
    count_ = std::min(count_ + 1, frames);
}

double TimeGraph::seconds(int back, std::size_t name) const
{
    if (back < 0 || back >= count_) return 0;
    const std::vector<double>& row = rows_[std::size_t((next_ - 1 - back + 2 * frames) % frames)];
    return name < row.size() ? row[name] : 0;
}

double TimeGraph::total(int back) const
{
    double sum = 0;
    for (std::size_t i = 0; i < names_.size(); ++i) sum += seconds(back, i);
    return sum;
}

double TimeGraph::mean(std::size_t name) const
{
    double sum = 0;
    for (int back = 0; back < count_; ++back) sum += seconds(back, name);
    return count_ > 0 ? sum / count_ : 0;
}

double TimeGraph::longest() const
{
    double most = 0;
    for (int back = 0; back < count_; ++back) most = std::max(most, total(back));
    return most;
}

}  // namespace knead
