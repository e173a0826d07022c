// What a checkpoint holds: each number of it, in bytes that do not change within a version.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/run/checkpoint.h"
#include "tests/folder.h"

namespace knead {
namespace {

class CheckpointContent : public InFolder {};

// Numbers from 1 on, each of them once.
struct Next {
    int last = 0;
    template <class T>
    void operator()(T& number)
    {
        number = T(++last);
    }
    void operator()(bool& flag) { flag = ++last % 2; }
    void operator()(Vec3<double>& v) { (*this)(v.x), (*this)(v.y), (*this)(v.z); }
    void operator()(Vec3<float>& v) { (*this)(v.x), (*this)(v.y), (*this)(v.z); }
    template <class... T>
    void all(T&... numbers)
    {
        ((*this)(numbers), ...);
    }
};

void fill(FrameStats& stats, Next& next) { each_stored_number(stats, next); }

void fill(Audit& a, Next& next)
{
    next.all(a.mass, a.volume, a.unloaded, a.kinetic, a.elastic, a.fastest, a.broken, a.hash,
             a.momentum, a.spin);
}

void fill(FrameRow& r, Next& next)
{
    next.all(r.simulated, r.hand_time, r.hands, r.wall, r.hands_wall, r.surface_wall);
    fill(r.stats, next);
    next.all(r.audited, r.crowding.particles, r.crowding.most, r.left.count, r.left.mean,
             r.left.p99, r.left.max, r.between.count, r.between.mean, r.between.p99, r.between.max,
             r.meshed, r.kept, r.mesh_volume, r.triangles, r.splats_split, r.splats_added,
             r.splats_waiting, r.cubes, r.cubes_activated, r.cubes_frozen);
    fill(r.state, next);
    r.stages = {{"p2g", 0.5}, {"grid", 0.25}};
}

void fill(SplatCloud& cloud, std::size_t count, Next& next)
{
    cloud.degree = 1, cloud.antialiased = true;
    resize(cloud, count);
    for (std::size_t i = 0; i < count; ++i) {
        next.all(cloud.centre[i], cloud.rotation[i].w, cloud.rotation[i].x, cloud.rotation[i].y,
                 cloud.rotation[i].z, cloud.scale[i], cloud.opacity[i]);
        for (std::size_t k = 0; k < 4; ++k) next(cloud.sh[4 * i + k]);
    }
}

template <class P>
void fill_strained(P& p, Next& next)
{
    next.all(p.object, p.sides, p.x);
    p.object = int(next.last % 3);
}

Checkpoint filled()
{
    Next next;
    Checkpoint c;
    c.command = {{"scene", "a.json"}, {"frames", 12}};
    c.record.rows.resize(2);
    for (int i = 0; i < 2; ++i) {
        c.record.rows[std::size_t(i)].frame = i + 1;
        fill(c.record.rows[std::size_t(i)], next);
    }
    fill(c.record.first, next);
    next.all(c.record.first_mesh_volume, c.record.wall, c.record.depths.count, c.record.depths.sum,
             c.record.depths.max, c.record.depths.bins[3], c.record.depths.bins.back());
    c.record.frames_wanted = 12;
    SavedState& s = c.state;
    s.contents.particles.resize(3), s.contents.gaussians.resize(2), s.sliding.resize(2);
    for (Particle<double>& p : s.contents.particles)
        fill_strained(p, next),
            next.all(p.v, p.C.a, p.C.b, p.C.c, p.e.xx, p.e.yy, p.e.zz, p.e.xy, p.e.xz, p.e.yz, p.k);
    for (Gaussian<double>& g : s.contents.gaussians)
        fill_strained(g, next), next.all(g.F.a, g.F.b, g.F.c);
    s.order = {2, 0, 1}, s.quiet = {7, 0, 9, 11};
    for (SlidingNode& n : s.sliding) next.all(n.place, n.force, n.time, n.impulse_deficit);
    s.quiet_low = {4, 8, 12}, s.quiet_stored = {16, 20, 24}, s.covered = true;
    next.all(s.speed_squared, s.stiffness, s.drift);
    fill(c.splats.cloud, 2, next);
    c.splats.extent.resize(2), next.all(c.splats.extent[0], c.splats.extent[1]);
    LocalState& l = c.local;
    fill(l.cloud, 4, next);
    l.active = {1, 0, 0, 1}, l.normal.resize(4), l.slot_of = {3, -1, 0, 2, 1};
    for (Vec3<float>& n : l.normal) next(n);
    l.clay = {{-5, -1}, {7, 2}}, l.objects = 3;
    return c;
}

// The facts are CBOR as nlohmann::json writes it since 3.8.
TEST_F(CheckpointContent, AFileOfVersion6HasTheSameBytesAsEver)
{
    write_checkpoint(path("filled"), filled());
    const std::string bytes = read_text(path("filled"), std::size_t(1) << 20);
    std::uint64_t sum;  // over the bytes before it
    std::memcpy(&sum, bytes.data() + bytes.size() - 8, 8);
    EXPECT_EQ(bytes.size(), 2106u);
    EXPECT_EQ(sum, 7497262924001653405u);
    write_checkpoint(path("again"), read_checkpoint(path("filled")));
    EXPECT_EQ(read_text(path("again"), std::size_t(1) << 20), bytes);
}

TEST_F(CheckpointContent, EachStoredStatisticOfAFrameIsReadAsWritten)
{
    Checkpoint c = filled();
    FrameStats& written = c.record.rows.back().stats;
    written[Count::covered] = 1, written.touched = 2, written.cut = true, written.reached = 3;
    write_checkpoint(path("filled"), c);
    const FrameStats read = read_checkpoint(path("filled")).record.rows.back().stats;
    each_statistic([&](const auto& row) {
        const FrameStats& wanted = row.stored() ? written : FrameStats{};
        EXPECT_EQ(std::memcmp(&read[row.member], &wanted[row.member], sizeof read[row.member]), 0)
            << row.name;
    });
}

// Each array that is longer or shorter by an element than its count says.
TEST_F(CheckpointContent, CountsThatDoNotFillTheBodyAreRefused)
{
    const auto refused = [&](const Checkpoint& c) {
        write_checkpoint(path("bad"), c);
        EXPECT_THROW(read_checkpoint(path("bad")), InputError);
    };
    Checkpoint c = filled();
    c.state.contents.particles.pop_back(), refused(c);
    c = filled(), c.state.order.pop_back(), refused(c);
    c = filled(), c.splats.extent.pop_back(), refused(c);
    c = filled(), c.local.active.push_back(0), refused(c);
    c = filled(), c.local.normal.pop_back(), refused(c);
    c = filled(), c.splats.cloud.degree = 2, refused(c);
    c = filled(), c.splats.cloud.degree = -1, refused(c);
}

}  // namespace
}  // namespace knead
