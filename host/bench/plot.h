// Small drawings of measurements, as SVG: lines over one axis, and bars.
#pragma once
#include <string>
#include <vector>

namespace knead {

struct Series {
    std::string name;
    std::vector<double> x, y;  // as long as each other
    bool dashed = false;       // what was not measured here
};

struct Plot {
    std::string title, x_label, y_label;
    bool log_x = false, log_y = false;
    std::vector<Series> series;
    std::string note;  // below the axes: device, commit, date
};

struct BarRow {
    std::string name;
    std::vector<double> parts;  // stacked, in the order of the legend
};
struct BarPlot {
    std::string title, unit;
    std::vector<std::string> legend;
    std::vector<BarRow> rows;
    std::string note;
};

// Points that are not finite, or not above 0 on a logarithmic axis, are left out. A drawing without
// points says so.
std::string svg(const Plot& plot);
std::string svg(const BarPlot& plot);

// Places of the marks on an axis from low to high: whole decades' 1, 2, 5, or even steps.
std::vector<double> ticks(double low, double high, bool logarithmic);

}  // namespace knead
