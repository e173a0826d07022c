// Clay as a live picture draws it: from the host's meshes, or from those of a CUDA device without a
// way through host memory.
#pragma once
#include <map>

#include "host/share/shared_mesh.h"
#include "host/share/sharing.h"
#include "render/eye_shapes.h"

namespace knead {

// Whether what a CUDA device makes is shared with this context, found out once for each.
class Sharings {
  public:
    explicit Sharings(bool wanted) : wanted_(wanted) {}
    const Sharing& with(int device);

  private:
    bool wanted_;
    std::map<int, Sharing> found_;
};

// A mesh on a CUDA device, in a buffer that CUDA writes: how many triangles there are only the
// device knows.
class SharedClay {
  public:
    // Throws std::runtime_error where CUDA refuses.
    void take(const DeviceMesh& mesh);
    // The part of that place among the categories.
    void draw(std::size_t part) const;

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
        bool seen;    // else it only casts its shadow
        Range range;  // of the host's
    };
    // What lies farther from the origin than `farthest` [m] does not count in about(). Clay of the
    // categories `unseen` is not seen.
    explicit EyeClay(float farthest) : farthest_(farthest) {}

    void set(const std::vector<Mesh>& meshes, const std::vector<int>& unseen);
    void set(const DeviceMesh& mesh, const std::vector<int>& unseen);  // shared
    const std::vector<Part>& parts() const { return parts_; }
    void draw(std::size_t part) const;
    const Ball& about() const { return about_; }  // all clay

  private:
    const float farthest_;
    Shapes shapes_;
    SharedClay shared_;
    bool on_device_ = false;
    std::vector<Part> parts_;
    Ball about_{};
};

}  // namespace knead
