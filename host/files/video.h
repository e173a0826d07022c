// A video of pictures, made by ffmpeg.
#pragma once
#include <memory>
#include <string>

#include "host/files/image.h"

namespace knead {

// Pipes frames to ffmpeg, where it exists. All throw OutputError with path and reason where the
// video cannot be written; it appears whole under its name or not at all.
class Video {
  public:
    static bool available();
    static std::unique_ptr<Video> open(const std::string& path, int width, int height, double rate);
    virtual ~Video() = default;
    virtual void add(const Image& image) = 0;
    virtual void close() = 0;
};

}  // namespace knead
