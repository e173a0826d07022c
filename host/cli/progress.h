// A bar with frames per second and the time left: on stderr, and only on a terminal.
#pragma once
#include <chrono>
#include <string>

namespace knead {

class Progress {
  public:
    Progress(int frames, bool quiet);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    void show(int done);  // draws at most ten times a second
    void clear();

  private:
    using ClockMode = std::chrono::steady_clock;
    int frames;
    bool shown, drawn = false;
    ClockMode::time_point start, last;
};

// The bar's text, without the carriage return: "[#####.....] 50/100  12.3 frames/s  4 s left".
std::string progress_line(int done, int frames, double seconds);

}  // namespace knead
