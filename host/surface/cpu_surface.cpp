// The surface as plain loops, in order of the steps: density, marching cubes, smoothing.
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>

#include "cuda/surface/advance.h"
#include "cuda/surface/density.h"
#include "cuda/surface/march.h"
#include "cuda/surface/smooth.h"
#include "host/base/parallel.h"
#include "host/solver/cpu/bins.h"
#include "host/surface/surface.h"

namespace knead {

namespace {

using Size = std::ptrdiff_t;

// Strides in Field::value along the axes.
struct Strides {
    Size axis[3];
    explicit Strides(const Field& f) : axis{1, f.size.x, Size(f.size.x) * f.size.y} {}
    Size corner(int c) const
    {
        return (c & 1) * axis[0] + (c >> 1 & 1) * axis[1] + (c >> 2) * axis[2];
    }
    Size row(Int3 n) const { return n.x + n.y * axis[1] + n.z * axis[2]; }
};

Int3 min_of(Int3 a, Int3 b) { return {min(a.x, b.x), min(a.y, b.y), min(a.z, b.z)}; }
Int3 max_of(Int3 a, Int3 b) { return {max(a.x, b.x), max(a.y, b.y), max(a.z, b.z)}; }
constexpr Int3 one{1, 1, 1};

// A field of the nodes low <= n <= high of the lattice, with an empty layer around them.
Field empty_field(Int3 low, Int3 high, const Lattice<float>& lattice)
{
    Field f;
    f.low = max_of(low, {0, 0, 0}) - one;
    f.size = min_of(high, lattice.size - one) + one + one - f.low;
    f.dx = lattice.dx;
    const double nodes = double(f.size.x) * f.size.y * f.size.z;
    if (nodes > double(1 << 30))
        throw std::runtime_error("the density needs " + std::to_string(nodes) +
                                 " nodes; a surface is made from at most 2^30");
    f.value.assign(std::size_t(nodes), 0.0f);
    return f;
}

// Blocks of base nodes are coloured 2 x 2 x 2: a block of 4^3 base nodes writes to 6^3 nodes, so
// that blocks of one colour share no node and run in parallel, while every node is summed in a
// fixed order.
void deposit_all(Field& f, const std::vector<Deposit>& deposits, Int3 low, Int3 high)
{
    const auto block_of = [](Int3 n) {
        return Int3{n.x / block_edge, n.y / block_edge, n.z / block_edge};
    };
    const Int3 from = block_of(low), size = block_of(high) + one - from;
    Bins bins;
    bins.key.resize(deposits.size());
    parallel_for(deposits.size(), [&](std::size_t i) {
        const Int3 b = block_of(base_node(deposits[i].x, f.dx)) - from;
        bins.key[i] = (b.x * size.y + b.y) * size.z + b.z;
    });
    bins.fill(size.x * size.y * size.z, size, loop_threads());
    std::vector<int> slots[8];
    for (int s = 0; s < int(bins.occupied.size()); ++s) {
        const int b = bins.occupied[s];
        const Int3 at = from + Int3{b / (size.y * size.z), b / size.z % size.y, b % size.z};
        slots[(at.x & 1) | (at.y & 1) << 1 | (at.z & 1) << 2].push_back(s);
    }
    const Strides stride(f);
    const float cell = f.dx * f.dx * f.dx;
    for (const std::vector<int>& colour : slots)
        parallel_for(colour.size(), LoopOptions{.chunk = 4}, [&](std::size_t k) {
            for (const int i : bins.members(colour[k])) {
                const Deposit& d = deposits[i];
                const Stencil<float> s = stencil(d.x, f.dx);
                float* const base = f.value.data() + stride.row(s.base - f.low);
                deposit(s, d.volume / cell,
                        [&](Int3 step, float part) { base[stride.row(step)] += part; });
            }
        });
}

// One smoothing pass along one axis; the outermost layer is unchanged.
void smooth_density(const Field& f, const std::vector<float>& from, std::vector<float>& to,
                    Size along)
{
    const Strides stride(f);
    parallel_for(f.size.z - 2, [&](int layer) {
        const int z = layer + 1;
        for (int y = 1; y < f.size.y - 1; ++y) {
            const Size row = stride.row({0, y, z});
            const float* const source = from.data() + row;
            float* const target = to.data() + row;
            for (int x = 1; x < f.size.x - 1; ++x)
                target[x] = smoothed<float>([&](int step) { return source[x + step * along]; });
        }
    });
}

// Numbers of triangles and vertices in one row of cells; then prefix sums over the rows.
struct RowCount {
    std::int64_t vertices = 0, triangles = 0;
};

struct Marcher {
    const Field& f;
    const float iso;
    const Strides stride{f};
    Size corner[8];
    std::vector<int> first;  // per node: index of its first vertex

