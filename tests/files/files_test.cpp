// Meshes and particles from files: what is written is read, and what is broken is told.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/cli/verbs.h"
#include "host/files/file_kind.h"
#include "host/files/mesh_file.h"
#include "host/files/mesh_reader.h"
#include "host/files/particle_file.h"
#include "host/files/stl.h"
#include "tests/folder.h"
#include "tests/reason.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

class Files : public InFolder {};

Mesh tetrahedron()
{
    Mesh m;
    m.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    m.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    finish_mesh(m, "tetrahedron");
    return m;
}

TEST_F(Files, MeshesSurviveEveryFormat)
{
    for (const char* name : {"t.ply", "t.obj", "t.glb", "t.stl"}) {
        write_mesh(path(name), {tetrahedron()});
        const std::vector<Mesh> back = read_mesh(path(name));
        ASSERT_EQ(back.size(), 1u) << name;
        EXPECT_EQ(back[0].vertices.size(), 4u) << name;
        EXPECT_NEAR(volume(back[0]), 1.0 / 6, 1e-6) << name;
    }
    ConvertOptions c{path("t.glb"), path("u.obj"), false, true};
    EXPECT_EQ(convert_verb(c), exit_ok);
}

TEST_F(Files, CategoriesOfNamedMeshesAreReadBackFromAGlb)
{
    std::vector<Mesh> meshes(3, tetrahedron());
    meshes[0].category = 0, meshes[1].category = 7, meshes[2].category = 255;
    const auto categories = [&](const std::string& file) {
        std::vector<int> all;
        for (const Mesh& mesh : read_mesh(path(file))) all.push_back(mesh.category);
        return all;
    };
    write_mesh(path("plain.glb"), meshes);
    write_mesh(path("named.glb"), meshes, {{"ball", "left block + lid", "category 3"}, "metres"});
    EXPECT_EQ(categories("plain.glb"), (std::vector<int>{0, 7, 255}));
    EXPECT_EQ(categories("named.glb"), (std::vector<int>{0, 7, 255})) << "before the name";
    EXPECT_EQ(convert_verb({path("named.glb"), path("again.glb"), false, true}), exit_ok);
    EXPECT_EQ(read_text(path("again.glb"), 1 << 20), read_text(path("plain.glb"), 1 << 20));
    EXPECT_EQ(read_text(path("plain.glb"), 1 << 20).find("extras"), std::string::npos);
}

TEST_F(Files, AnEndingMayBeInCapitals)
{
    const std::vector<Particle<double>> particles(2);
    for (const char* name : {"T.PLY", "T.OBJ", "T.Glb", "T.STL"}) {
        write_mesh(path(name), {tetrahedron()});
        EXPECT_EQ(file_kind(path(name)), FileKind::mesh) << name;
        EXPECT_EQ(read_mesh(path(name)).size(), 1u) << name;
    }
    for (const char* name : {"P.PLY", "P.CSV"}) write_particles(path(name), particles);
    EXPECT_EQ(file_kind(path("P.PLY")), FileKind::particles);
    EXPECT_EQ(convert_verb({path("T.Glb"), path("U.OBJ"), false, true}), exit_ok);
    EXPECT_EQ(convert_verb({path("P.PLY"), path("Q.Csv"), false, true}), exit_ok);
    RecordOptions record;
    record.gesture = "squeeze", record.out = path("S.HANDS"), record.quiet = true;
    record.seconds = 0.1;
    EXPECT_EQ(record_verb(record), exit_ok);
    EXPECT_EQ(convert_verb({path("S.HANDS"), path("S.JsonL"), false, true}), exit_ok);
    EXPECT_EQ(file_kind(path("S.JsonL")), FileKind::recording);
}

TEST_F(Files, JsonIsWhatItsSchemaSays)
{
    const auto kind = [&](const std::string& text) {
        write_whole(path("x.json"), text);
        return file_kind(path("x.json"));
    };
    EXPECT_EQ(kind(R"({"schema": "knead.scene/1"})"), FileKind::scene);
    EXPECT_EQ(kind(R"({"schema": "knead.report/1"})"), FileKind::report);
    for (const char* other : {R"({"schema": "knead.scene/2"})", R"({"schema": 3})", "{}", "[1]"}) {
        const std::string why = reason<InputError>([&] { kind(other); });
        EXPECT_EQ(why.find(path("x.json") + ": /schema: expected \"knead.scene/1\""), 0u) << why;
    }
    write_whole(path("x.txt"), "words");
    const std::string why = reason<InputError>([&] { file_kind(path("x.txt")); });
    EXPECT_NE(why.find("x.txt: expected a file ending in .json"), why.npos) << why;
}

TEST_F(Files, OnlyTheStandardInputIsGivenAForm)
{
    EXPECT_EQ(with_form("a.bin", "ply"), "a.bin");
    EXPECT_EQ(with_form("-", "ply"), "-.ply");
    EXPECT_EQ(with_form("-", ".ply"), "-.ply");
}

