// How long OpenGL takes for pictures, told some frames later, so that nothing waits.
#pragma once
#include <array>
#include <optional>

#include "render/gl.h"

namespace knead {

class DrawTimer {
  public:
    struct Reading {
        double seconds;
        float scale;  // as begin() was told
    };
    DrawTimer();  // in the context that is current whenever it is used or deleted
    ~DrawTimer();
    DrawTimer(const DrawTimer&) = delete;

    // About what is drawn. Where too many are not known yet, this one is not timed.
    void begin(float scale);
    void end();
    // The oldest that was not told, if it is known by now.
    std::optional<Reading> told();

  private:
    static constexpr std::size_t most = 8;
    std::array<GLuint, most> queries{};
    std::array<float, most> scales{};
    std::size_t begun = 0, read = 0;
    bool timing = false;
};

}  // namespace knead