    Marcher(const Field& field, float level) : f(field), iso(level), first(field.value.size())
    {
        for (int c = 0; c < 8; ++c) corner[c] = stride.corner(c);
    }

    unsigned crossed_at(Size i) const
    {
        const float* const v = f.value.data() + i;
        return crossed_edges(*v, iso, [&](int axis) { return v[stride.axis[axis]]; });
    }
    int case_at(Size i) const
    {
        const float* const v = f.value.data() + i;
        return cell_case(iso, [&](int c) { return v[corner[c]]; });
    }
    // Calls visit(low node of the cell within the box, its index) for a row of cells.
    template <class Visit>
    void along(int row, Visit&& visit) const
    {
        Int3 n{0, row % (f.size.y - 1), row / (f.size.y - 1)};
        for (Size i = stride.row(n); n.x < f.size.x - 1; ++n.x, ++i) visit(n, i);
    }

    RowCount count(int row) const
    {
        RowCount c;
        along(row, [&](Int3, Size i) {
            const int inside = case_at(i);
            if (inside == 0 || inside == 255) return;
            c.vertices += rank_of(crossed_at(i), 3);
            c.triangles += march_table.count[inside];
        });
        return c;
    }
    void place(int row, std::int64_t next, Mesh& mesh)
    {
        along(row, [&](Int3 n, Size i) {
            const unsigned crossed = crossed_at(i);
            first[i] = int(next);
            for (int axis = 0; axis < 3; ++axis) {
                if (!(crossed >> axis & 1)) continue;
                const float t = crossing(f.value[i], f.value[i + stride.axis[axis]], iso);
                mesh.vertices[next++] = crossing_point(f.low + n, axis, t, f.dx);
            }
        });
    }
    void connect(int row, std::int64_t next, Mesh& mesh) const
    {
        along(row, [&](Int3, Size i) {
            const int inside = case_at(i);
            if (inside == 0 || inside == 255) return;
            const auto vertex = [&](int low, int axis) {
                const Size owner = i + corner[low];
                return first[owner] + rank_of(crossed_at(owner), axis);
            };
            march(inside, march_table, vertex,
                  [&](int, Int3 triangle) { mesh.triangles[next++] = triangle; });
        });
    }
};

bool outermost_empty(const Field& f, float iso)
{
    const Strides stride(f);
    for (int z = 0; z < f.size.z; ++z)
        for (int y = 0; y < f.size.y; ++y) {
            const bool whole = z == 0 || y == 0 || z == f.size.z - 1 || y == f.size.y - 1;
            const float* const row = f.value.data() + stride.row({0, y, z});
            for (int x = 0; x < f.size.x; x += whole || f.size.x == 1 ? 1 : f.size.x - 1)
                if (is_inside(row[x], iso)) return false;
        }
    return true;
}

// The other two vertices of every triangle around a vertex, counter-clockwise. In a closed mesh the
// first of each pair run through all neighbours once.
struct Rings {
    struct Pair {
        int next, last;
    };
    std::vector<int> first;
    std::vector<Pair> pairs;

