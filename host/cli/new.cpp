// knead new: writes a commented example scene.

#include "host/base/errors.h"
#include "host/base/outputs.h"
#include "host/base/paths.h"
#include "host/base/print.h"
#include "host/cli/verbs.h"

namespace knead {
namespace {

const char* const first_scene = R"({
    "schema": "knead.scene/1",
    // A scene. Comments like this one are allowed; lengths are metres, stresses pascals.
    // All keys, with their units and ranges: docs/reference/formats.md. Any of them can be set for
    // one run:
    //     knead run THIS.json --out results --set objects.0.material.young=2e5
    "name": "first",

    // A cube of 1 m with this number of cells along an edge (--cells N); more are more accurate and
    // slower.
    "domain": {"edge": 1.0, "cells": 48},
    // The walls around the clay; the height of the floor is the second number of min.
    "walls": {"min": [0.0625, 0.0625, 0.0625], "max": [0.9375, 0.9375, 0.9375]},
    "gravity": [0, -9.81, 0],  // m/s^2

    "objects": [
        // Spheres, boxes and cylinders; "knead list presets" names the materials.
        {"name": "ball", "shape": "sphere", "centre": [0.5, 0.3125, 0.5], "diameter": 0.5,
         "material": "soft-clay"},
        // Values of a preset can be replaced. Each category has a separate mesh and colour.
        {"name": "block", "shape": "box", "centre": [0.5, 0.65, 0.5], "size": [0.16, 0.16, 0.16],
         "material": {"preset": "dough", "density": 900}, "category": 1}
    ],

    // Both hands: a gesture ("knead list gestures") or a recording in the folder of this file,
    // scaled by zoom: a hand of 0.19 m is 2.5 times as large here.
    "hands": {"recording": "squeeze", "zoom": 2.5},

    "frame_rate": 60,           // frames per second
    "surface": {"nodes": 96},   // density nodes for the mesh, along the longest axis
    "pictures": {"every": 10},  // frames between pictures; 0: none
    "camera": {"eye": [1.15, 0.85, 1.45], "target": [0.5, 0.3, 0.5]}
}
)";

}  // namespace

int new_verb(const NewOptions& o)
{
    if (!is_standard(o.out) && ending(o.out) != ".json")
        throw UsageError("SCENE: expected a file ending in .json, or -, found \"" + o.out + "\"");
    prepare_file(o.out, o.overwrite);
    write_whole(o.out, first_scene);
    if (!o.quiet && !is_standard(o.out))
        print(o.out + "\nnext: knead run " + o.out + " --out results\n");
    return exit_ok;
}

}  // namespace knead
