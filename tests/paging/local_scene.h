// A scene of splats that stand still, and are clay where two balls come near.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "host/assets/procedural_ground.h"
#include "host/paging/local_clay.h"
#include "host/paging/scene_splats.h"
#include "host/splats/generate.h"
#include "host/splats/raster.h"
#include "tests/folder.h"

namespace knead {

// A floor of splats at y = 0.2 in a domain of 1.2 m, and two balls that are moved through it as
// wanted.
class LocalScene : public InFolder, public ::testing::WithParamInterface<bool> {  // on a GPU?
  protected:
    static constexpr double frame = 1.0 / 90;
    static constexpr std::size_t room = std::size_t(1) << 32;
    using Place = Vec3<double>;

    void SetUp() override
    {
        if (GetParam() && !gpu_present()) GTEST_SKIP() << "no CUDA device";
        write_splats(path("floor.ply"), tiled_ground(20000));
        std::ofstream(path("scene.json")) << R"({"schema": "knead.scene/1",
            "gravity": [0, 0, 0], "domain": {"edge": 1.2, "cells": 48},
            "objects": [{"shape": "splats", "file": "floor.ply", "size": 1, "up": "y",
                         "centre": [0.6, 0.2, 0.6], "depth": 0.15,
                         "material": {"preset": "soft-clay", "young": 2e5, "yield": 4000}}],
            "rest": {"mode": "localized", "reach": 0.04},
            "hands": {"recording": "squeeze"}})";
        make();
    }
    void make(const std::vector<std::string>& settings = {})
    {
        scene = read_scene(path("scene.json"), settings);
        const std::vector<SplatObject> objects = load_splats(scene, room);
        build(scene, room);
        hold_balls();
        moving = std::make_unique<SplatUpkeep>(scene.upkeep, joined(objects));
        local = std::make_unique<LocalClay>(scene, 0, joined(objects, true), *moving);
        solver = made();
        number = 0;
        middle = local->slots_cloud().centre;
    }
    std::unique_ptr<EditableSimulator> made() const
    {
        return GetParam() ? gpu_solver(scene.setup, 0) : cpu_solver(scene.setup);
    }
    // Each tool is one ball, whose lowest point is there; away: it is not active.
    static constexpr double radius = 0.04;
    static constexpr Place away{0, -1e3, 0};
    void hold_balls()
    {
        Rig& rig = scene.setup.rig;
        rig = {};
        for (int tool = 0; tool < 2; ++tool) {
            Binding<float> b{};
            b.joint[0] = tool * joint_count, b.weight[0] = 1, b.radius = float(radius);
            rig.spheres.push_back(b);
            Primitive p{};
            p.count = 1, p.tool = tool;
            for (int& s : p.sphere) s = tool;
            rig.primitives.push_back(p);
        }
    }
    std::vector<Joint<double>> joints(Place a, Place b) const
    {
        std::vector<Joint<double>> all(std::size_t(int(side_count) * joint_count),
                                       {{1, 0, 0, 0}, {0, 0, 0}});
        const Place up{0, radius, 0};
        all[0].p = a + up, all[std::size_t(joint_count)].p = b + up;
        return all;
    }
    // Moves both in a straight line in so many frames.
    void move(Place a, Place a_to, Place b, Place b_to, int frames)
    {
        const std::vector<char> active{a.y > -1, b.y > -1};
        for (int f = 0; f < frames; ++f) {
            const auto at = [&](double s) {
                return joints(active[0] ? a + s * (a_to - a) : Place{},
                              active[1] ? b + s * (b_to - b) : Place{});
            };
            const Motion m{at(double(f) / frames), at(double(f + 1) / frames), active};
            last = solver->advance(m, frame);
            repaired += last[Count::repaired];
            follow(++number, m);
            most_cubes = std::max(most_cubes, report.cubes);
        }
    }
    // As `knead run`, or `beside` frames as a live session.
    void follow(int frame_number, const Motion& m)
    {
        if (!local->freezing()) moving->after(frame_number, *solver);
        if (!beside) {
            report = local->after(frame_number, m, *solver);
            return;
        }
        report = local->follow(m, *solver);
        if (report.activated == 0) local->begin_freezing(frame_number, m, *solver);
    }
    void press(Place at, double depth = 0.03)
    {
        const Place high = at + Place{0, 0.1, 0}, low = at - Place{0, depth, 0};
        move(high, low, away, away, 25), move(low, high, away, away, 15);
    }
    void leave() { move(away, away, away, away, 33); }

    // How far splats around a place lie below where they were, at the most.
    double dent(Place at, double around = 0.04) const
    {
        double most = 0;
        const SplatCloud& now = local->slots_cloud();
        for (std::size_t i = 0; i < middle.size(); ++i) {
            const Place was = cast<double>(middle[i]), d = was - at;
            if (std::hypot(d.x, d.z) < around && local->is_frozen(i))
                most = max(most, was.y - double(now.centre[i].y));
        }
        return most;
    }
    Picture seen() const
    {
        SplatFrame f;
        f.eyes = {eye_looking({0.9, 0.6, 1.2}, {0.5, 0.2, 0.5}, 0.5, 320, 240, {0, 1, 0})};
        for (const Gaussian<double>& g : solver->gaussians()) {
            f.moved_centre.push_back(cast<float>(g.x));
            f.moved_F.push_back({cast<float>(g.F.a), cast<float>(g.F.b), cast<float>(g.F.c)});
        }
        SplatCloud all;
        local->write_all(all);
        return cpu_raster(all, f).front();
    }

    Scene scene;
    std::unique_ptr<EditableSimulator> solver;  // outlives the thread of what goes back
    std::unique_ptr<SplatUpkeep> moving;
    std::unique_ptr<LocalClay> local;
    std::vector<Vec3<float>> middle;  // centres at first
    FrameStats last;
    LocalReport report;
    long repaired = 0;
    std::size_t most_cubes = 0;
    int number = 0;
    bool beside = false;
};

}  // namespace knead
