// Video encoding by ffmpeg.
#pragma once
#include <memory>
#include <string>

#include "host/files/image.h"

namespace knead {

// Streams frames to ffmpeg, if installed. All functions throw OutputError with path and reason if
// the video cannot be written. The file is written atomically.
class Video {
  public:
    static bool available();
    static std::unique_ptr<Video> open(const std::string& path, int width, int height, double rate);
    virtual ~Video() = default;
    virtual void add(const Image& image) = 0;
    virtual void close() = 0;
};

}  // namespace knead
