// GPU time of pictures by GL_TIME_ELAPSED queries, read some frames later without waiting.
#pragma once
#include <array>
#include <optional>

#include "render/gl.h"

namespace knead {

class DrawTimer {
  public:
    struct Reading {
        double seconds;
        float scale;  // argument of begin()
    };
    DrawTimer();  // the same context must be current whenever it is used or deleted
    ~DrawTimer();
    DrawTimer(const DrawTimer&) = delete;

    // Call around the draw calls. If too many results are pending, this picture is not timed.
    void begin(float scale);
    void end();
    // The oldest unread result; empty if it is not available yet.
    std::optional<Reading> poll();

  private:
    static constexpr std::size_t most = 8;
    std::array<GLuint, most> queries{};
    std::array<float, most> scales{};
    std::size_t begun = 0, read = 0;
    bool timing = false;
};

}  // namespace knead
