#include "host/scene/new_scene.h"

#include "host/base/json_reader.h"

namespace knead {

std::string new_scene()
{
    return R"({
    "schema": "knead.scene/1",
    "name": "new",
    // A table as large as hands reach without a zoom.
    "domain": {"edge": 0.4, "cells": 64},
    "objects": [],
    // Clay of different categories does not weld, and what is cut or torn off becomes an object.
    "contact": {"categories": "separate", "pieces": true},
    "frame_rate": 60,
    // What is added may be stiff. More substeps a frame are too slow for live work.
    "step": {"soften_beyond": 120},
    "surface": {"nodes": 128},
    "camera": {"eye": [0.5, 0.38, 0.58], "target": [0.2, 0.08, 0.2]}
}
)";
}

std::string scene_text(const std::string& path)
{
    return path == new_scene_name ? new_scene() : read_text(path, max_json_bytes);
}

}  // namespace knead
