#include "render/eye_clay.h"

#include <algorithm>

namespace knead {
namespace {

bool among(const std::vector<int>& all, int one)
{
    return std::find(all.begin(), all.end(), one) != all.end();
}

}  // namespace

const Sharing& Sharings::with(int device)
{
    const auto known = found_.find(device);
    if (known != found_.end()) return known->second;
    const Sharing found =
        wanted_ ? sharing(device)
                : Sharing{false, "pictures go from CUDA to OpenGL by way of host memory, as asked"};
    return found_.emplace(device, found).first->second;
}

void SharedClay::take(const DeviceMesh& mesh)
{
    const SurfaceRoom room = mesh.room();
    const bool fits = shared_ && device_ == mesh.device() && categories_ == mesh.categories() &&
                      room.vertices == shared_->layout().room.vertices &&
                      room.triangles == shared_->layout().room.triangles;
    if (!fits) {
        shared_.reset();
        const MeshLayout at(room, mesh.categories().size());
        buffer_ = buffer(), layout_ = vertex_array();
        glNamedBufferData(buffer_, GLsizeiptr(at.bytes), nullptr, GL_DYNAMIC_DRAW);
        const std::size_t starts[] = {at.places, at.normals};
        for (GLuint i = 0; i < 2; ++i) {
            glVertexArrayVertexBuffer(layout_, i, buffer_, GLintptr(starts[i]), 16);
            glVertexArrayAttribFormat(layout_, i, 3, GL_FLOAT, GL_FALSE, 0);
            glVertexArrayAttribBinding(layout_, i, i);
            glEnableVertexArrayAttrib(layout_, i);
        }
        glVertexArrayAttribFormat(layout_, 3, 1, GL_FLOAT, GL_FALSE, 12);  // advance
        glVertexArrayAttribBinding(layout_, 3, 1);
        glEnableVertexArrayAttrib(layout_, 3);
        glVertexArrayElementBuffer(layout_, buffer_);
        shared_ = std::make_unique<SharedMesh>(buffer_, at, mesh.device());
        device_ = mesh.device(), categories_ = mesh.categories();
    }
    shared_->copy(mesh);
}

void SharedClay::draw(std::size_t part) const
{
    const Vec3<float> c = category_colour(categories_.at(part));
    glBindVertexArray(layout_);
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, buffer_);
    glVertexAttrib4f(2, c.x, c.y, c.z, 0);  // constant colour; skin 0: clay
    const std::size_t command = shared_->layout().draws + part * MeshLayout::command;
    glDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT, reinterpret_cast<const void*>(command));
    glVertexAttrib4f(2, 0, 0, 0, 1);
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
}

void EyeClay::set(const std::vector<Mesh>& meshes, const std::vector<int>& unseen,
                  const std::vector<int>& hidden)
{
    Geometry all{};
    std::vector<Part> parts;
    for (const Mesh& mesh : meshes) {
        if (among(hidden, mesh.category)) continue;
        const int first = int(all.triangles.size());
        add_clay(all, mesh);
        parts.push_back({mesh.category,
                         !among(unseen, mesh.category),
                         true,
                         {first, int(all.triangles.size()) - first}});
    }
    about_ = around(all, {0, 0, 0}, farthest_);
    shapes_.upload(all);
    parts_ = std::move(parts), on_device_ = false;
}

// A part is drawn by its index, so that hidden ones stay in the list.
void EyeClay::set(const DeviceMesh& mesh, const std::vector<int>& unseen,
                  const std::vector<int>& hidden)
{
    std::vector<Part> parts;
    about_ = around(Geometry{}, {0, 0, 0}, farthest_);
    if (!mesh.empty()) {
        shared_.take(mesh);
        about_ = around(mesh.box(), {0, 0, 0}, farthest_);
        for (const int category : mesh.categories()) {
            const bool drawn = !among(hidden, category);
            parts.push_back({category, drawn && !among(unseen, category), drawn, {}});
        }
    }
    parts_ = std::move(parts), on_device_ = true;
}

void EyeClay::draw(std::size_t part) const
{
    if (on_device_)
        shared_.draw(part);
    else
        shapes_.draw(parts_[part].range);
}

}  // namespace knead
