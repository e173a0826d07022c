#include "host/cli/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

#include "host/base/machine.h"

namespace knead {

Progress::Progress(int count, bool quiet)
    : frames(count),
      shown(!quiet && isatty(STDERR_FILENO)),
      start(wall_seconds()),
      last(start),
      begun(start)
{
}

Progress::~Progress() { clear(); }

void Progress::show(int done, double part)
{
    const double now = wall_seconds();
    if (part == 0) begun = now;
    if (part > 0 && now - begun < 1) return;
    if (!shown || (now - last < 0.1 && done < frames)) return;
    last = now;
    drawn = true;
    std::fprintf(stderr, "\r%s\x1b[K", progress_line(done, frames, now - start, part).c_str());
    std::fflush(stderr);
}

void Progress::clear()
{
    if (drawn) std::fputs("\r\x1b[K", stderr);
    drawn = false;
}

std::string progress_line(int done, int frames, double seconds, double part)
{
    constexpr int width = 30;
    const int filled = frames > 0 ? width * done / frames : width;
    std::string line = "[" + std::string(std::size_t(filled), '#') +
                       std::string(std::size_t(width - filled), '.') + "]" +
                       fmt::format(" {}/{}", done, frames);
    if (part > 0) line += fmt::format(" + {:.2g} %", 100 * part);
    if (done == 0 || !(seconds > 0)) return line;
    const double rate = done / seconds, left = (frames - done) / rate;
    line += fmt::format("  {:.{}f} frames/s", rate, rate < 100 ? 1 : 0);
    if (left < 120) return line + fmt::format("  {:.0f} s left", left);
    return line + fmt::format("  {:.0f} min left", left / 60);
}

}  // namespace knead
