// Documents as text: what is written reads again to the bit, and what is wrong is refused with its
// place.
#include "host/document/document_text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/base/paths.h"
#include "tests/document/random.h"
#include "tests/reason.h"
#include "tests/sanitized.h"

namespace knead {
namespace {

void reads_again(const Document& wrote)
{
    const std::string text = document_text(wrote);
    const Document read = parse_document(text, "x", "");
    ASSERT_TRUE(equal(read, wrote)) << text << "\n" << document_text(read);
    ASSERT_EQ(hash(read), hash(wrote));
    ASSERT_EQ(document_text(read), text);
}

// Documents grow and shrink, from none to as many objects as there may be.
TEST(DocumentText, EveryDocumentOfCommandsReadsAsItWasWritten)
{
    const std::uint64_t seed = std::getenv("KNEAD_LONG") ? std::random_device{}() : 59;
    SCOPED_TRACE(seed);
    Random r(seed);
    const char* const files[] = {"pot.ply",         "a/../b//pot.ply", "../pot.ply",
                                 "/clay/./pot.ply", "C:\\\"pot\".ply", "ä 漢.spz"};
    DocumentPtr now = empty_room();
    IdSource ids;
    std::size_t most = 0;
    long read = 0, files_read = 0;
    const long count = repeats(sanitized ? 10000 : 60000, 5000000);
    for (long i = 0; i < count; ++i) {
        if (i % 20000 == 0) now = empty_room(), ids = IdSource();
        const bool grows = i / 2500 % 2 == 0;
        const Drawing by{0, now.get(), 0, true, true};
        const int row = r.below(10);
        Command command =
            random_command(r, by,
                           row > 3 ? std::size_t(r.below(int(command_rows.size())))
                           : (r.below(100) < 90) == grows ? Command(AddObject{}).index()
                                                          : Command(RemoveObjects{}).index());
        if (AddObject* add = std::get_if<AddObject>(&command))
            if (add->object.source.shape == ShapeKind::splats && r.one_in(2))
                add->object.source.splats.file = r.of(files), ++files_read;
        const DocumentPtr before = now;
        now = after(now, command, ids);
        most = std::max(most, now->objects.size());
        // Large ones now and then.
        if (now == before || (now->objects.size() > 8 && !r.one_in(50))) continue;
        ASSERT_NO_FATAL_FAILURE(reads_again(*now)) << i;
        ++read;
    }
    EXPECT_EQ(most, std::size_t(most_objects));
    EXPECT_GT(read, count / 200);
    EXPECT_GT(files_read, 20);
}

TEST(DocumentText, DocumentsOfScenesReadAsTheyWereWritten)
{
    for (const std::string& name : shipped_scenes())
        for (const auto& settings :
             {std::vector<std::string>{}, {"domain.cells=8"}, {"surface.nodes=2048"}}) {
            SCOPED_TRACE(name);
            try {
                reads_again(document_of(read_scene(shipped("scenes/" + name + ".json"), settings)));
            } catch (const InputError& e) {
                EXPECT_NE(std::string(e.what()).find("domain"), std::string::npos) << e.what();
            }
        }
    // At the ends of the ranges of scenes, which are wider than those of commands.
    for (const char* domain : {R"({"edge": 1000, "cells": 8})", R"({"edge": 1000, "cells": 1024})",
                               R"({"edge": 1000, "cells": [16, 12, 8]})"})
        reads_again(document_of(
            parse_scene(std::string(R"({"schema": "knead.scene/1", "domain": )") + domain +
                            R"(, "walls": {"min": [0.1, 0, 0.3], "max": [1000, 400, 400]},
                "surface": {"nodes": 2048}, "objects": [{"name": "", "centre": [1, 1, 1],
                "diameter": 1}], "hands": {"at": [-1000, 1000, 0.1]}})",
                        "scenes/x.json", {})));
}

TEST(DocumentText, RelativeFilesLieInTheFolderIfThereIsOne)
{
    Random r(3);
    IdSource ids;
    SceneObject o = random_object(r, {0, empty_room().get()});
    o.id = {}, o.category = 200, o.name = "pot", o.locked = o.hidden = false;
    o.source.shape = ShapeKind::splats, o.source.size = {};
    const auto read = [&](const std::string& file, const std::string& folder) {
        o.source.splats = {file, UpAxis::z, 0.3, 45, 0.1};
        const DocumentPtr d = after(empty_room(), AddObject{o}, ids);
        return parse_document(document_text(*d), "logs/x", folder)
            .objects.at(0)
            ->source.splats.file;
    };
    EXPECT_EQ(read("pot.ply", ""), "pot.ply");
    EXPECT_EQ(read("pot.ply", "out/a"), "out/a/pot.ply");
    EXPECT_EQ(read("/clay/../pot.ply", "out"), "/clay/../pot.ply");
}

// A document with an object of each shape.
Json good()
{
    Random r(12);
    IdSource ids;
    DocumentPtr d = empty_room();
    for (const auto& [name, shape] : shape_kinds) {
        SceneObject o;
        o.name = name, o.material = material_spec("clay"), o.pose.p = {0.5, 0.5, 0.5};
        o.source.shape = shape, o.source.size = {0.1, 0.1, 0.1};
        if (shape == ShapeKind::torus) o.source.size.y = 0.04;
        if (shape == ShapeKind::text) o.source.text = "a";
        if (shape == ShapeKind::strand)
            o.source.strand = std::make_shared<const Strand>(
                Strand{SectionKind::star, 0.1, {}, {{}, {{0.1, 0, 0}, {}}}, true});
        if (shape == ShapeKind::mesh) o.source.mesh = {"cup.stl", UpAxis::z, 0, 0.1, 0, 0};
        if (shape == ShapeKind::splats) o.category = 7, o.source.splats = {"pot.ply"};
        if (shape == ShapeKind::splats) o.source.splats.size = 0.1;
        d = after(d, AddObject{o}, ids);
    }
    return parse_json(document_text(*d), "x");
}
std::string refusal(const Json& document)
{
    return reason<InputError>([&] { parse_document(document.dump(), "a", ""); });
}