    explicit Rings(const Mesh& mesh) : first(mesh.vertices.size() + 1)
    {
        for (const Int3 t : mesh.triangles) ++first[t.x], ++first[t.y], ++first[t.z];
        int sum = 0;
        for (int& f : first) sum += f, f = sum;  // the end of each ring, decremented below
        pairs.resize(std::size_t(sum));
        for (std::size_t k = mesh.triangles.size(); k-- > 0;) {
            const Int3 t = mesh.triangles[k];
            pairs[--first[t.x]] = {t.y, t.z};
            pairs[--first[t.y]] = {t.z, t.x};
            pairs[--first[t.z]] = {t.x, t.y};
        }
    }
    int count(int v) const { return first[v + 1] - first[v]; }
    const Pair* of(int v) const { return pairs.data() + first[v]; }
};

using Points = std::vector<Vec3<float>>;

void relax_all(const Rings& rings, const Points& from, Points& to, float factor)
{
    parallel_for(from.size(), [&](std::size_t v) {
        const Rings::Pair* const ring = rings.of(int(v));
        to[v] =
            relax(from[v], rings.count(int(v)), factor, [&](int k) { return from[ring[k].next]; });
    });
}

bool usable(const Deposit& d, float dx)
{
    return std::isfinite(d.x.x) && std::isfinite(d.x.y) && std::isfinite(d.x.z) && d.volume > 0 &&
           std::isfinite(d.volume / (dx * dx * dx));
}

float value_at(const Field& f, Int3 n)
{
    const Int3 i = n - f.low;
    return within(i, f.size)
               ? f.value[(std::size_t(i.z) * std::size_t(f.size.y) + std::size_t(i.y)) *
                             std::size_t(f.size.x) +
                         std::size_t(i.x)]
               : 0;
}

// Computes `advance` of every vertex from the previous density; null: unknown, 0.
void advance_all(Mesh& mesh, const Field& now, const Field* past)
{
    mesh.advance.assign(mesh.vertices.size(), 0);
    if (!past || past->dx != now.dx) return;
    parallel_for(mesh.vertices.size(), [&](std::size_t v) {
        mesh.advance[v] = advance(
            mesh.vertices[v], now.dx, [&](Int3 n) { return value_at(now, n); },
            [&](Int3 n) { return value_at(*past, n); });
    });
}

void check(const SurfaceOptions& options)
{
    const Lattice<float>& l = options.lattice;
    const auto sensible = [](int n) { return n >= 3 && n <= 1 << 20; };
    if (!(l.dx > 0) || !std::isfinite(l.dx) || !sensible(l.size.x) || !sensible(l.size.y) ||
        !sensible(l.size.z))
        throw std::invalid_argument(
            "a surface needs a lattice of 3 to 2^20 nodes along each axis "
            "and a spacing above 0");
    if (!(options.iso > 0) || !std::isfinite(options.iso))
        throw std::invalid_argument("a surface needs an iso value above 0, not " +
                                    std::to_string(options.iso));
    if (options.iterations < 0)
        throw std::invalid_argument("a surface cannot be smoothed " +
                                    std::to_string(options.iterations) + " times");
}

}  // namespace

Field density(const std::vector<Deposit>& deposits, const Lattice<float>& lattice)
{
    if (deposits.empty()) return {{}, {}, lattice.dx, {}};
    Int3 low = base_node(deposits[0].x, lattice.dx), high = low;
    float largest = 0;
    for (const Deposit& d : deposits) {
        const Int3 base = base_node(d.x, lattice.dx);
        low = min_of(low, base), high = max_of(high, base);
        largest = max(largest, d.volume);
    }
    const int passes = smoothing_passes(largest, lattice.dx), reach = passes + 2;
    Field f = empty_field(low - passes * one, high + reach * one, lattice);
    deposit_all(f, deposits, low, high);
    std::vector<float> other(f.value.size());
    const Strides stride(f);
    for (int pass = 0; pass < passes; ++pass)
        for (const Size along : stride.axis) {
            smooth_density(f, f.value, other, along);
            f.value.swap(other);
        }
    return f;
}

Mesh isosurface(const Field& f, float iso)
{
    Mesh mesh;
    if (!outermost_empty(f, iso))
        throw std::runtime_error("the outermost layer of a density must be empty");
    const int rows = (f.size.y - 1) * (f.size.z - 1);
    if (f.value.empty() || rows <= 0) return mesh;
    Marcher marcher(f, iso);
    std::vector<RowCount> before(std::size_t(rows) + 1);
    const LoopOptions many{.chunk = 64};
    parallel_for(rows, many, [&](int row) { before[row + 1] = marcher.count(row); });
    for (int row = 0; row < rows; ++row) {
        before[row + 1].vertices += before[row].vertices;
        before[row + 1].triangles += before[row].triangles;
    }
    if (before[rows].triangles > INT32_MAX / 3)  // so that corner indices fit, too
        throw std::runtime_error("a surface of " + std::to_string(before[rows].triangles) +
                                 " triangles is too large");
    mesh.vertices.resize(std::size_t(before[rows].vertices));
    mesh.triangles.resize(std::size_t(before[rows].triangles));
    parallel_for(rows, many, [&](int row) { marcher.place(row, before[row].vertices, mesh); });
    parallel_for(rows, many, [&](int row) { marcher.connect(row, before[row].triangles, mesh); });
    return mesh;
}

void smooth(Mesh& mesh, Smoothing smoothing, int iterations)
{
    const Rings rings(mesh);
    Points& x = mesh.vertices;
    Points other(x.size());
    const int rounds = smoothing == Smoothing::none ? 0 : iterations;
    for (int k = 0; k < rounds; ++k) {
        relax_all(rings, x, other, smooth_shrink<float>);
        x.swap(other);
        if (smoothing == Smoothing::laplace) continue;
        relax_all(rings, x, other, smooth_swell<float>);
        x.swap(other);
    }
    mesh.normals.resize(x.size());
    parallel_for(x.size(), [&](std::size_t v) {
        const Rings::Pair* const ring = rings.of(int(v));
        mesh.normals[v] = vertex_normal<float>(rings.count(int(v)), [&](int k) {
            return area_normal(x[v], x[ring[k].next], x[ring[k].last]);
        });
    });
}

void move_by(std::vector<Mesh>& meshes, Vec3<double> by)
{
    if (dot(by, by) == 0) return;
    for (Mesh& mesh : meshes)
        for (Vec3<float>& x : mesh.vertices) x = cast<float>(cast<double>(x) + by);
}

std::vector<Mesh> surface(const std::vector<Particle<double>>& particles,
                          const std::vector<Material<double>>& materials,
                          const SurfaceOptions& options, SurfaceStats* stats, SurfaceHistory* past)
{
    check(options);
    SurfaceStats left_out;
    std::map<int, std::vector<Deposit>> by_category;
    for (const Particle<double>& q : particles) {
        const bool known = q.object >= 0 && std::size_t(q.object) < materials.size();
        const Material<double>* const m = known ? &materials[q.object] : nullptr;
        const Deposit d{cast<float>(q.x), m ? float(m->mass / m->density) : 0};
        if (!usable(d, options.lattice.dx))
            ++left_out.unusable;
        else if (!inside(d.x, options.lattice))
            ++left_out.outside;
        else
            by_category[m->category].push_back(d);
    }
    std::vector<Mesh> meshes;
    SurfaceHistory kept;
    for (const auto& [category, deposits] : by_category) {
        const auto field = std::make_shared<const Field>(density(deposits, options.lattice));
        Mesh mesh = isosurface(*field, options.iso);
        if (past && options.moving) kept.densities[category] = field;
        if (mesh.triangles.empty()) continue;
        smooth(mesh, options.smoothing, options.iterations);
        if (past && options.moving) advance_all(mesh, *field, past->densities[category].get());
        mesh.category = category;
        meshes.push_back(std::move(mesh));
    }
    if (past) *past = std::move(kept);
    if (stats) *stats = left_out;
    return meshes;
}

}  // namespace knead
