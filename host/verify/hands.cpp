// accuracy: depth of clay left inside two hands of natural size.
#include <fmt/format.h>

#include <stdexcept>

#include "host/base/machine.h"
#include "host/hands/filter.h"
#include "host/run/run.h"
#include "host/scene/scene_hands.h"
#include "host/scene/seed.h"
#include "host/verify/verify.h"

namespace knead {
namespace {

// A ball of 0.1 m on a floor, of clay that yields at a tenth of its stiffness.
constexpr const char* ball = R"({{
    "schema": "knead.scene/1",
    "domain": {{"edge": 0.2, "cells": {}}},
    "walls": {{"min": [0.009375, 0.009375, 0.009375], "max": [0.1875, 0.1875, 0.1875]}},
    "objects": [{{
        "shape": "sphere", "centre": [0.1, 0.059375, 0.1], "diameter": 0.1,
        "material": {{"preset": "clay", "elasticity": "neo_hookean", "plasticity": "von_mises",
                     "young": 1e6, "poisson": 0.3, "yield": 1e5, "density": 1000}}
    }}],
    "hands": {{"recording": "{}", "zoom": {}, "at": [0.1, 0.059375, 0.1]}}
}})";

// Depth of particles left inside a tool at the ends of frames: 99th percentile over the cell size.
// Allowed: 0.1 mm for cells of 3.1 mm. `frames`: number of frames; 0: all.
void gesture(Verification& v, const std::string& name, double zoom, int cells, int frames = 0)
{
    Scene scene = parse_scene(fmt::format(ball, cells, name, zoom), "");
    scene.setup.threads = v.options.threads;
    build(scene, available_memory());
    const auto solver = v.solver(scene.setup);
    const HandSource hands(hands_of(scene), scene.hands);
    BatchRunOptions options;
    options.audit_every = 5, options.frames = frames;
    const RunRecord record = run_frames(scene, *solver, &hands, options, {});
    if (record.end != End::complete)
        throw std::runtime_error("the run ended early: " + record.failure);
    const Depths left = record.depths.summary();
    const double dx = scene.setup.lattice.dx;
    Check c = at_most(
        fmt::format("{}, zoom {:g}, {} cells: 99th percentile left inside", name, zoom, cells),
        left.p99 / dx, 0.1 / 3.1, "dx",
        "fingers stand in the clay by that: step.courant 0.7 leaves nothing");
    c.note = fmt::format("{:.2f} mm, at most {:.2f} mm, of {} particles in all frames looked at",
                         1e3 * left.p99, 1e3 * left.max, left.count);
    v.add(std::move(c));
}

}  // namespace

void hands_part(Verification& v)
{
    if (v.quick()) return gesture(v, "squeeze", 0.5, 24, 150);  // until the hands release the clay
    const int cells = v.options.device == "reference"     ? 24
                      : v.device.kind == DeviceKind::cuda ? 64
                                                          : 40;
    for (const char* name : {"squeeze", "imprint"})
        for (const double zoom : {0.5, 1.0}) gesture(v, name, zoom, cells);
}

}  // namespace knead
