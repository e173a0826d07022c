#include "host/bench/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace knead {
namespace {

constexpr double width = 760, height = 460, left = 84, right = 24, top = 72, bottom = 84;
constexpr double names = 210, row_height = 30;  // of bars
const char* const colours[] = {"#b5512b", "#2f6f8f", "#7a8f2f", "#7b4f9d", "#c69214",
                               "#4d4d4d", "#d98c7a", "#8cb8cc", "#3f5c1e", "#b49bc9"};

const char* colour(std::size_t k) { return colours[k % std::size(colours)]; }

std::string escaped(const std::string& text)
{
    std::string out;
    for (char c : text) {
        if (c == '&')
            out += "&amp;";
        else if (c == '<')
            out += "&lt;";
        else if (c == '>')
            out += "&gt;";
        else if (c == '"')
            out += "&quot;";
        else if (static_cast<unsigned char>(c) >= 32)
            out += c;
    }
    return out;
}

std::string text(double x, double y, const std::string& what, const char* style)
{
    return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" {}>{}</text>\n", x, y, style,
                       escaped(what));
}

std::string frame(const std::string& title, const std::string& note, double from, double tall)
{
    return fmt::format(
               "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
               "viewBox=\"0 0 {0:.0f} {1:.0f}\" font-family=\"Helvetica, Arial, sans-serif\" "
               "font-size=\"12\" fill=\"#222\">\n"
               "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
               width, tall) +
           text(from, 28, title, "font-size=\"16\" font-weight=\"bold\"") +
           text(from, tall - 12, note, "font-size=\"10\" fill=\"#777\"");
}

// A number as short as it stays clear: 12 k, 3.5 M, 0.02.
std::string brief(double x)
{
    const double size = std::abs(x);
    if (size >= 1e9) return fmt::format("{:.3g} G", 1e-9 * x);
    if (size >= 1e6) return fmt::format("{:.3g} M", 1e-6 * x);
    if (size >= 1e4) return fmt::format("{:.3g} k", 1e-3 * x);
    return fmt::format("{:.4g}", x);
}

struct Axis {
    double low = 1, high = 1;
    bool logarithmic = false;

    double share(double x) const
    {
        return logarithmic ? std::log(x / low) / std::log(high / low) : (x - low) / (high - low);
    }
    bool shows(double x) const { return std::isfinite(x) && (!logarithmic || x > 0); }
};

struct Point {
    double x, y;
};

Axis axis(const std::vector<double>& values, bool logarithmic, bool from_zero)
{
    Axis a{1e300, -1e300, logarithmic};
    for (double v : values) a.low = std::min(a.low, v), a.high = std::max(a.high, v);
    if (values.empty()) return {logarithmic ? 1.0 : 0.0, 10, logarithmic};
    if (logarithmic) {
        // Out to the next marks: there are two at least, whatever is shown.
        const auto mark = [](double size, bool above) {
            const double decade = std::pow(10.0, std::floor(std::log10(size)));
            double nearest = above ? 10 * decade : decade;
            for (double digit : {2.0, 5.0})
                if (above ? digit * decade >= size && digit * decade < nearest
                          : digit * decade <= size)
                    nearest = digit * decade;
            return nearest;
        };
        a.low = mark(a.low / 1.02, false), a.high = mark(a.high * 1.02, true);
    } else {
        const double room = 0.06 * std::max(a.high - a.low, 1e-9 * std::abs(a.high) + 1e-300);
        a.low = from_zero && a.low >= 0 ? 0 : a.low - room;
        a.high += room;
    }
    return a;
}

std::string grid_lines(const Plot& plot, const Axis& ax, const Axis& ay)
{
    std::string out;
    const double low = height - bottom, wide = width - left - right, tall = low - top;
    for (double t : ticks(ax.low, ax.high, ax.logarithmic)) {
        const double x = left + wide * ax.share(t);
        out +=
            fmt::format("<path d=\"M{0:.1f} {1:.1f}V{2:.1f}\" stroke=\"#e6e6e6\"/>\n", x, top, low);
        out += text(x, low + 18, brief(t), "text-anchor=\"middle\"");
    }
    for (double t : ticks(ay.low, ay.high, ay.logarithmic)) {
        const double y = low - tall * ay.share(t);
        out += fmt::format("<path d=\"M{:.1f} {:.1f}H{:.1f}\" stroke=\"#e6e6e6\"/>\n", left, y,
                           width - right);
        out += text(left - 8, y + 4, brief(t), "text-anchor=\"end\"");
    }
    out += fmt::format("<path d=\"M{:.1f} {:.1f}V{:.1f}H{:.1f}\" stroke=\"#555\" fill=\"none\"/>\n",
                       left, top, low, width - right);
    out += text(left + wide / 2, low + 40, plot.x_label, "text-anchor=\"middle\"");
    return out + fmt::format(
                     "<text transform=\"translate(20 {:.1f}) rotate(-90)\" "
                     "text-anchor=\"middle\">{}</text>\n",
                     top + tall / 2, escaped(plot.y_label));
}