TEST(DocumentText, WhatIsWrongIsSaidWithItsPlace)
{
    ASSERT_EQ(good()["objects"].size(), shape_kinds.size());
    ASSERT_EQ(refusal(good()), "");
    const std::pair<const char*, Json> all[] = {
        {"/objects", nullptr},
        {"/objects", Json::object()},
        {"/objects", Json(std::vector<Json>(257, good()["objects"][0]))},
        {"/objects/0", 7},
        {"/objects/0/id", 0},
        {"/objects/0/id", 2147483648u},
        {"/objects/0/id", 1.5},
        {"/objects/1/id", 1},
        {"/objects/2/id", 1},
        {"/objects/3/category", 0},
        {"/objects/1/category", 256},
        {"/objects/1/category", -1},
        {"/objects/1/centre", {0, 1001, 0}},
        {"/objects/1/rotation", {1, 1, 0, 0}},
        {"/objects/1/size", {0, 1, 1}},
        {"/objects/1/material/young", -1},
        {"/objects/1/material/preset", "caly"},
        {"/objects/1/per_cell", 1},
        {"/objects/1/velocity", {0, 0, 1e4}},
        {"/objects/1/locked", 1},
        {"/objects/1/colour", 1},
        {"/objects/3/file", ""},
        {"/objects/3/file", 7},
        {"/objects/3/up", "w"},
        {"/gravity", {0, 0, 1001}},
        {"/gravity", {0, 0}},
        {"/walls/min", {1, 0, 0}},
        {"/walls/max", {1, 1, 1002}},
        {"/walls/contact_mode", "slippy"},
        {"/walls/friction", 11},
        {"/walls/colour", 1},
        {"/cells", 7},
        {"/cells", 1025},
        {"/cells", "16"},
        {"/surface", 7},
        {"/surface", 100000},
        {"/hands", 1},
        {"/hands/left", false},
        {"/hands/left/held", "spoon"},
        {"/hands/right/present", 1},
        {"/hands/zoom", 0},
        {"/hands/at", {0, 0, 1e4}},
        {"/hands/colour", 1},
        {"/colour", 1}};
    for (const auto& [pointer, value] : all) {
        Json bad = good();
        bad[Json::json_pointer(pointer)] = value;
        const std::string why = refusal(bad);
        const std::string place =
            std::string(pointer) == "/walls/min" ? "/walls/max" : std::string(pointer);
        EXPECT_EQ(why.find("a: " + place), 0u) << pointer << " " << value << ": " << why;
        EXPECT_LT(why.size(), 400u);
    }
    Json deep = good();
    deep["objects"][3]["depth"] = 0.1, deep["objects"].push_back(deep["objects"][3]);
    const std::size_t last = deep["objects"].size() - 1;
    deep["objects"][last]["id"] = last + 1;
    EXPECT_EQ(refusal(deep).find(fmt::format("a: /objects/{}/depth", last)), 0u) << refusal(deep);
}

// Whatever key of a document lacks but those that have a default in a scene's object.
TEST(DocumentText, EveryKeyIsNeeded)
{
    long missing = 0;
    const Json flat = good().flatten();
    for (const auto& [pointer, value] : flat.items()) {
        Json bad = good();
        const Json::json_pointer at(pointer);
        Json& parent = bad[at.parent_pointer()];
        if (parent.is_array()) continue;
        parent.erase(at.back());
        const bool object = pointer.starts_with("/objects");
        if (object && at.back() != "id" && at.back() != "diameter" && at.back() != "height")
            continue;
        EXPECT_EQ(refusal(bad).find("a: " + pointer + ": expected"), 0u) << pointer;
        ++missing;
    }
    for (const char* key : {"objects", "gravity", "walls", "hands"}) {
        Json bad = good();
        bad.erase(key);
        EXPECT_EQ(refusal(bad).find(std::string("a: /") + key + ": expected"), 0u) << key;
    }
    EXPECT_GT(missing, 13);
}

TEST(DocumentText, HostileTextsAreRefusedInShort)
{
    const std::string text = good().dump();
    const auto why = [](const std::string& of) {
        return reason<InputError>([&] { parse_document(of, "a", ""); });
    };
    for (std::size_t size = 0; size < text.size(); ++size)
        ASSERT_NE(why(text.substr(0, size)), "") << size;
    // A byte that is another: an error, or a document that reads again.
    long accepted = 0;
    for (std::size_t at = 0; at < text.size(); ++at)
        for (const int bit : {0, 1, 2, 4, 7}) {
            std::string other = text;
            other[at] = char(other[at] ^ 1 << bit);
            try {
                const Document read = parse_document(other, "a", "");
                ASSERT_NO_FATAL_FAILURE(reads_again(read)) << other;
                ++accepted;
            } catch (const InputError& e) {
                ASSERT_LT(std::string(e.what()).size(), 500u);
            }
        }
    EXPECT_GT(accepted, 10);
    for (const std::string& hostile :
         {std::string(100000, '['), std::string(100000, '{'),
          "{\"objects\": " + std::string(9999, '['), std::string("[]"), std::string("7"),
          std::string(), "{\"" + std::string(1 << 20, 'n') + "\": 1}"}) {
        EXPECT_EQ(why(hostile).find("a: "), 0u) << hostile.substr(0, 40);
        EXPECT_LT(why(hostile).size(), 1000u) << hostile.substr(0, 40);
    }
}

}  // namespace
}  // namespace knead
