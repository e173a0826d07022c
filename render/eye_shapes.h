// GL buffers of a live picture.
#pragma once
#include <array>
#include <vector>

#include "render/eye_painter.h"
#include "render/program.h"

namespace knead {

// Buffers of one list of vertices and triangles.
struct Shapes {
    Buffer vertices = buffer(), triangles = buffer();
    VertexArray layout = paint_layout(vertices, triangles);

    void upload(const Geometry& geometry)
    {
        glNamedBufferData(vertices, GLsizeiptr(geometry.vertices.size() * sizeof(PaintVertex)),
                          geometry.vertices.data(), GL_STREAM_DRAW);
        glNamedBufferData(triangles, GLsizeiptr(geometry.triangles.size() * sizeof(Int3)),
                          geometry.triangles.data(), GL_STREAM_DRAW);
    }
    void draw(Range range) const
    {
        if (range.count == 0) return;
        glBindVertexArray(layout);
        glDrawElements(GL_TRIANGLES, 3 * range.count, GL_UNSIGNED_INT,
                       reinterpret_cast<const void*>(std::size_t(range.first) * sizeof(Int3)));
    }
};

struct DrawnHand {
    HandRanges ranges;
    float opacity;
    Vec3<float> glow;
};
std::vector<DrawnHand> gather_hands(Geometry& geometry, const std::vector<HandLook>& hands);

// Hidden area of an eye: corners of triangles at attribute location 0.
struct DrawnHidden {
    Buffer vertices = buffer();
    VertexArray layout = vertex_array();
    std::vector<std::array<float, 2>> corners;  // [tangents]

    void set(const std::vector<std::array<float, 2>>& corners);
    bool any() const { return !corners.empty(); }
    void draw() const;
};

}  // namespace knead
