// Clay of a live picture: meshes uploaded from the host, or shared with a CUDA device without a
// copy through host memory.
#pragma once
#include <map>

#include "host/share/shared_mesh.h"
#include "host/share/sharing.h"
#include "render/eye_painter.h"
#include "render/eye_shapes.h"

namespace knead {

// Whether a CUDA device can share memory with this context; determined once per device.
class Sharings {
  public:
    explicit Sharings(bool wanted) : wanted_(wanted) {}
    const Sharing& with(int device);

  private:
    bool wanted_;
    std::map<int, Sharing> found_;
};

// A mesh on a CUDA device, copied by CUDA into a GL buffer and drawn by indirect commands: the
// number of triangles stays on the device.
class SharedClay {
  public:
    // Throws std::runtime_error on a CUDA error.
    void take(const DeviceMesh& mesh);
    // Draws the category at this index.
    void draw(std::size_t part, const std::map<int, Vec3<float>>& colours) const;

  private:
    Buffer buffer_;
    VertexArray layout_;
    std::unique_ptr<SharedMesh> shared_;  // before the buffer is freed
    std::vector<int> categories_;
    int device_ = -1;
};

class EyeClay {
  public:
    struct Part {
        int category;
        bool seen, casts;  // in the picture; a shadow
        Range range;       // of the uploaded triangles
    };
    // about() ignores clay farther than `farthest` [m] from the origin. Clay of the categories
    // `unseen` only casts a shadow, that of the categories `hidden` does not even that.
    explicit EyeClay(float farthest) : farthest_(farthest) {}

    void set(const std::vector<Mesh>& meshes, const std::vector<int>& unseen,
             const std::vector<int>& hidden, const ClayColours& colours);
    void set(const DeviceMesh& mesh, const std::vector<int>& unseen, const std::vector<int>& hidden,
             const ClayColours& colours);  // shared
    const std::vector<Part>& parts() const { return parts_; }
    void draw(std::size_t part) const;
    const Ball& about() const { return about_; }  // bounding ball of all clay

  private:
    const float farthest_;
    Shapes shapes_;
    SharedClay shared_;
    bool on_device_ = false;
    std::vector<Part> parts_;
    std::map<int, Vec3<float>> colours_;  // of categories
    Ball about_{};
};

}  // namespace knead
