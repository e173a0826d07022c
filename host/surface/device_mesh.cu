#include <algorithm>
#include <bit>

#include "cuda/device/device.cuh"
#include "host/surface/device_mesh.cuh"

namespace knead {

using namespace gpu;

namespace {

// Pool size above which a writer waits for a renderer.
constexpr std::size_t most = 4;

Vec3<float> corner(const int (&side)[3])
{
    const auto value = [&](int k) { return std::bit_cast<float>(ordered(side[k])); };
    return {value(0), value(1), value(2)};
}

template <class T>
std::vector<T> downloaded(const DeviceArray<T>& from, std::size_t count)
{
    std::vector<T> to(count);
    if (count)
        check(cudaMemcpy(to.data(), from.data(), count * sizeof(T), cudaMemcpyDefault), "download");
    return to;
}

}  // namespace

KeptMesh::KeptMesh(SurfaceRoom room, int categories, int on)
    : device(on),
      processors(multiprocessors(on)),
      triangles(room.triangles),
      places(room.vertices),
      normals(room.vertices),
      draws(std::size_t(categories)),
      facts(1)
{
}

// Prefers a released mesh whose reads have completed, so that the launched copy rarely waits for a
// renderer.
std::shared_ptr<KeptMesh> KeptMeshes::launch(const SurfaceView& view, int device,
                                             cudaStream_t stream)
{
    const SurfaceRoom room{std::size_t(view.vertex_room), std::size_t(view.triangle_room)};
    std::erase_if(all, [&](const std::shared_ptr<KeptMesh>& one) {
        return one->places.size() != room.vertices || one->triangles.size() != room.triangles;
    });
    const auto let_go = [](const auto& one) { return one.use_count() == 1; };
    auto free = std::find_if(all.begin(), all.end(), [&](const auto& one) {
        return let_go(one) && is_over(one->read, "surface");
    });
    if (free == all.end() && all.size() >= most)
        free = std::find_if(all.begin(), all.end(), let_go);
    if (free == all.end()) {
        all.push_back(std::make_shared<KeptMesh>(room, view.categories, device));
        free = all.end() - 1;
    }
    const KeptMesh& to = **free;
    check(cudaStreamWaitEvent(stream, to.read, 0), "surface");
    keep_mesh(view, to.place(), to.processors, stream);
    check(cudaMemcpyAsync(to.host_info.data(), to.facts.data(), sizeof(MeshInfo),
                          cudaMemcpyDeviceToHost, stream),
          "surface");
    check(cudaEventRecord(to.written, stream), "surface");
    return *free;
}

std::size_t KeptMeshes::bytes() const
{
    std::size_t sum = 0;
    for (const auto& one : all)
        sum += one->triangles.bytes() + one->places.bytes() + one->normals.bytes() +
               one->draws.bytes() + one->facts.bytes();
    return sum;
}

DeviceMesh::DeviceMesh(std::shared_ptr<KeptMesh> kept, std::vector<int> categories,
                       const MeshInfo& facts)
    : kept_(std::move(kept)),
      categories_(std::move(categories)),
      vertices_(facts.vertices),
      triangles_(facts.triangles)
{
    if (vertices_ > 0) box_ = {corner(facts.low), corner(facts.high)};
}

int DeviceMesh::device() const { return kept_->device; }

SurfaceRoom DeviceMesh::room() const { return {kept_->places.size(), kept_->triangles.size()}; }

std::vector<Mesh> DeviceMesh::meshes() const
{
    if (empty()) return {};
    check(cudaSetDevice(device()), "device");
    const std::vector<Int3> triangles = downloaded(kept_->triangles, triangles_);
    const std::vector<float4> places = downloaded(kept_->places, vertices_),
                              normals = downloaded(kept_->normals, vertices_);
    const std::vector<DrawCommand> draws = kept_->draws.downloaded();
    std::vector<Mesh> meshes;
    int first = 0;  // the vertices of a category follow those of the previous one
    for (std::size_t c = 0; c < categories_.size(); ++c) {
        if (draws[c].count == 0) continue;
        Mesh mesh;
        mesh.category = categories_[c];
        int end = first;
        const std::size_t from = draws[c].first_index / 3;
        for (std::size_t k = from; k < from + draws[c].count / 3; ++k) {
            const Int3 t = triangles[k];
            end = std::max({end, t.x + 1, t.y + 1, t.z + 1});
            mesh.triangles.push_back(t - Int3{first, first, first});
        }
        for (; first < end; ++first) {
            const float4 x = places[std::size_t(first)], n = normals[std::size_t(first)];
            mesh.vertices.push_back({x.x, x.y, x.z}), mesh.normals.push_back({n.x, n.y, n.z});
            mesh.advance.push_back(n.w);
        }
        const auto moves = [](float a) { return a != 0; };
        if (std::none_of(mesh.advance.begin(), mesh.advance.end(), moves)) mesh.advance.clear();
        meshes.push_back(std::move(mesh));
    }
    return meshes;
}

}  // namespace knead
