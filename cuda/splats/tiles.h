// Tiles of a picture, and how each lists the splats that reach it. Eight thread blocks blend a
// tile, each a part. A list *by parts* has a splat once for each part that it reaches, and each
// block its own; a *whole* one has it once, and all eight blocks look through it for what reaches
// their part.
#pragma once
#include "cuda/math/hd.h"

namespace knead {

constexpr int tile_size = 64;                     // pixels a side
constexpr int part_width = 32, part_height = 16;  // of a part [pixels]
constexpr int parts_across = tile_size / part_width;
constexpr int parts = parts_across * (tile_size / part_height);  // of a tile
constexpr int square_size = 16;  // of what is hidden or not [pixels a side]

// One of so many candidates tells how long a tile's list is.
constexpr int sampling = 32;
// An entry more costs as much as so many looks of a block at one that does not reach its part:
// about 40 ps to list it, on an H200, against 5 to 10 for a look.
constexpr int looks_an_entry = 6;
// Whole lists have about so many splats at most, for a block looks through one alone: 64 batches of
// 128, of half a microsecond each where nothing in them reaches its part.
constexpr int longest_whole = 8192;

// Whether a tile is best listed whole, of whose candidates those that were sampled are `splats`
// that reach it and `entries` of a list by parts; `blocks` of its parts are drawn. False where
// nothing is known: by parts no list is longer than what is drawn.
HD bool best_whole(unsigned splats, unsigned entries, int blocks)
{
    const long long more = (long long)entries - splats;  // if listed by parts
    const long long looks = (long long)blocks * splats - entries;
    return splats > 0 && splats <= longest_whole / sampling && more * looks_an_entry > looks;
}

}  // namespace knead