// Whatever is cut off or flipped, a reader answers with a mesh or an InputError.
TEST_F(Files, TruncatedAndFlippedMeshesEndInAMessage)
{
    long refused = 0;
    for (const char* name : {"t.ply", "t.obj", "t.glb", "t.stl"}) {
        write_mesh(path(name), {tetrahedron()});
        const std::string whole = read_text(path(name), 1 << 20);
        const auto tried = [&](const std::string& bytes) {
            try {
                if (std::string(name) == "t.ply") to_mesh(parse_ply(bytes, name), name);
                if (std::string(name) == "t.obj") parse_obj(bytes, name);
                if (std::string(name) == "t.glb") parse_glb(bytes, name);
                if (std::string(name) == "t.stl") parse_stl(bytes, name);
            } catch (const InputError&) {
                ++refused;
            }
        };
        for (std::size_t cut = 0; cut < whole.size(); ++cut) tried(whole.substr(0, cut));
        for (std::size_t at = 0; at < whole.size(); ++at)
            for (int flip : {1, 0x80, 0xff}) {
                std::string bytes = whole;
                bytes[at] = char(bytes[at] ^ flip);
                tried(bytes);
            }
    }
    EXPECT_GT(refused, 1000);
}

TEST(Ply, AHeaderThatPromisesTooMuchIsRefusedAtOnce)
{
    const std::string head = "ply\nformat binary_little_endian 1.0\nelement vertex ";
    const std::string tail = "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    EXPECT_THROW(parse_ply(head + "4000000000" + tail, "big.ply"), InputError);
    EXPECT_THROW(parse_ply(head + "99999999999999999999" + tail, "big.ply"), InputError);
    EXPECT_THROW(parse_ply(head + "-1" + tail, "big.ply"), InputError);
}

TEST_F(Files, ParticlesKeepEveryBit)
{
    std::vector<Particle<double>> particles(100);
    for (std::size_t i = 0; i < particles.size(); ++i) {
        Particle<double>& q = particles[i];
        const double a = 0.1 * double(i + 1);
        q = {{a, 1 / a, -a},
             {a / 3, 0, 1e-300},
             {{a, 0, 1}, {2, a, 3}, {4, 5, a}},
             {a, 0, 0, 1e-9, 0, -a},
             a,
             int(i % 3),
             std::uint32_t(i)};
    }
    write_particles(path("p.ply"), particles);
    const auto back = read_particles(path("p.ply"));
    ASSERT_EQ(back.size(), particles.size());
    EXPECT_EQ(std::memcmp(back.data(), particles.data(), 100 * sizeof(Particle<double>)), 0);
    write_particles(path("p.csv"), particles);
    const auto table = read_particles(path("p.csv"));
    ASSERT_EQ(table.size(), particles.size());
    EXPECT_EQ(std::memcmp(table.data(), particles.data(), 100 * sizeof(Particle<double>)), 0);
    particles[7].x.y = std::nan("");
    for (const char* name : {"q.ply", "q.csv"}) {
        write_particles(path(name), particles);
        EXPECT_THROW(read_particles(path(name)), InputError);
    }
}

TEST(Table, WhatIsNoTableOfParticlesIsNamedWithItsLine)
{
    const auto said = [](const std::string& text) {
        return reason<InputError>([&] { parse_csv(text, "t.csv"); });
    };
    EXPECT_EQ(said("x,y,z\n1,2,3\n"), "");
    EXPECT_EQ(parse_csv("\"z\", other, y ,x\r\n\r\n1,9,2,3\r\n", "t.csv")[0].x.x, 3);
    EXPECT_EQ(said("x,y,z\n1,2\n"), "t.csv: line 2: expected 3 numbers, found 2");
    EXPECT_NE(said("x,y,z\n1,2,3,4\n").find("line 2"), std::string::npos);
    EXPECT_NE(said("x,y,z\n\n1,two,3\n").find("line 3: expected 3 numbers, found \"two\""),
              std::string::npos);
    EXPECT_NE(said("x,y,x\n").find("\"x\" again"), std::string::npos);
    EXPECT_NE(said("x,y\n1,2\n").find("\"z\""), std::string::npos);
    EXPECT_NE(said("x,y,z\n").find("found none"), std::string::npos);
    EXPECT_NE(said(""), "");
    EXPECT_NE(said("x,y,z,,\n").find("\"\" again"), std::string::npos);
    std::string wide = "x,y,z";
    for (int i = 0; i < 300; ++i) wide += ",c" + std::to_string(i);
    EXPECT_NE(said(wide).find("256 columns"), std::string::npos);
}