// One line below the title, where no curve can run through it.
std::string legend(double from, const std::vector<std::string>& of)
{
    std::string out;
    double x = from;
    for (std::size_t k = 0; k < of.size(); ++k) {
        out += fmt::format(
            "<rect x=\"{:.1f}\" y=\"42\" width=\"12\" height=\"12\" "
            "fill=\"{}\"/>\n",
            x, colour(k));
        out += text(x + 18, 52, of[k], "");
        x += 36 + 6.6 * double(of[k].size());
    }
    return out;
}

}  // namespace

std::vector<double> ticks(double low, double high, bool logarithmic)
{
    std::vector<double> out;
    if (!(high > low) || !std::isfinite(high - low) || (logarithmic && !(low > 0))) return out;
    if (logarithmic) {
        const double decades = std::log10(high / low);
        for (int e = int(std::floor(std::log10(low))); e <= int(std::ceil(std::log10(high))); ++e)
            for (int digit : {1, 2, 5}) {
                const double t = digit * std::pow(10.0, e);
                const bool wanted = digit == 1 || decades < 3;
                if (wanted && t >= low * (1 - 1e-12) && t <= high * (1 + 1e-12)) out.push_back(t);
            }
        return out;
    }
    const double rough = (high - low) / 9, size = std::pow(10.0, std::floor(std::log10(rough)));
    double step = 10 * size;
    for (double s : {5.0, 2.0, 1.0})
        if (s * size >= rough) step = s * size;
    const double first = std::ceil(low / step - 1e-9);
    for (int k = 0; k < 20 && (first + k) * step <= high + 1e-9 * step; ++k)
        out.push_back((first + k) * step);
    return out;
}

std::string svg(const Plot& plot)
{
    std::vector<std::vector<Point>> lines;
    std::vector<std::string> series;
    std::vector<double> xs, ys;
    const Axis plain_x{0, 1, plot.log_x}, plain_y{0, 1, plot.log_y};
    for (const Series& s : plot.series) {
        lines.emplace_back(), series.push_back(s.name);
        for (std::size_t i = 0; i < std::min(s.x.size(), s.y.size()); ++i) {
            if (!plain_x.shows(s.x[i]) || !plain_y.shows(s.y[i])) continue;
            lines.back().push_back({s.x[i], s.y[i]});
            xs.push_back(s.x[i]), ys.push_back(s.y[i]);
        }
    }
    std::string out = frame(plot.title, plot.note, left, height);
    if (xs.empty()) return out + text(left, height / 2, "nothing was measured", "") + "</svg>\n";
    const Axis ax = axis(xs, plot.log_x, false), ay = axis(ys, plot.log_y, true);
    out += legend(left, series) + grid_lines(plot, ax, ay);
    const double low = height - bottom, wide = width - left - right, tall = low - top;
    for (std::size_t k = 0; k < lines.size(); ++k) {
        std::string path, marks;
        for (const Point& p : lines[k]) {
            const double x = left + wide * ax.share(p.x), y = low - tall * ay.share(p.y);
            path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x, y);
            marks += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\" fill=\"{}\"/>\n", x,
                                 y, colour(k));
        }
        out +=
            fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"{}/>\n", path,
                        colour(k), plot.series[k].dashed ? " stroke-dasharray=\"6 4\"" : "");
        out += marks;
    }
    return out + "</svg>\n";
}

std::string svg(const BarPlot& plot)
{
    constexpr double from = 24;
    const double tall = top + row_height * double(plot.rows.size()) + 40;
    std::string out = frame(plot.title, plot.note, from, tall);
    const auto shown = [](double v) { return std::isfinite(v) && v > 0 ? v : 0; };
    double max = 0;
    for (const BarRow& row : plot.rows) {
        double sum = 0;
        for (double p : row.parts) sum += shown(p);
        max = std::max(max, sum);
    }
    if (max <= 0) return out + text(from, tall / 2, "nothing was measured", "") + "</svg>\n";
    out += legend(from, plot.legend);
    const double scale = (width - names - right - 80) / max;
    for (std::size_t r = 0; r < plot.rows.size(); ++r) {
        const double y = top + row_height * double(r);
        double x = names, sum = 0;
        out += text(names - 8, y + 16, plot.rows[r].name, "text-anchor=\"end\"");
        for (std::size_t k = 0; k < plot.rows[r].parts.size(); ++k) {
            const double part = shown(plot.rows[r].parts[k]);
            out += fmt::format(
                "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"22\" "
                "fill=\"{}\"/>\n",
                x, y, scale * part, colour(k));
            x += scale * part, sum += part;
        }
        out += text(x + 8, y + 16, brief(sum) + " " + plot.unit, "");
    }
    return out + "</svg>\n";
}

}  // namespace knead
