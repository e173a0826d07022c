#include "host/scene/domain.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/scene/names.h"

namespace knead {
namespace {

constexpr int max_cells = 1024;
constexpr int beyond = 2;  // nodes beyond each wall

// Error for the former key "margin", with the values of the present keys.
[[noreturn]] void refuse_margin(ObjectReader& r, const Lattice<double>& l, const Json& found)
{
    const int nodes = found.is_number_integer() ? found.get<int>() : 3;
    const WallOptions w = walls_inside(l, nodes, ContactMode::sticky, 0);
    r.fail("margin",
           fmt::format("walls in metres (as {} nodes of this lattice would be: \"min\": [{}, {}, "
                       "{}], \"max\": [{}, {}, {}])",
                       nodes, w.min.x, w.min.y, w.min.z, w.max.x, w.max.y, w.max.z),
           described(found));
}

Vec3<double> extent_of(const Lattice<double>& l)
{
    return {l.dx * l.size.x, l.dx * l.size.y, l.dx * l.size.z};
}

int in_blocks(int nodes) { return (nodes + block_edge - 1) / block_edge * block_edge; }

// Placement of a lattice of `size` nodes along one axis with walls at `min` and `max`: position of
// its first node and number of nodes. The low wall must lie on a node (18): the lattice is shifted
// up by the fraction of a cell by which the wall lies beyond a node, and down by whole blocks where
// nodes are missing below it.
struct Laid {
    double first;  // [m]
    int size;
};
Laid laid(double min, double max, double dx, int size)
{
    const int below = held_nodes(min, max, dx).below;
    const int before = below < beyond ? in_blocks(beyond - below) : 0;
    const double past = min / dx - below, moved = past > face_rounding ? past * dx : 0;
    const int above = held_nodes(min - moved, max - moved, dx).above;
    return {moved - before * dx, std::max(size + before, in_blocks(before + above + beyond + 1))};
}

Lattice<float> enlarged(const Lattice<float>& fine, Int3 from, Int3 to)
{
    const auto along = [](int nodes, int a, int b) {
        return in_blocks(int(std::ceil(double(nodes) / a * b - 1e-9)));
    };
    return {{along(fine.size.x, from.x, to.x), along(fine.size.y, from.y, to.y),
             along(fine.size.z, from.z, to.z)},
            fine.dx};
}

// Adds a shift to all positions of a scene.
void shift(Scene& scene, Vec3<double> by)
{
    if (by.x == 0 && by.y == 0 && by.z == 0) return;
    const auto move = [by](Vec3<double>& x) { x = x + by; };
    move(scene.setup.walls.min), move(scene.setup.walls.max);
    for (Object& o : scene.objects) {
        move(o.centre);
        if (!o.given) continue;
        ObjectParticles moved = *o.given;
        for (Vec3<double>& x : moved.particles) move(x);
        for (Vec3<double>& x : moved.splats) move(x);
        move(moved.middle);
        o.given = std::make_shared<const ObjectParticles>(std::move(moved));
    }
    move(scene.hands.at), move(scene.eye), move(scene.target);
    for (Caption& caption : scene.captions) move(caption.at);
}

}  // namespace

void read_domain(ObjectReader& r, Scene& scene)
{
    const double edge = r.number("edge", {0, 1000, "m", true}, 1.0);
    Int3 cells{64, 64, 64};
    const auto valid = [](double n) {
        return n >= 8 && n <= max_cells && n == std::floor(n) && int(n) % block_edge == 0;
    };
    const auto refuse = [&](const Json& found) {
        r.fail(
            "cells",
            fmt::format("a multiple of {} from 8 to {}, or three of them", block_edge, max_cells),
            described(found));
    };
    if (const Json* given = r.find("cells")) {
        int n[3];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (given->is_array() && given->size() != 3) refuse(*given);
            const Json& one = given->is_array() ? (*given)[axis] : *given;
            if (!one.is_number() || !valid(one.get<double>())) refuse(one);
            n[axis] = int(one.get<double>());
        }
        cells = {n[0], n[1], n[2]};
    }
    scene.stated_cells = cells;
    scene.setup.lattice = {cells, edge / max(cells.x, max(cells.y, cells.z))};
}

