#include "render/eye_clay.h"

#include <algorithm>
#include <stdexcept>

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

void SharedClay::draw(std::size_t part, const std::map<int, Vec3<float>>& colours) const
{
    const auto own = colours.find(categories_.at(part));
    const Vec3<float> c =
        own == colours.end() ? category_colour(categories_.at(part)) : own->second;
    glBindVertexArray(layout_);
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, buffer_);
    glVertexAttrib4f(2, c.x, c.y, c.z, 0);  // constant colour; skin 0: clay
    const std::size_t command = shared_->layout().draws + part * MeshLayout::command;
    glDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT, reinterpret_cast<const void*>(command));
    glVertexAttrib4f(2, 0, 0, 0, 1);
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
}

void EyeClay::set(const std::vector<Mesh>& meshes, const std::vector<int>& unseen,
                  const std::vector<int>& hidden, const ClayColours& colours)
{
    static const std::vector<Vec3<float>> none;
    Geometry all{};
    std::vector<Part> parts;
    for (std::size_t k = 0; k < meshes.size(); ++k) {
        const Mesh& mesh = meshes[k];
        if (among(hidden, mesh.category)) continue;
        const int first = int(all.triangles.size());
        const std::size_t first_vertex = all.vertices.size();
        add_clay(all, mesh);
        const auto& of = k < colours.of_vertices.size() ? colours.of_vertices[k] : none;
        if (!of.empty() && of.size() != mesh.vertices.size())
            throw std::invalid_argument("as many colours of clay as vertices are needed");
        const auto own = colours.of_category.find(mesh.category);
        for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
            if (!of.empty())
                all.vertices[first_vertex + i].colour = of[i];
            else if (own != colours.of_category.end())
                all.vertices[first_vertex + i].colour = own->second;
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
                  const std::vector<int>& hidden, const ClayColours& colours)
{
    colours_ = colours.of_category;
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
        shared_.draw(part, colours_);
    else
        shapes_.draw(parts_[part].range);
}

}  // namespace knead