// Text and binary, with corners that several triangles share.
TEST_F(Files, StlIsTheSameSurfaceInBothForms)
{
    write_mesh(path("t.stl"), {tetrahedron()});
    const std::string bytes = read_text(path("t.stl"), 1 << 20);
    EXPECT_EQ(bytes.size(), 84u + 4 * 50);
    const FileMesh binary = parse_stl(bytes, "t.stl");
    std::string text = "solid a tetrahedron of 4\n";
    for (const Int3 t : binary.triangles) {
        text += "facet normal 0 0 0\n outer loop\n";
        for (const int v : {t.x, t.y, t.z}) {
            const Vec3<double> x = binary.vertices[std::size_t(v)];
            text += "  vertex " + std::to_string(x.x) + " " + std::to_string(x.y) + " +" +
                    std::to_string(x.z) + "\n";
        }
        text += " endloop\nendfacet\n";
    }
    const FileMesh read = parse_stl(text + "endsolid a tetrahedron of 4\n", "text.stl");
    EXPECT_EQ(read.vertices.size(), 4u);
    EXPECT_EQ(read.triangles.size(), 4u);
    EXPECT_NEAR(volume(read), 1.0 / 6, 1e-6);
    const auto said = [](const std::string& some) {
        return reason<InputError>([&] { parse_stl(some, "s"); });
    };
    EXPECT_NE(said(text).find("\"endsolid\", found the end"), std::string::npos);
    EXPECT_NE(said("solid\nfacet normal 0 0 1\nouter\nvertex").find("line 4"), std::string::npos);
    EXPECT_NE(said(bytes + "x").find("byte 80"), std::string::npos);
    EXPECT_NE(said("solid\nendsolid\n").find("triangles"), std::string::npos);
}

TEST_F(Files, AnOldFileSurvivesAWriteThatFails)
{
    write_whole(path("kept"), "old");
    EXPECT_THROW(write_whole(path("kept/below"), "new"), OutputError);
    EXPECT_EQ(read_text(path("kept"), 100), "old");
    write_whole(path("kept"), "new");
    EXPECT_EQ(read_text(path("kept"), 100), "new");
    EXPECT_EQ(files(), 1);
}

TEST_F(Files, AnEarlierRunsPicturesGoOnceANewOneCanReplaceThem)
{
    const std::vector<std::string> pictures{"frame_00010.png", "frame_123456.png"};
    const std::vector<std::string> others{"frame_0010.png",   "frame_000010.png",
                                          "frame_00010.png2", "frame_-0010.png",
                                          "frame_.png",       "my.png",
                                          "frame_0001a.png",  "frame_00010.PNG",
                                          "frame_ 0010.png",  "frame_99999999999.png"};
    fs::create_directories(folder / "out/pictures/frame_00020.png");  // a folder, whatever its name
    for (const auto* names : {&pictures, &others})
        for (const std::string& name : *names) write_whole(path("out/pictures/" + name), "old");
    fs::create_symlink(path("scene.json"), folder / "out/pictures/frame_00030.png");
    write_whole(path("out/frame_00010.png"), "not among the pictures");
    const auto there = [&](const std::vector<std::string>& names) {
        return std::count_if(names.begin(), names.end(), [&](const std::string& name) {
            return fs::exists(folder / "out/pictures" / name);
        });
    };
    write_whole(path("scene.json"), R"({
        "schema": "knead.scene/1", "name": "small", "domain": {"edge": 0.32, "cells": 32},
        "objects": [{"centre": [0.16, 0.16, 0.16], "diameter": 0.05, "material": "clay"}]})");
    const auto code = [](const RunOptions& o) {
        return run_and_report([&] { return run_verb(o); });
    };
    RunOptions o;
    o.scene = path("scene.json"), o.out = path("out"), o.device = "cpu", o.frames = 1;
    o.quiet = o.overwrite = true, o.settings = {"objects.0.diameter=-1"};
    EXPECT_EQ(code(o), exit_input);
    EXPECT_EQ(there(pictures), 2);
    o.settings.clear(), o.hands = path("absent.hands");
    EXPECT_NE(code(o), exit_ok);
    EXPECT_EQ(there(pictures), 2);
    o.hands.clear(), o.overwrite = false;
    ASSERT_EQ(code(o), exit_ok);
    EXPECT_EQ(there(pictures), 2);
    o.overwrite = true;
    ASSERT_EQ(code(o), exit_ok);
    EXPECT_EQ(there(pictures), 0);
    EXPECT_EQ(there(others), long(others.size()));
    EXPECT_TRUE(fs::is_directory(folder / "out/pictures/frame_00020.png"));
    EXPECT_TRUE(fs::is_symlink(folder / "out/pictures/frame_00030.png"));
    EXPECT_TRUE(fs::exists(folder / "scene.json"));
    EXPECT_TRUE(fs::exists(folder / "out/frame_00010.png"));
}

}  // namespace
}  // namespace knead