std::string cells_setting(const Json& root, int cells)
{
    const Json::json_pointer place("/domain/cells");
    const Json found = root.contains(place) ? root[place] : Json();
    double longest = 0;
    bool numbers = found.is_array() && found.size() == 3;
    for (const Json& one : found)
        numbers = numbers && one.is_number() && one > 0,
        longest = numbers ? std::max(longest, one.get<double>()) : 0;
    Json requested = cells;  // an invalid domain is rejected when the scene is read
    if (numbers) {
        requested = Json::array();
        for (const Json& one : found) {
            const double share = one.get<double>() / longest * cells / block_edge;
            requested.push_back(std::max(8, int(std::lround(share)) * block_edge));
        }
    }
    return "domain.cells=" + requested.dump();
}

WallOptions read_walls(ObjectReader& r, const WallOptions& defaults, const Lattice<double>& l)
{
    const double dx = l.dx;
    const Vec3<double> domain = extent_of(l);
    WallOptions walls = defaults;
    if (const Json* margin = r.find("margin")) refuse_margin(r, l, *margin);
    walls.min = r.vector("min", {0, 1000, "m"}, defaults.min);
    walls.max = r.vector("max", {0, 1000, "m"}, defaults.max);
    const auto check = [&](const char* axis, double from, double to, double end) {
        const double slack = 1e-9 * dx;
        if (to <= end + slack && to - from >= 2 * dx - slack) return;
        r.fail("max",
               fmt::format("{} at least 2 cells, {:.6g} m, above min's {:.6g} m, and at most the "
                           "domain's {:.6g} m",
                           axis, 2 * dx, from, end),
               fmt::format("{:.6g} m", to));
    };
    check("x", walls.min.x, walls.max.x, domain.x);
    check("y", walls.min.y, walls.max.y, domain.y);
    check("z", walls.min.z, walls.max.z, domain.z);
    r.refuse_renamed("touch", "contact_mode");
    walls.mode = r.choice("contact_mode", contact_modes, defaults.mode);
    walls.friction = r.number("friction", {0, 10}, defaults.friction);
    return walls;
}

void read_walls(ObjectReader& r, Scene& scene)
{
    const Lattice<double>& l = scene.setup.lattice;
    const double edge = l.dx * max(l.size.x, max(l.size.y, l.size.z));
    // With 64 cells: 3 nodes above the first and 4 below the end of the domain.
    const double low = edge * 3 / 64, high = edge * 4 / 64;
    WallOptions defaults{};
    defaults.min = {low, low, low};
    defaults.max = extent_of(l) - Vec3<double>{high, high, high};
    defaults.mode = ContactMode::sticky, defaults.friction = 0.4;
    scene.setup.walls = read_walls(r, defaults, l);
}

Json json_of(const WallOptions& walls)
{
    const auto triple = [](Vec3<double> v) { return Json{v.x, v.y, v.z}; };
    return {{"min", triple(walls.min)},
            {"max", triple(walls.max)},
            {"contact_mode", name_of(contact_modes, walls.mode)},
            {"friction", walls.friction}};
}

void move_in(Scene& scene)
{
    Lattice<double>& lattice = scene.setup.lattice;
    const WallOptions& walls = scene.setup.walls;
    const double dx = lattice.dx;
    const Int3 was = lattice.size;
    const Laid x = laid(walls.min.x, walls.max.x, dx, was.x),
               y = laid(walls.min.y, walls.max.y, dx, was.y),
               z = laid(walls.min.z, walls.max.z, dx, was.z);
    const Int3 now{x.size, y.size, z.size};
    if (!(now == was)) {
        lattice = {now, dx};
        scene.surface.lattice = enlarged(scene.surface.lattice, was, now);
    }
    scene.origin = {x.first, y.first, z.first};
    shift(scene, -scene.origin);
}

void move_out(Scene& scene)
{
    shift(scene, scene.origin);
    scene.origin = {};
    scene.setup.lattice.size = scene.stated_cells;
    scene.surface.lattice = stated_surface(scene);
}

Lattice<float> stated_surface(const Scene& scene)
{
    const Int3 n = scene.stated_cells;
    const int nodes = scene.surface_nodes > 0 ? scene.surface_nodes : 2 * max(n.x, max(n.y, n.z));
    return surface_lattice({n, scene.setup.lattice.dx}, nodes);
}

}  // namespace knead
