// Headless pictures: clay, hands and floor with light, shade, contact shadow and ambient occlusion.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "cuda/medial.h"
#include "host/mesh.h"

namespace knead {

struct Camera {
    Vec3<float> eye, target;  // [m]
    float field = 0.6f;       // vertical field of view [rad]
    int width = 960, height = 720;
    float hands = 1;          // opacity of the hands in [0, 1]; at 0 they cast no shadow either
};

// A medial primitive to be drawn as it is, e.g. a finger.
struct Blob {
    int count;             // 1 ball, 2 cone, 3 slab
    Sphere<float> sphere[3];
};

struct Image {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;  // 3 * width * height, sRGB, top row first
};

class Painter {
  public:
    // Throws std::runtime_error, with the reason, where no GL context can be made.
    static std::unique_ptr<Painter> open();
    virtual ~Painter() = default;
    // `floor` is the height of the ground plane [m].
    virtual Image paint(const std::vector<Mesh>& meshes, const std::vector<Blob>& blobs,
                        const Camera& camera, float floor) = 0;
    virtual std::string name() const = 0;  // the GL renderer
};

// Writes a PNG; throws std::runtime_error with path and reason.
void write_png(const std::string& path, const Image& image);

// Pipes frames to ffmpeg, where it exists.
class Video {
  public:
    static bool available();
    static std::unique_ptr<Video> open(const std::string& path, int width, int height, double rate);
    virtual ~Video() = default;
    virtual void add(const Image& image) = 0;
    virtual void close() = 0;  // throws if ffmpeg failed
};

}  // namespace knead
