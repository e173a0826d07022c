// Progress bar with frames per second and time left, on stderr if that is a terminal.
#pragma once
#include <string>

namespace knead {

class Progress {
  public:
    Progress(int frames, bool quiet);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    // Redraws at most ten times a second. `part`: completed fraction of the next frame.
    void show(int done, double part = 0);
    void clear();

  private:
    int frames;
    bool shown, drawn = false;
    double start, last, begun;  // wall_seconds() [s]; begun: of the current frame
};

// The bar's text, without the carriage return: "[#####.....] 50/100  12.3 frames/s  4 s left", and
// "[#####.....] 50/100 + 7 %  ..." within a frame that takes longer than a second.
std::string progress_line(int done, int frames, double seconds, double part = 0);

}  // namespace knead
